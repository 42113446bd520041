"""What pvol-render --split --for slurm prints, in a real Slurm: slurm_test.py FOLDER_OF_TOOLS

A sequence of frames in parts; one part is killed, one queued again and one warned of a limit on time
while they run, and the merged frames have the bytes of those rendered at home. Exits with 77 and says why where there is no Slurm.
"""
import os
import pathlib
import re
import shutil
import signal
import subprocess
import sys
import tempfile
import time

from slurm_cluster import Cluster, marked, why_not

SKIPPED = 77
FRAMES, PARTS = [1, 2], 3
PATIENCE = 900  # seconds for whatever is waited for, on a machine with much else to do
RECIPE = """[recipe]
resolution = 24
density = {}
[[form]]
shape = "ellipsoid"
centre = [0, 0, 0]
radii = {}
"""
# One thread, so that a part takes seconds on any machine.
RENDER = ["smoke.####.toml", "-o", "smoke.####.exr", "--frames", "1-2", "--size", "120x80", "--spp",
          os.environ.get("PVOL_FARM_SPP", "600"), "--threads", "1"]


def make_frames(folder):
    folder.mkdir()
    for frame in FRAMES:
        (folder / f"smoke.{frame:04}.toml").write_text(RECIPE.format(0.5 * frame, frame))
    return folder


def expect(holds, what):
    if not holds:
        raise AssertionError(what)


def part_process(cluster, stem, frame):
    """The renderer that works on a part, or None."""
    for process in marked(cluster.folder):
        try:
            words = pathlib.Path(f"/proc/{process}/cmdline").read_text().split("\0")
        except OSError:
            continue
        if "--frame" in words and words[words.index("--frame") + 1] == str(frame):
            if any(stem in word for word in words) and "task.sh" not in " ".join(words):
                return process
    return None


def catches(process, number):
    """Whether a process has a handler for the signal, or a thread that waits for it."""
    try:
        status = pathlib.Path(f"/proc/{process}/status").read_text()
    except OSError:
        return False
    masks = re.findall(r"Sig(?:Cgt|Blk):\s*(\w+)", status)
    return any(int(mask, 16) >> (number - 1) & 1 for mask in masks)


def kill_after_checkpoint(cluster, work, stem, frame):
    """Lets the renderer of a part write what it has, and kills it."""
    def written():
        process = part_process(cluster, stem, frame)
        if process and catches(process, signal.SIGUSR1):
            try:
                os.kill(process, signal.SIGUSR1)
            except ProcessLookupError:
                pass
        return list(work.glob(f"smoke.parts/{frame:04}/{stem}*.exr"))
    cluster.wait_until(written, f"a checkpoint of {stem} of frame {frame}", PATIENCE)
    process = part_process(cluster, stem, frame)
    expect(process, f"{stem} was done before it could be killed; raise PVOL_FARM_SPP")
    os.kill(process, signal.SIGKILL)


def running_part(cluster, but=()):
    """The job of a part that runs, and is none of these; None where none does."""
    lines = cluster.run("squeue", "-h", "-r", "-t", "RUNNING", "-o", "%A %j").splitlines()
    jobs = [line.split()[0] for line in lines if line.endswith(" pvol-parts")]
    return next((job for job in jobs if job not in but), None)


def queue_again_while_it_runs(cluster):
    """Has Slurm end some part and begin it again; returns the job."""
    requeued = []

    def succeeds():
        job = running_part(cluster)
        if job and cluster.succeeds("scontrol", "requeue", job):
            requeued.append(job)
        return requeued
    cluster.wait_until(succeeds, "some part runs and is queued again", PATIENCE)
    return requeued[0]


def warn_of_time_limit(cluster, work, but):
    """Sends some part what Slurm sends before a limit on time ends it."""
    def is_renderer(pid):
        try:
            words = pathlib.Path(f"/proc/{pid}/cmdline").read_text()
        except OSError:
            return False
        return "pvol-render" in words and catches(pid, signal.SIGTERM)

    def renders(job):
        text = cluster.run("scontrol", "listpids", job, check=False)
        return any(map(is_renderer, re.findall(r"^(\d+)", text, re.MULTILINE)))

    def warned():
        job = running_part(cluster, but)
        if job and renders(job):
            cluster.run("scancel", "--batch", "--signal=USR1", job)
            return True
        return False
    cluster.wait_until(warned, "some part runs and is warned", PATIENCE)
    cluster.wait_until(lambda: any("status 1; queued again" in t for t in task_logs(work).values()),
                       "the part that was warned is queued again", PATIENCE)


