#!/usr/bin/env python3
"""Instructions per camera sample of SIMD kernels, beside flights one by one, on an emulated processor.

  kernel_instructions.py aarch64 build/aarch64/tests/bench/kernel_bench    # of tests/cross, see below
  kernel_instructions.py x86_64 build/bench/tests/bench/kernel_bench       # of the preset `bench`

Runs kernel_bench under QEMU, whose plugin count_instructions.c counts, with 8 and with 24 samples in each of
24 x 24 pixels: the difference leaves out what a picture costs once. Prints for each scene the instructions by
kernel, and their ratio to those of `scalar`. The numbers are the same on every machine. QEMU 7.2 has no
AVX-512. Needs the package qemu-user, and a cross build with benchmarks:
  tests/cross aarch64 math && cmake -B build/aarch64 -D PVOL_BUILD_BENCH=ON &&
    ninja -C build/aarch64 kernel_bench
"""
import argparse
import pathlib
import subprocess
import tempfile

HERE = pathlib.Path(__file__).resolve().parent
ROOT = HERE.parents[1]
SCENES = ["cloud", "ground", "clouds", "lamps", "tricubic", "channels"]
KERNELS = {"aarch64": ["neon"], "x86_64": ["sse4", "avx2"]}
LIBRARIES = ROOT / "build/aarch64-packages/usr/lib/aarch64-linux-gnu"
EMULATORS = {
    "aarch64": ["qemu-aarch64", "-L", "/usr/aarch64-linux-gnu", "-E", f"LD_LIBRARY_PATH={LIBRARIES}"],
    "x86_64": ["qemu-x86_64", "-cpu", "max"],
}
FEW, MANY = 8, 24


def run(arguments):
    done = subprocess.run(arguments, capture_output=True, text=True)
    if done.returncode != 0:
        raise SystemExit(f"kernel_instructions.py: {' '.join(map(str, arguments))} failed:\n{done.stderr}")
    return done.stdout


def measure(emulator, program, kernel, scene, folder):
    """Instructions per sample, and the picture's mean luminance."""
    counts = folder / "count"
    executed, traced = [], []
    for samples in (FEW, MANY):
        plugin = ["-plugin", f"{folder}/count.so,to={counts}"]
        shown = run([*emulator, *plugin, program, kernel, scene, str(samples)]).split()
        executed.append(int(counts.read_text()))
        traced.append(int(shown[0]))
    return (executed[1] - executed[0]) / (traced[1] - traced[0]), float(shown[1])


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("processor", choices=KERNELS)
    parser.add_argument("program", help="kernel_bench, built for it")
    parser.add_argument("--scene", choices=SCENES, action="append", help="instead of all")
    options = parser.parse_args()
    emulator = EMULATORS[options.processor]
    kernels = ["scalar", *KERNELS[options.processor]]
    print(f"{'scene':10}" + "".join(f"{k:>10}" for k in kernels) +
          "".join(f"{k + '/scalar':>14}" for k in kernels[1:]) + "    mean luminance")
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        run(["cc", "-O2", "-shared", "-fPIC", "-o", folder / "count.so", HERE / "count_instructions.c"])
        for scene in options.scene or SCENES:
            found = [measure(emulator, options.program, k, scene, folder) for k in kernels]
            counts = [f[0] for f in found]
            print(f"{scene:10}" + "".join(f"{c:10.0f}" for c in counts) +
                  "".join(f"{c / counts[0]:14.3f}" for c in counts[1:]) +
                  "    " + ", ".join(f"{f[1]:.4g}" for f in found), flush=True)


if __name__ == "__main__":
    main()
