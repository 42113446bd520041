#!/usr/bin/env python3
"""Instructions per camera sample: of every tracker and estimator of shadow rays, or of two builds.

  instructions.py PVOL_RENDER INPUT [OPTION...]
  instructions.py --compare OLD_PVOL_RENDER NEW_PVOL_RENDER INPUT [OPTION...]

Runs pvol-render under callgrind, which counts what the tiles of a picture execute, 16 samples in each of
16 x 16 pixels unless the options say otherwise, and prints it beside the counts of the work and the
bytes that look-ups, bounds tests and segments read. The numbers are the same on every machine; the
program must be one that valgrind can run: build it with -DPVOL_ARCH=x86-64-v3 -DPVOL_WITH_CGAL=OFF
(it knows no AVX-512) and -DCMAKE_CXX_FLAGS=-g1.

--compare renders the input with both programs, once with --guide off and once with --guide on, and prints
the instructions per sample of each and their ratio; it fails where a ratio is off 1 by more than 1 %. Say
  instructions.py --compare old/pvol-render new/pvol-render samples/peer_scene.toml --set volume.file=CLOUD
The few hundred paths of the forecast count as well: take 64 x 64 pixels and 16 samples or more to see less.
"""
import json
import pathlib
import subprocess
import sys
import tempfile

TRACKERS = ["delta-global", "delta", "decomposition", "weighted-delta", "weighted-decomposition", "regular"]
CONFIGURATIONS = (
    [(t, "ratio", "none") for t in TRACKERS]
    + [(t, "analog", "none") for t in TRACKERS]
    + [("decomposition", t, "none") for t in ("residual-ratio", "regular")]
    + [("decomposition", t, m) for t in ("analog", "ratio") for m in ("2", "1")]
)
# A look-up reads eight floats, a bounds test a pair of bytes and a scale, a segment a node and an entry.
BYTES = {"lookups": 32, "bounds_tests": 10, "segments": 32}
LARGEST_CHANGE = 0.01  # of --compare


def measure(program, arguments, folder, *report):
    """Instructions in the tiles."""
    counts = folder / "counts"
    # Those of the kernels of AVX2, which valgrind runs.
    inside = [f"--toggle-collect={result} pvol::detail::N_AVX2::trace*" for result in ("bool", "void")]
    command = ["valgrind", "--tool=callgrind", *inside, f"--callgrind-out-file={counts}",
               program, *arguments, "--threads", "1", "--quiet", *report, "-o", str(folder / "a.exr"), "--no-png"]
    run = subprocess.run(command, capture_output=True, text=True)
    if run.returncode != 0:
        raise SystemExit(f"instructions.py: {' '.join(command)} failed:\n{run.stderr}")
    totals = [line for line in counts.read_text().splitlines() if line.startswith("totals:")]
    return int(totals[0].split()[1])


def measure_counting(program, arguments, folder):
    """The same while the work is counted, and the statistics that pvol-render wrote."""
    stats = folder / "stats.json"
    return measure(program, arguments, folder, "--stats", str(stats)), json.loads(stats.read_text())


def count_samples(arguments):
    """Those that --size and --spp ask for."""
    value = dict(zip(arguments, arguments[1:]))
    width, height = value["--size"].split("x")
    return int(width) * int(height) * int(value["--spp"])


def compare(old, new, arguments):
    """Both programs on the same input, plain and guided; returns the exit status."""
    print(f"{'paths':10}{'old':>12}{'new':>12}{'new/old':>10}   instructions per camera sample")
    status, samples = 0, count_samples(arguments)
    with tempfile.TemporaryDirectory() as name:
        for paths, guide in (("plain", "off"), ("guided", "on")):
            a, b = (measure(program, arguments + ["--guide", guide], pathlib.Path(name)) for program in (old, new))
            status |= abs(b / a - 1) > LARGEST_CHANGE
            print(f"{paths:10}{a / samples:12.0f}{b / samples:12.0f}{b / a:10.4f}", flush=True)
    return status


def with_size(arguments):
    """The options with a small picture, unless they ask for another."""
    for option, value in (("--size", "16x16"), ("--spp", "16")):
        if option not in arguments:
            arguments = arguments + [option, value]
    return arguments


def main():
    if sys.argv[1:2] == ["--compare"] and len(sys.argv) >= 5:
        raise SystemExit(compare(sys.argv[2], sys.argv[3], with_size(sys.argv[4:])))
    if len(sys.argv) < 3 or sys.argv[1].startswith("-"):
        raise SystemExit(__doc__)
    program, arguments = sys.argv[1], with_size(sys.argv[2:])
    print(f"{'tracker':24}{'shadow rays':16}{'micro':>6}{'instr.':>10}{'look-ups':>10}{'tests':>10}{'segments':>10}"
          f"{'bytes':>10}   per camera sample")
    with tempfile.TemporaryDirectory() as name:
        for tracker, shadow, micro in CONFIGURATIONS:
            options = ["--tracker", tracker, "--transmittance", shadow, "--micro-bounds", micro]
            instructions, s = measure_counting(program, arguments + options, pathlib.Path(name))
            n = s["samples"]
            work = {k: (s[k + "_path"] + s[k + "_shadow"]) / n for k in BYTES}
            read = sum(work[k] * BYTES[k] for k in BYTES)
            print(f"{tracker:24}{shadow:16}{micro:>6}{instructions / n:10.0f}{work['lookups']:10.2f}"
                  f"{work['bounds_tests']:10.2f}{work['segments']:10.2f}{read:10.0f}", flush=True)


if __name__ == "__main__":
    main()