def submit(cluster, work, tools):
    """Runs what the split prints, and returns the numbers of tasks in each array."""
    script = cluster.run(tools / "pvol-render", *RENDER, "--split", str(PARTS), "--for", "slurm",
                         cwd=work)
    (work / "farm.sh").write_text(script)
    said = cluster.run("bash", "farm.sh", "--time=60", cwd=work)
    counts = dict(re.findall(r"^([\w-]+): (\d+) tasks", said, re.MULTILINE))
    expect(counts == {"parts": str(len(FRAMES) * PARTS), "merges": str(len(FRAMES))}, said)


def wait_for_all(cluster):
    cluster.wait_until(lambda: not cluster.run("squeue", "-h"), "no job is left", PATIENCE)


def task_logs(work):
    return {log: log.read_text() for log in sorted(work.glob("smoke.parts/*.log"))}


def expect_same_bytes(work, home):
    for frame in FRAMES:
        for kind in ("exr", "png"):
            name = f"smoke.{frame:04}.{kind}"
            ours = work / name
            expect(ours.exists(), f"{name} was not merged: {task_logs(work)}")
            expect(ours.read_bytes() == (home / name).read_bytes(), f"{name} has other bytes")


def render_on_farm(folder, tools):
    home = make_frames(folder / "home")
    subprocess.run([tools / "pvol-render", *RENDER, "--quiet"], cwd=home, check=True)
    work = make_frames(folder / "work")
    # Arrays of four: those of the parts are cut in two.
    with Cluster(folder / "slurm", largest_array=4) as cluster:
        submit(cluster, work, tools)
        kill_after_checkpoint(cluster, work, "part.0001", frame=1)
        requeued = queue_again_while_it_runs(cluster)
        warn_of_time_limit(cluster, work, but=[requeued])
        wait_for_all(cluster)
        expect_same_bytes(work, home)
        states = cluster.ended()
        print("tasks ended:", states)
        expect(sum(len(s) > 1 for s in states.values()) >= 2, "tasks ran more than once")
        expect(all(s[-1] == "COMPLETED" for s in states.values()), "all tasks end well")
        logs = task_logs(work).values()
        expect(any("status 137; queued again" in text for text in logs), "a task was killed")

        # Once more: there is nothing left to do but to merge.
        before = {f: f.stat().st_mtime_ns for f in work.glob("smoke.parts/*/part.*.exr")}
        submit(cluster, work, tools)
        wait_for_all(cluster)
        expect_same_bytes(work, home)
        expect(before == {f: f.stat().st_mtime_ns for f in before}, "finished parts stay as they are")
    expect(not marked(folder / "slurm"), "processes are left")


def die_with_a_cluster(folder):
    """Nothing may be left of a cluster whose owner is killed."""
    owner = os.fork()
    if owner == 0:
        Cluster(folder).__enter__()
        os.kill(os.getpid(), signal.SIGKILL)
    os.waitpid(owner, 0)
    end = time.monotonic() + PATIENCE
    while marked(folder):
        expect(time.monotonic() < end, "the watchman leaves processes")
        time.sleep(0.1)


def main():
    reason = why_not()
    if reason:
        print("skipped:", reason)
        return SKIPPED
    tools = pathlib.Path(os.environ.get("PVOL_FARM_TOOLS", sys.argv[1])).resolve()
    folder = pathlib.Path(tempfile.mkdtemp(prefix="pvol-farm-"))
    try:
        die_with_a_cluster(folder / "dies")
        render_on_farm(folder, tools)
    finally:
        shutil.rmtree(folder, ignore_errors=True)
    print("merged on the farm: the same bytes")
    return 0


if __name__ == "__main__":
    sys.exit(main())
