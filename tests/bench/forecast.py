#!/usr/bin/env python3
"""How long pvol-render expects pictures to take, and how long they take.

    tests/bench/forecast.py build/ci/tools/pvol-render SCENE... [--spp N] [--size WxH] [--threads N]

Scenes are whatever pvol-render takes: scenes, recipes, clouds. They have the size and the samples of their
files, or those of --size and --spp. Work is counted, as --stats does. Prints CPU seconds for each:

  guide     making the guide
  forecast  the whole render, the guide included, as it was forecast before the first sample
  taken     the render, without the forecast
  ratio     forecast over taken
  own       the forecast itself, in percent of the render

and the least and the largest ratio. A busy machine's times vary by themselves: repeat what looks odd."""
import argparse
import json
import subprocess
import sys
import tempfile
from pathlib import Path


def render(args, scene, folder):
    """What --stats reports of a render."""
    stats = folder / "stats.json"
    command = [args.render, scene, "-o", folder / "a.exr", "--no-png", "--quiet", "--stats", stats]
    for flag in ("spp", "size", "threads"):
        if value := getattr(args, flag):
            command += [f"--{flag}", str(value)]
    done = subprocess.run(command, capture_output=True, text=True)
    if done.returncode:
        print(f"{scene}: {done.stderr.strip()}", file=sys.stderr)
        return None
    return json.loads(stats.read_text())


def main():
    raw = argparse.RawDescriptionHelpFormatter
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=raw)
    parser.add_argument("render")
    parser.add_argument("scene", nargs="+", type=Path)
    parser.add_argument("--spp", type=int)
    parser.add_argument("--size")
    parser.add_argument("--threads", type=int)
    args = parser.parse_args()
    print(f"| {'scene':34} | guide | forecast | taken | ratio | own |\n|---|---|---|---|---|---|")
    ratios = []
    with tempfile.TemporaryDirectory() as name:
        for scene in args.scene:
            stats = render(args, scene, Path(name))
            if not stats or not stats["forecast"]["samples"]:
                continue
            forecast, cost = stats["forecast"], stats["forecast"]["own_cpu_seconds"]
            taken = stats["cpu_seconds"] - cost
            ratios.append(forecast["cpu_seconds"] / taken)
            print(f"| {scene.name:34} | {forecast['guide_seconds']:.2g} | {forecast['cpu_seconds']:.3g} "
                  f"| {taken:.3g} | {ratios[-1]:.2f} | {100 * cost / taken:.2g} % |", flush=True)
    if ratios:
        print(f"\nratio {min(ratios):.2f} to {max(ratios):.2f}")


main()
