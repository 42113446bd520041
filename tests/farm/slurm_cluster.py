"""A Slurm of one node on the loopback address, for as long as a `with` lasts: no accounting, no
prolog, all state in a folder of its own, own ports, own munge key and socket. Needs root.

    with Cluster(folder) as cluster:
        cluster.run("sbatch", "job.sh")

Whatever happens to the process that started it, nothing stays: every process of the cluster and of
its jobs has MARK=FOLDER in its environment or a file of the folder open, by which a watchman finds
them when that process ends.
"""
import os
import pathlib
import shutil
import signal
import socket
import subprocess
import sys
import time

MARK = "PVOL_SLURM_FOLDER"
NODE = "pvolnode"
PROGRAMS = ["munged", "slurmctld", "slurmd", "sbatch", "squeue", "scontrol", "scancel"]

CONFIGURATION = """
ClusterName=pvol
SlurmctldHost={host}(127.0.0.1)
SlurmctldPort={controller}
SlurmdPort={daemon}
AuthType=auth/munge
AuthInfo=socket={folder}/munge.socket,cred_expire=5
CredType=cred/munge
SlurmUser=root
SlurmdUser=root
StateSaveLocation={folder}/state
SlurmdSpoolDir={folder}/spool
SlurmctldPidFile={folder}/slurmctld.pid
SlurmdPidFile={folder}/slurmd.pid
SlurmctldLogFile={folder}/slurmctld.log
SlurmdLogFile={folder}/slurmd.log
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
JobAcctGatherType=jobacct_gather/none
AccountingStorageType=accounting_storage/none
JobCompType=jobcomp/filetxt
JobCompLoc={folder}/jobs.txt
MpiDefault=none
SelectType=select/cons_tres
SelectTypeParameters=CR_CPU
SchedulerType=sched/backfill
SchedulerParameters=sched_interval=2,bf_interval=2,batch_sched_delay=0
MailProg=/bin/true
ReturnToService=2
JobRequeue=1
KillWait=10
MaxArraySize={largest_array}
SlurmdParameters=config_overrides
NodeName={node} NodeHostName={host} NodeAddr=127.0.0.1 CPUs={cpus} State=UNKNOWN
PartitionName=all Nodes={node} Default=YES MaxTime=INFINITE State=UP
"""


def why_not():
    """Why a cluster cannot be started here, or None."""
    os.environ["PATH"] += ":/usr/sbin:/sbin"
    if os.geteuid() != 0:
        return "a Slurm that starts tasks wants root, and this is another user"
    missing = [program for program in PROGRAMS if not shutil.which(program)]
    if missing:
        return f"{', '.join(missing)}: not installed (Debian: slurmctld slurmd slurm-client munge)"
    return None


def belongs(process, folder):
    if f"{MARK}={folder}".encode() in (process / "environ").read_bytes().split(b"\0"):
        return True
    # slurmstepd writes its title over its environment.
    links = [process / "cwd", *(process / "fd").iterdir()]
    return any(os.readlink(link).startswith(f"{folder}/") for link in links)


def marked(folder):
    """Processes of the cluster in this folder and of its jobs."""
    found = []
    for process in pathlib.Path("/proc").iterdir():
        if not process.name.isdigit() or int(process.name) == os.getpid():
            continue
        try:
            if belongs(process, folder):
                found.append(int(process.name))
        except OSError:  # it is gone
            pass
    return found


def end_all(folder):
    """Ends them: those that start others may do so while we look, so until none is left."""
    for _ in range(100):
        processes = marked(folder)
        if not processes:
            return
        for process in processes:
            try:
                os.kill(process, signal.SIGKILL)
            except ProcessLookupError:
                pass
        time.sleep(0.05)


def start_watchman(folder):
    """A process that belongs to nobody and ends the cluster once the pipe to it is shut, be it by
    the death of who holds it."""
    ours_to_read, ours = os.pipe()
    os.set_inheritable(ours, False)
    if os.fork() > 0:
        os.wait()
        os.close(ours_to_read)
        return ours
    os.close(ours)
    os.setsid()
    if os.fork() > 0:
        os._exit(0)
    nothing = os.open(os.devnull, os.O_RDWR)
    for stream in (0, 1, 2):  # nobody shall wait for the end of what we would say
        os.dup2(nothing, stream)
    os.read(ours_to_read, 1)
    end_all(folder)
    os._exit(0)


