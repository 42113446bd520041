#!/usr/bin/env python3
"""Cost at equal noise of flights one by one and in lanes, on one thread, in turn in one run.

  kernels.py PVOL_RENDER CLOUD [--old REVISION] [--rounds N] [--size N] [--spp N] [--set KEY=VALUE]... [--case I]...

Renders samples/peer_scene.toml with the cloud, with forward and with isotropic scattering and under the sky
alone, by every kernel that the machine has, guided and not. Prints for each

  us     CPU time of a camera sample: that of a long picture less that of a short one, so that loading and the
         guide's photons do not count; the least of the rounds
  noise  variance of one sample's luminance
  E      their product, the cost of a picture of given noise, and its ratio to guided paths of flights one by one
  all    CPU seconds of the whole command for the long picture, loading and photons included
  MB     peak memory

--old builds a revision of the repository, in a folder beside this build, and measures its guided paths as the
first row of each table, to which ratios then are.

Figures belong to one machine on one day: quote the ratios.
"""
import argparse
import json
import os
import pathlib
import subprocess
import sys
import tempfile

ROOT = pathlib.Path(__file__).resolve().parents[2]
SCENE = ROOT / "samples" / "peer_scene.toml"
CASES = [
    ("g = 0.877", []),
    ("g = 0", ["--set", "medium.g=0"]),
    ("g = 0.877, sky alone", ["--set", "sun.irradiance=0"]),
    ("g = 0.877, no more than one scattering", ["--set", "render.max_bounces=1"]),
]


def build(revision):
    """pvol-render of another revision, built once."""
    folder = ROOT / "build" / f"old-{revision}"
    program = folder / "build" / "tools" / "pvol-render"
    if not program.exists():
        source = folder / "source"
        source.mkdir(parents=True, exist_ok=True)
        files = subprocess.run(["git", "-C", ROOT, "archive", revision], check=True, capture_output=True).stdout
        subprocess.run(["tar", "-x", "-C", source], input=files, check=True)
        subprocess.run(["cmake", "-S", source, "-B", folder / "build", "-G", "Ninja", "-DCMAKE_BUILD_TYPE=Release",
                        "-DPVOL_ARCH=native", "-DPVOL_WITH_CGAL=OFF", "-DPVOL_BUILD_TESTS=OFF"],
                       check=True, stdout=subprocess.DEVNULL)
        subprocess.run(["cmake", "--build", folder / "build", "--target", "pvol-render"], check=True,
                       stdout=subprocess.DEVNULL)
    return str(program)


def run(command):
    """CPU seconds and peak memory in MB of a command; none where it refuses."""
    process = subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE)
    errors = process.stderr.read().decode()
    _, status, usage = os.wait4(process.pid, 0)
    process.returncode = os.waitstatus_to_exitcode(status)
    if process.returncode != 0:
        raise RuntimeError(errors.strip().splitlines()[-1])
    return usage.ru_utime + usage.ru_stime, usage.ru_maxrss / 1024


class Configuration:
    """A program with its options, and what was measured of it."""

    def __init__(self, name, program, options):
        self.name, self.command = name, [program, str(SCENE), *options]
        self.seconds, self.noise, self.mean, self.megabytes = {}, 0, 0, 0

    def measure(self, spp, folder):
        seconds, megabytes = run([*self.command, "--spp", str(spp), "--threads", "1", "--quiet", "--no-png",
                                  "-o", str(folder / "a.exr")])
        self.seconds[spp] = min(seconds, self.seconds.get(spp, seconds))
        self.megabytes = max(self.megabytes, megabytes)

    def look_at_noise(self, spp, folder):
        stats = folder / "stats.json"
        run([*self.command, "--spp", str(spp), "--quiet", "--no-png", "-o", str(folder / "a.exr"),
             "--stats", str(stats)])
        weights = (0.2126, 0.7152, 0.0722)
        read = json.loads(stats.read_text())
        # The report has the variance of a pixel's mean.
        self.noise = spp * sum(w * v for w, v in zip(weights, read["variance_rgb"]))
        self.mean = sum(w * v for w, v in zip(weights, read["mean_rgb"]))


def configurations(arguments, old, options):
    all = []
    size = ["--size", f"{arguments.size}x{arguments.size}"]
    options = [*size, "--set", f"volume.file={arguments.cloud}", *options]
    if old:
        all.append(Configuration(f"{arguments.old}, guided", old, [*options, "--guide", "on"]))
    for kernel in ("scalar", "avx2", "avx512"):
        for guide in ("on", "off"):
            name = f"{kernel}, {'guided' if guide == 'on' else 'plain'}"
            all.append(Configuration(name, arguments.program, [*options, "--kernel", kernel, "--guide", guide]))
    all.append(Configuration("auto", arguments.program, options))
    return all


def table(title, all, arguments, folder):
    short, long = arguments.spp // 4, arguments.spp
    left = []
    for c in all:
        try:
            c.look_at_noise(arguments.spp, folder)
            left.append(c)
        except RuntimeError as error:
            print(f"{c.name}: {error}", file=sys.stderr)
    for _ in range(arguments.rounds):
        for c in left:
            c.measure(short, folder)
            c.measure(long, folder)
    samples = arguments.size ** 2 * (long - short)
    print(f"\n{title}\n\n| | us | noise | E | E, ratio | all, s | MB | mean |\n|---|---|---|---|---|---|---|---|")
    reference = None
    for c in left:
        us = 1e6 * (c.seconds[long] - c.seconds[short]) / samples
        cost = us * c.noise
        reference = reference or cost
        print(f"| {c.name} | {us:.2f} | {c.noise:.4g} | {cost:.3g} | {cost / reference:.3f} | "
              f"{c.seconds[long]:.2f} | {c.megabytes:.0f} | {c.mean:.4f} |", flush=True)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("program")
    parser.add_argument("cloud")
    parser.add_argument("--old", help="revision to build and to compare with")
    parser.add_argument("--rounds", type=int, default=3)
    parser.add_argument("--size", type=int, default=128)
    parser.add_argument("--spp", type=int, default=64)
    parser.add_argument("--set", action="append", default=[], help="a value of the scene, KEY=VALUE")
    parser.add_argument("--case", type=int, action="append", help="number of a case, from 0; all by default")
    arguments = parser.parse_args()
    arguments.cloud = str(pathlib.Path(arguments.cloud).resolve())
    old = build(arguments.old) if arguments.old else None
    with tempfile.TemporaryDirectory() as folder:
        for i, (title, options) in enumerate(CASES):
            if arguments.case and i not in arguments.case:
                continue
            for value in arguments.set:
                options = [*options, "--set", value]
            table(title, configurations(arguments, old, options), arguments, pathlib.Path(folder))


if __name__ == "__main__":
    main()
