#!/usr/bin/env python3
"""What gathering emission along flights gains, and sampling it as a light: noise of a pixel after 64
samples and time x variance against emission at collisions, on the same scenes.

    tests/bench/fires.py build/ci/tools/pvol-render FIRE.vdb GRID SMOKE.vdb BURNING.vdb [--size 192x192] [--spp 64]

FIRE.vdb's grid GRID is taken for a medium that glows: thin (extinction 0.002 over about a hundred voxels of 1,
emission 2000), in the midst of nothing, and beside the smoke, which its light falls on. BURNING.vdb has grids
"density" and "flames": a fire in its own smoke, of several extinctions, alone and over a ground. Each case is
rendered twice with other seeds: noise is half of the mean squared difference, so that it rests on no estimate."""
import argparse
import json
import subprocess
import sys
import tempfile
from pathlib import Path

THIN = """
[volume]
file = "{fire}"
grid = "{grid}"
[medium]
extinction = 0.002
albedo = 0
emission = 2000
[environment]
type = "constant"
radiance = 0
"""

# The smoke is lit from its right; the fire itself is out of view.
LIT = """
[[volume]]
file = "{smoke}"
[[volume]]
file = "{fire}"
grid = "{grid}"
[volume.medium]
extinction = 0.002
albedo = 0
emission = 20000
{place}
[medium]
extinction = {extinction}
albedo = 0.9
g = 0.5
[environment]
type = "constant"
radiance = 0
{camera}
"""

BURNING = """
[volume]
file = "{burning}"
[medium]
extinction = {extinction}
albedo = 0.6
g = 0.3
[medium.fire]
field = "flames"
intensity = 120
kelvin = 1900
{ground}
[environment]
type = "constant"
radiance = [0.01, 0.014, 0.03]
"""

OF_MEDIA = (("at collisions", ["--line-emission", "off", "--kernel", "scalar"]),
            ("along flights", ["--line-emission", "on"]),
            ("... 8 points", ["--line-emission", "on", "--emission-points", "16"]))
OF_FIRES = (("along flights", ["--line-emission", "on"]), ("at collisions", ["--line-emission", "off"]), ("auto", []))


def run(command):
    done = subprocess.run(command, capture_output=True, text=True)
    if done.returncode:
        sys.exit(f"{' '.join(map(str, command))}:\n{done.stderr}")
    return done


def measure(args, folder, scene, options):
    """Relative noise of a pixel, and CPU seconds."""
    cpu, files = 0.0, []
    for seed in (1, 2):
        out = folder / f"{seed}.exr"
        command = [args.render, scene, "-o", out, "--no-png", "--size", args.size, "--spp", str(args.spp),
                   "--seed", str(seed), "--stats", folder / "s.json", *options]
        run(command)
        cpu += json.loads((folder / "s.json").read_text())["cpu_seconds"] / 2
        files.append(out)
    stats = Path(args.render).with_name("pvol-stats")
    report = json.loads(run([stats, "image", *files, "--json"]).stdout)
    return report["luminance"]["relative_rmse"] / 2**0.5, cpu


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("render"), parser.add_argument("fire"), parser.add_argument("grid")
    parser.add_argument("smoke"), parser.add_argument("burning")
    parser.add_argument("--size", default="192x192"), parser.add_argument("--spp", type=int, default=64)
    args = parser.parse_args()
    names = {"fire": Path(args.fire).resolve(), "grid": args.grid, "smoke": Path(args.smoke).resolve(),
             "burning": Path(args.burning).resolve()}
    place = "scale = 0.25\ntranslate = [50, 20, 0]"
    camera = "[camera]\nposition = [0, 15, 160]\ntarget = [0, 15, 0]\nfov = 38"
    ground = "[[plane]]\npoint = [0, -0.05, 0]\nalbedo = 0.2"
    cases = [("thin flame", THIN, OF_MEDIA),
             ("smoke lit by fire", LIT.replace("{place}", place).replace("{camera}", camera)
              .replace("{extinction}", "0.6"), OF_MEDIA)]
    for extinction in (200, 20, 2, 0.2):
        cases.append((f"fire in smoke, extinction {extinction}", BURNING.replace("{extinction}", str(extinction))
                      .replace("{ground}", ""), OF_FIRES))
    cases.append(("... 20, over a ground", BURNING.replace("{extinction}", "20").replace("{ground}", ground), OF_FIRES))
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        for title, text, kinds in cases:
            scene = folder / "scene.toml"
            scene.write_text(text.format(**names))
            print(title)
            first = None
            for label, options in kinds:
                noise, cpu = measure(args, folder, scene, options)
                cost = cpu * noise**2
                first = first or cost
                print(f"  {label:16} noise {100 * noise:9.3g} %  CPU {cpu:7.3g} s  time x variance {cost / first:.3g}")


main()
