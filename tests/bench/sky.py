#!/usr/bin/env python3
"""Writes a scene of one cloud many times over: a fair-weather sky.

    tests/bench/sky.py 120 > samples/sky.toml
    tests/bench/sky.py 1000 --cloud cumulus.pvol > sky_1000.toml

The clouds lie before the camera on a jittered grid, each turned about the vertical and of a size of its own.
"""

import argparse
import math
import random


def instances(count, seed):
    rng = random.Random(seed)
    rows = math.ceil(math.sqrt(count))
    step = 2.6
    for i in range(count):
        x = (i % rows - (rows - 1) / 2 + rng.uniform(-0.4, 0.4)) * step
        z = -(i // rows + rng.uniform(-0.4, 0.4)) * step
        yield {
            "scale": round(rng.uniform(0.5, 1.3), 3),
            "rotate": [0, 1, 0, round(rng.uniform(0, 360), 1)],
            "translate": [round(x, 3), round(rng.uniform(-0.15, 0.15), 3), round(z, 3)],
        }


def scene(args):
    lines = [
        f"# A sky of {args.count} clouds that share one: written by tests/bench/sky.py {args.count}.",
        "",
        "[volume]",
        f'file = "{args.cloud}"',
    ]
    for place in instances(args.count, args.seed):
        lines += ["", "[[volume.instance]]"] + [f"{key} = {value}" for key, value in place.items()]
    lines += [
        "",
        "[medium]",
        f"extinction = {args.extinction}",
        "albedo = 0.99",
        "g = 0.5",
        "",
        "[camera]",
        "position = [0, 3.2, 7]",
        "target = [0, 0.4, -8]",
        "fov = 34",
        "",
        "[environment]",
        'type = "gradient"',
        "zenith = [0.06, 0.16, 0.42]",
        "horizon = [0.32, 0.46, 0.66]",
        "ground = [0.16, 0.16, 0.15]",
        "",
        "[[sun]]",
        "direction = [-0.75, 0.62, 0.35]",
        "irradiance = [3.3, 3.0, 2.6]",
        "angle = 0.53",
        "",
        "[render]",
        "size = [320, 200]",
        "spp = 16",
    ]
    return "\n".join(lines) + "\n"


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("count", type=int, help="clouds")
    parser.add_argument("--cloud", default="cumulus.toml", help="file of the cloud, from the scene")
    parser.add_argument("--extinction", type=float, default=30)
    parser.add_argument("--seed", type=int, default=1)
    print(scene(parser.parse_args()), end="")


if __name__ == "__main__":
    main()