def free_ports(count):
    sockets = [socket.socket() for _ in range(count)]
    for s in sockets:
        s.bind(("127.0.0.1", 0))
    ports = [s.getsockname()[1] for s in sockets]
    for s in sockets:
        s.close()
    return ports


class Cluster:
    def __init__(self, folder, largest_array=1001, timeout=120):
        self.folder = pathlib.Path(folder).resolve()
        self.timeout = timeout  # seconds to come up
        self.environment = {**os.environ, MARK: str(self.folder),
                            "SLURM_CONF": str(self.folder / "slurm.conf")}
        self.largest_array = largest_array
        self.daemons = []
        self.watchman = None

    def __enter__(self):
        self.watchman = start_watchman(self.folder)
        try:
            self.start()
        except BaseException:
            self.stop()
            raise
        return self

    def __exit__(self, *_):
        self.stop()

    def start(self):
        for name in ("state", "spool"):
            (self.folder / name).mkdir(parents=True)
        self.folder.chmod(0o755)
        controller, daemon = free_ports(2)
        text = CONFIGURATION.format(host=socket.gethostname().split(".")[0], node=NODE,
                                    folder=self.folder, controller=controller, daemon=daemon,
                                    cpus=os.cpu_count(), largest_array=self.largest_array)
        (self.folder / "slurm.conf").write_text(text)
        key = self.folder / "munge.key"
        key.write_bytes(os.urandom(128))
        key.chmod(0o400)
        munge = {name: self.folder / f"munge.{name}" for name in ("socket", "pid", "log", "seed")}
        self.begin("munged", "--foreground", "--force", f"--key-file={key}",
                   f"--socket={munge['socket']}", f"--pid-file={munge['pid']}",
                   f"--log-file={munge['log']}", f"--seed-file={munge['seed']}")
        self.wait_until(munge["socket"].exists, "munged listens")
        self.begin("slurmctld", "-D", "-c")
        self.begin("slurmd", "-D", "-N", NODE)
        self.wait_until(lambda: self.run("sinfo", "-h", "-o", "%T", check=False).strip() == "idle",
                        "the node is idle")

    def begin(self, *command):
        log = open(self.folder / f"{command[0]}.out", "wb")
        self.daemons.append(subprocess.Popen(command, env=self.environment, stdout=log,
                                             stderr=subprocess.STDOUT, stdin=subprocess.DEVNULL))

    def wait_until(self, holds, what, timeout=None):
        end = time.monotonic() + (timeout or self.timeout)
        while not holds():
            if self.daemons and any(d.poll() is not None for d in self.daemons):
                raise RuntimeError(f"a daemon ended before {what}\n{self.logs()}")
            if time.monotonic() > end:
                raise RuntimeError(f"waited in vain until {what}\n{self.logs()}")
            time.sleep(0.1)

    def run(self, *command, check=True, **more):
        """What a client's command prints."""
        done = subprocess.run(command, env=self.environment, text=True, stdin=subprocess.DEVNULL,
                              stdout=subprocess.PIPE, stderr=subprocess.PIPE, **more)
        if check and done.returncode != 0:
            raise RuntimeError(f"{' '.join(map(str, command))}: status {done.returncode}\n"
                               f"{done.stdout}{done.stderr}\n{self.logs()}")
        return done.stdout

    def succeeds(self, *command):
        return subprocess.run(command, env=self.environment, stdin=subprocess.DEVNULL,
                              stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL).returncode == 0

    def ended(self):
        """Of each job or task of an array that ended, by its id: all states that it ended in, such
        as REQUEUED, COMPLETED."""
        states, file = {}, self.folder / "jobs.txt"
        for line in file.read_text().splitlines() if file.exists() else []:
            fields = dict(field.split("=", 1) for field in line.split() if "=" in field)
            states.setdefault(fields["JobId"], []).append(fields["JobState"])
        return states

    def logs(self):
        parts = []
        for log in sorted(self.folder.glob("*.out")) + sorted(self.folder.glob("*.log")):
            lines = log.read_text(errors="replace").splitlines()[-30:]
            parts.append(f"--- {log.name}\n" + "\n".join(lines))
        return "\n".join(parts)

    def stop(self):
        end_all(self.folder)
        for daemon in self.daemons:
            daemon.wait()
        os.close(self.watchman)  # it finds nothing


if __name__ == "__main__":
    sys.exit(why_not())
