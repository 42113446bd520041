#!/usr/bin/env python3
"""Whether options that must not change a picture leave it as it is, over scenes and options drawn at random.

    tests/bench/options.py build/ci/tools [--scenes 200] [--first 0] [--spp 64] [--size 24x16] [--keep FILE]

Scene K is that of reports.py. It is rendered twice, with other random numbers: as it is, and with options of
trackers, kernels, guiding, bounds and outputs besides. What may change the picture, such as a filter or a
limit of bounces, is the same in both. Prints a line for each scene whose second picture ends otherwise than
with a picture or an error that says why, or differs from the first by more than noise (by `pvol-stats image`,
with a probability below 1e-6); then what was refused, and how often. Fails where there was such a line.
"""
import collections
import random
import re
import subprocess
import sys

from random_scenes import study_parser, study_scenes
from reports import image_report

ALARM = 1e-6
WATCHDOG = 1800  # seconds, of which a picture needs a few
TRIES = 5  # draws of options, until some are not refused

# Each is drawn with a probability of a third: options of both pictures, and of the second alone.
SAME = (
    lambda draw, _: ["--filter", draw.choice(["box", "gaussian"])],
    lambda draw, _: ["--max-bounces", draw.choice([0, 1, 8])],
    lambda draw, _: ["--background", "off"],
    lambda draw, _: ["--interpolation", "nearest"],
    lambda draw, _: ["--density", draw.choice(["fp16", "fp8"])],
    lambda draw, _: ["--color-space", "acescg"],
    lambda draw, _: ["--crop", "3,2,17,11"],
    lambda draw, _: ["--preview", 1],
    lambda draw, _: ["--homogenise", 0.05],
)
OTHER = (
    lambda draw, _: ["--tracker", draw.choice(["delta-global", "delta", "weighted-delta",
                                               "weighted-decomposition", "regular"])],
    lambda draw, _: ["--transmittance", draw.choice(["ratio", "analog", "residual-ratio", "regular"])],
    lambda draw, _: ["--micro-bounds", draw.choice(["none", "1", "2", "codes"])],
    lambda draw, _: ["--guide", draw.choice(["on", "off"])],
    lambda draw, _: ["--kernel", draw.choice(["scalar", "sse4", "avx2", "auto"])],
    lambda draw, _: ["--line-emission", draw.choice(["on", "off"])],
    lambda draw, _: ["--line-lamps", draw.choice(["on", "off"])],
    lambda draw, _: ["--emission-points", draw.randint(1, 32)],
    lambda draw, _: ["--depth", draw.randint(0, 6)],
    lambda draw, _: ["--majorant-scale", round(draw.uniform(1, 4), 2)],
    lambda draw, _: ["--threads", draw.randint(1, 3)],
    lambda draw, folder: ["--stats", folder / "stats.json"],
    lambda draw, folder: ["--deep", folder / "deep.exr"],
    lambda draw, _: ["--denoise-layers"],
    lambda draw, _: ["--aov", "variance,samples," + ",".join(draw.sample(
        ["transmittance", "lights", "scattering", "halves", "transmittance_rgb", "depth", "nearest",
         "position", "normal", "albedo", "velocity", "objects", "lookups", "segments"], 4))],
    lambda draw, _: ["--checkpoint", 0.001],
)


def drawn(draw, options, folder):
    return [str(word) for option in options if draw.random() < 1 / 3 for word in option(draw, folder)]


def render(args, file, output, seed, options):
    """The exit status and what was written to standard error."""
    command = [args.tools / "pvol-render", file, "-o", output, "--size", args.size, "--spp", args.spp,
               "--seed", seed, "--threads", 1, "--aov", "variance,samples", "--no-png", *options]
    try:
        done = subprocess.run([str(c) for c in command], capture_output=True, text=True, timeout=WATCHDOG)
    except subprocess.TimeoutExpired:
        return None, "does not end"
    return done.returncode, done.stderr


def last_error(text):
    found = re.findall(r"error: (.*)", text)
    return found[-1] if found else None


def study(number, file, folder, args):
    """The options of the second picture, those before it that were refused, and a fault or the probability of
    the pictures' difference."""
    draw = random.Random(f"options {number}")
    refused = []
    while len(refused) < TRIES:
        same, other = drawn(draw, SAME, folder), drawn(draw, OTHER, folder)
        result = {"options": same + other, "refused": refused}
        status, text = render(args, file, folder / "2.exr", 2, same + other)
        error = last_error(text)
        if status == 0:
            break
        if status not in (1, 2) or not error:
            return result | {"fault": f"status {status}: {text[-300:]}"}
        refused.append(re.sub(r"^\S*[/.]\S*: ", "", error))
    else:
        return result
    status, text = render(args, file, folder / "1.exr", 1, same)
    if status != 0:
        return result | {"fault": f"without the second options: status {status}: {text[-300:]}"}
    p = image_report(args.tools, folder / "2.exr", folder / "1.exr")["p"]
    return result | ({"p": p} if p >= ALARM else {"p": p, "fault": f"the pictures differ: p = {p:.2g}"})


def main():
    args = study_parser(__doc__, scenes=200, spp=64)
    args.set_defaults(size="24x16")
    args = args.parse_args()
    found = study_scenes(args, lambda *scene: study(*scene, args))
    refused = collections.Counter(text for r in found.values() for text in r["refused"])
    faults = {number: r for number, r in found.items() if "fault" in r}
    for number, r in faults.items():
        print(f"scene {number} with {' '.join(r['options'])}: {r['fault']}")
    compared = [r["p"] for r in found.values() if "p" in r]
    print(f"{len(found)} scenes, {len(compared)} compared, the least p {min(compared, default=1):.2g}; "
          f"{sum(refused.values())} refused, {len(faults)} faults")
    for text, times in refused.most_common():
        print(f"refused {times} times: {text}")
    sys.exit(1 if faults else 0)


if __name__ == "__main__":
    main()
