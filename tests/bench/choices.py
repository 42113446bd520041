#!/usr/bin/env python3
"""Whether choices that must not change a picture do, and what they cost, over scenes drawn at random.

    tests/bench/choices.py build/ci/tools [--scenes 100] [--first 0] [--spp 64] [--size 32x24] [--keep FILE]

Scene K of random_scenes.py is rendered by the defaults and by each of CHOICES, with other random numbers. Prints

  bias   scenes and choices whose mean luminance is more than 4 standard errors from that of the defaults:
         few in a thousand, where light is rare
  cost   those of which the defaults cost more than 3 times as much, by both CPU time x variance and
         CPU time x relative variance (scenes.py)
  and for each choice the quantiles of these two costs, defaults over choice: 5, 25, 50, 75 and 95 %

FILE keeps a line of JSON for each scene: scenes that it has are not rendered again. Black scenes, and those
without noise, are left out."""
import json
import math

from random_scenes import study_parser, study_scenes
from reports import luminances, quantiles, run
from scenes import beside_brightness, read_exr

CHOICES = {
    "guide off": ["--set", 'render.guide="off"'],
    "guide on": ["--set", 'render.guide="on"'],
    "delta": ["--tracker", "delta"],
    "collisions alone": ["--set", 'render.line_emission="off"', "--set", 'render.line_lamps="off"'],
    "ratio": ["--transmittance", "ratio", "--set", 'render.guide="off"'],
    "one by one": ["--kernel", "scalar"],
}
BIAS, COST = 4, 3


def render(args, file, folder, seed, options):
    """Mean luminance with its standard error, and costs; nothing of a picture without noise."""
    picture, stats = folder / "a.exr", folder / "a.json"
    run([args.tools / "pvol-render", file, "-o", picture, "--spp", args.spp, "--size", args.size,
         "--seed", seed, "--threads", 1, "--aov", "variance,samples", "--stats", stats, "--no-png", "--quiet",
         *options])
    planes = read_exr(picture)
    light, variance = luminances(planes), [max(0.0, v) for v in luminances(planes, "variance.")]
    mean, sum_of = sum(light) / len(light), sum(variance)
    if not sum_of > (1e-6 * mean) ** 2:
        return None
    seconds = json.loads(stats.read_text())["cpu_seconds"]
    return {"mean": mean, "error": math.sqrt(sum_of) / len(light), "cost": seconds * sum_of / len(light),
            "relative": seconds * beside_brightness(variance, light)}


def study(args, file, folder):
    return {choice: render(args, file, folder, seed + 1, more)
            for seed, (choice, more) in enumerate({"defaults": [], **CHOICES}.items())}


def report(kept):
    costs = {choice: [] for choice in CHOICES}
    for number, found in sorted(kept.items()):
        usual = found["defaults"]
        for choice in CHOICES:
            other = found[choice]
            if not usual or not other:
                continue
            off = (other["mean"] - usual["mean"]) / math.hypot(other["error"], usual["error"])
            cost, relative = usual["cost"] / other["cost"], usual["relative"] / other["relative"]
            costs[choice].append((cost, relative))
            if abs(off) > BIAS:
                print(f"bias: scene {number}, {choice}: {other['mean']:.5g} beside {usual['mean']:.5g}, "
                      f"{off:+.1f} standard errors")
            if min(cost, relative) > COST:
                print(f"cost: scene {number}, {choice}: {cost:.3g}, relative {relative:.3g}")
    print(f"{len(kept)} scenes; defaults over choice, quantiles")
    for choice, pairs in costs.items():
        for what, ratios in zip(("cost", "relative"), zip(*pairs)):
            print(f"{choice:18}{what:10}{quantiles(ratios)}")


def main():
    args = study_parser(__doc__, scenes=100, spp=64).parse_args()
    report(study_scenes(args, lambda _, file, folder: study(args, file, folder)))


if __name__ == "__main__":
    main()
