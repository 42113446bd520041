#!/usr/bin/env python3
"""What the lane kernels gain on clouds of every kind, and whether --guide auto chooses well.

  clouds.py PVOL_RENDER CLOUD... [--thickness T]... [--size N] [--spp N] [--rounds N]

Renders each cloud at mean optical thicknesses along its thickest axis, in the sun, under the sky and in both, by the
flights one by one and by the fastest kernel, guided and not, and by what `auto` chooses, on one thread and in turn.
Prints for each

  E       CPU time of a camera sample, the guide's share included, times the variance of its luminance
  gain    the better E of flights one by one over the better one of those in lanes
  auto    E of the defaults over the better of guided and plain: 1 where the choice is right
  us      CPU time of a sample by the better of flights one by one and by the defaults

Recipes among the clouds (.toml) are rendered as samples. Figures belong to one machine on one day: quote the ratios.
"""
import argparse
import json
import pathlib
import subprocess
import tempfile

LIGHTS = {
    "sun": ["--set", "environment.type=constant", "--set", "environment.radiance=0"],
    "sky": ["--set", "sun.irradiance=0"],
    "both": [],
}
KINDS = {
    "scalar plain": ["--kernel", "scalar", "--guide", "off"],
    "scalar guided": ["--kernel", "scalar", "--guide", "on"],
    "plain": ["--guide", "off"],
    "guided": ["--guide", "on"],
    "auto": [],
}
CHOSEN_THICKNESS = 40  # mean, along the thickest axis, of what pvol-render takes where nothing is said
WEIGHTS = (0.2126, 0.7152, 0.0722)


def render(arguments, cloud, options, spp, folder):
    """What --stats has to say of a render."""
    stats = folder / "stats.json"
    subprocess.run([arguments.program, cloud, "--size", f"{arguments.size}x{arguments.size}", "--spp", str(spp),
                    "--threads", "1", "--quiet", "--no-png", "-o", folder / "a.exr", "--stats", stats, *options],
                   check=True, stderr=subprocess.PIPE)
    return json.loads(stats.read_text())


def cost(arguments, cloud, options, spp, folder):
    """(E, microseconds of a sample): the least time of the rounds; the noise is that of the last."""
    seconds = []
    for _ in range(arguments.rounds):
        read = render(arguments, cloud, options, spp, folder)
        seconds.append(read["cpu_seconds"])
    us = 1e6 * min(seconds) / read["samples"]
    return us * spp * sum(w * v for w, v in zip(WEIGHTS, read["variance_rgb"])), us


def row(arguments, cloud, thickness, light, extinction, folder):
    options = ["--set", f"medium.extinction={extinction * thickness / CHOSEN_THICKNESS}", *LIGHTS[light]]
    found = {}
    for kind, more in KINDS.items():
        spp = max(2, arguments.spp // 4) if kind.startswith("scalar") else arguments.spp
        try:
            found[kind] = cost(arguments, cloud, [*options, *more], spp, folder)
        except subprocess.CalledProcessError:
            pass  # paths cannot be guided there
    scalar = min(v for k, v in found.items() if k.startswith("scalar"))
    lanes = min(v for k, v in found.items() if k in ("plain", "guided"))
    auto = found["auto"]
    guided = [f"{found[k][0]:.3g}" if k in found else "-" for k in KINDS]
    print(f"| {cloud.stem} | {thickness:g} | {light} | {' | '.join(guided)} | {scalar[0] / lanes[0]:.2f} | "
          f"{auto[0] / lanes[0]:.2f} | {scalar[1]:.2f} | {auto[1]:.2f} |", flush=True)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("program")
    parser.add_argument("clouds", nargs="+", type=pathlib.Path)
    parser.add_argument("--thickness", type=float, action="append")
    parser.add_argument("--size", type=int, default=96)
    parser.add_argument("--spp", type=int, default=64)
    parser.add_argument("--rounds", type=int, default=1)
    arguments = parser.parse_args()
    print(f"| cloud | thickness | light | {' | '.join('E ' + k for k in KINDS)} | gain | auto | us scalar | us auto |")
    print("|" + "---|" * (7 + len(KINDS)))
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        for cloud in arguments.clouds:
            extinction = render(arguments, cloud, [], 1, folder)["options"]["extinction"]
            for thickness in arguments.thickness or [4, 64, 400]:
                for light in LIGHTS:
                    row(arguments, cloud, thickness, light, extinction, folder)


if __name__ == "__main__":
    main()
