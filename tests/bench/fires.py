#!/usr/bin/env python3
"""What gathering emission along flights gains, and sampling it as a light: noise of a pixel after 64
samples and time x variance against emission at collisions, on the same scenes.

    tests/bench/fires.py build/ci/tools/pvol-render FIRE.vdb GRID SMOKE.vdb [--size 192x192] [--spp 64]

FIRE.vdb's grid GRID is taken for a medium that glows: thin (extinction 0.002 over about a hundred voxels of 1,
emission 2000), in the midst of nothing, and beside the smoke, which its light falls on. Each case is rendered
twice with other seeds: noise is half of the mean squared difference, so that it rests on no estimate."""
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
    parser.add_argument("smoke")
    parser.add_argument("--size", default="192x192"), parser.add_argument("--spp", type=int, default=64)
    args = parser.parse_args()
    names = {"fire": Path(args.fire).resolve(), "grid": args.grid, "smoke": Path(args.smoke).resolve()}
    place = "scale = 0.25\ntranslate = [50, 20, 0]"
    camera = "[camera]\nposition = [0, 15, 160]\ntarget = [0, 15, 0]\nfov = 38"
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        for title, text in (("thin flame", THIN),
                            ("smoke lit by fire", LIT.replace("{place}", place).replace("{camera}", camera)
                             .replace("{extinction}", "0.6"))):
            scene = folder / "scene.toml"
            scene.write_text(text.format(**names))
            print(title)
            first = None
            for label, options in (("at collisions", ["--line-emission", "off", "--kernel", "scalar"]),
                                   ("along flights", ["--line-emission", "on"]),
                                   ("... 8 points", ["--line-emission", "on", "--emission-points", "8"])):
                noise, cpu = measure(args, folder, scene, options)
                cost = cpu * noise**2
                first = first or cost
                print(f"  {label:16} noise {100 * noise:9.3g} %  CPU {cpu:7.3g} s  time x variance {cost / first:.3g}")


main()
