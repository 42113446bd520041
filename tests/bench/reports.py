#!/usr/bin/env python3
"""How often pvol's own reports are wrong, over scenes drawn at random.

    tests/bench/reports.py build/ci/tools [--scenes 1000] [--first 0] [--spp 32] [--size 32x24] [--keep FILE]
    tests/bench/reports.py build/ci/tools --trade 20 --scenes 100
    tests/bench/reports.py build/ci/tools --first K --write FOLDER    # only writes the files of scene K

Scene K is drawn by the number K: clouds of random forms, thick or thin, grey or coloured, one or several;
suns, skies, points, spots, areas; fires, grounds, balls and motion. Three pictures with other random numbers
are rendered of it: A and B with SPP samples, R with 16 times as many. Prints

  alarms      shares of scenes in which `pvol-stats image` finds a bias, where there is none, at levels of 5,
              1 and .1 %: in A beside B, and in A beside R
  intervals   how many of its 95 % intervals of a mean's bias and of the systematic MSE do not hold 0. The
              latter lie below it where samples are stratified, which the variance of a pixel does not know
  noise       true root mean squared difference of A and R over what their variances explain; true noise of
              pixels over that reported; noise reported at the end over that expected at a tenth of A
  filter      true root mean squared error of A filtered, over its estimate
  trade       with --trade SECONDS: shares of studies of that budget which call an unbiased setting biased, in
              place of all else. The level of a study is 1 %

Ratios are given as quantiles over the scenes: 5, 25, 50, 75 and 95 %. FILE keeps a line of JSON for each
scene: scenes that it has are not rendered again. A scene whose pictures are black says nothing and is left
out."""
import json
import math
import pathlib
import re
import subprocess

from random_scenes import study_parser, study_scenes, write_scene
from scenes import beside_brightness, read_exr

LEVELS = 0.05, 0.01, 0.001
QUANTILES = 0.05, 0.25, 0.5, 0.75, 0.95
LUMINANCE = 0.2126, 0.7152, 0.0722


def run(command, status=(0,)):
    done = subprocess.run([str(c) for c in command], capture_output=True, text=True)
    if done.returncode not in status:
        raise RuntimeError(" ".join(map(str, command)) + "\n" + done.stderr)
    return done


def luminances(planes, prefix=""):
    return [sum(w * x for w, x in zip(LUMINANCE, rgb)) for rgb in zip(*(planes[prefix + c] for c in "RGB"))]


def image_report(tools, a, b):
    report = json.loads(run([tools / "pvol-stats", "image", a, b, "--json"]).stdout)
    light, verdict = report["luminance"], report["verdict"]
    return {"p": verdict["p_value"],
            "bias": [light["bias"], light["bias_half_width"]],
            "systematic": [light["systematic_mse"], light["systematic_half_width"]],
            "mse": light["mse"], "explained": light["explained_mse"]}


def study_pictures(tools, file, args, folder):
    """What the reports of a scene's pictures say, and what is true; nothing of a black scene."""
    def render(name, seed, spp, *more):
        return run([tools / "pvol-render", file, "-o", folder / f"{name}.exr", "--spp", spp, "--seed", seed,
                    "--size", args.size, "--threads", args.threads, "--stats", folder / f"{name}.json",
                    "--aov", "variance,samples", "--no-png", *more]).stderr

    def read(name):
        return read_exr(folder / f"{name}.exr"), json.loads((folder / f"{name}.json").read_text())

    log = render("a", 1, args.spp)
    a, stats = read("a")
    if max(map(max, (a[c] for c in "RGB"))) <= 0:
        return None
    render("b", 2, args.spp)
    b, _ = read("b")
    render("r", 3, 16 * args.spp)
    render("f", 1, args.spp, "--denoise")
    (r, _), (f, filtered) = read("r"), read("f")
    light, true = luminances(a), luminances(r)
    own = [max(0.0, v) for v in luminances(r, "variance.")]
    squares = [(x - y) ** 2 / 2 for x, y in zip(light, luminances(b))]
    error = sum((x - y) ** 2 - v for x, y, v in zip(luminances(f), true, own)) / len(true)
    expected = re.findall(r"([0-9.e-]+) % expected", log)
    mean = sum(true) / len(true)
    return {"same": image_report(tools, folder / "a.exr", folder / "b.exr"),
            "reference": image_report(tools, folder / "a.exr", folder / "r.exr"),
            "pixel_noise": [math.sqrt(beside_brightness(squares, true)), stats["pixel_noise"]],
            "expected": [stats["pixel_noise"], float(expected[0]) / 100 if expected else None],
            "filter": [math.sqrt(max(0, error)) / mean, filtered["denoised"]["estimated_error"]]}


def study_trade(tools, file, args):
    """The settings without bias in which a study finds one."""
    done = run([tools / "pvol-stats", "trade", file, "--budget", args.trade, "--threads", args.threads,
                "--size", args.size, "--json"], status=(0, 1))
    if done.returncode:
        return None
    rows = [r for r in json.loads(done.stdout)["settings"] if "bias" in r and not r["biased_by_design"]]
    return {"tested": len(rows), "alarms": [r["setting"] for r in rows if r["bias"]["detected"]]}


def quantiles(values):
    values = sorted(values)
    return "  ".join(f"{values[min(len(values) - 1, int(q * len(values)))]:.3g}" for q in QUANTILES)


def print_pictures(found):
    for name, title in (("same", "A beside B"), ("reference", "A beside R")):
        ps = [r[name]["p"] for r in found]
        shares = ", ".join(f"{100 * sum(p < x for p in ps) / len(ps):.2g} % at {100 * x:g} %" for x in LEVELS)
        print(f"alarms, {title}: {shares}")
        for key, what in (("bias", "a mean's bias"), ("systematic", "the systematic MSE")):
            above = sum(r[name][key][0] > r[name][key][1] for r in found)
            below = sum(r[name][key][0] < -r[name][key][1] for r in found)
            print(f"intervals of {what}, {title}: {100 * above / len(found):.2g} % lie above 0, "
                  f"{100 * below / len(found):.2g} % below")
    print("quantiles" + " " * 33 + "  ".join(f"{100 * q:g} %" for q in QUANTILES))
    rows = {"noise: true over explained by variances": [
                math.sqrt(r["reference"]["mse"] / r["reference"]["explained"]) for r in found
                if r["reference"]["explained"]]}
    for key, what in (("pixel_noise", "noise of pixels: true over reported"),
                      ("expected", "noise of pixels: at the end over expected"),
                      ("filter", "filter: true error over estimated")):
        rows[what] = [r[key][0] / r[key][1] for r in found if r[key][1]]
    for what, ratios in rows.items():
        print(f"{what:42}{quantiles(ratios)}")


def main():
    parser = study_parser(__doc__, scenes=1000, spp=32)
    parser.add_argument("--threads", type=int, default=1)
    parser.add_argument("--trade", type=float)
    parser.add_argument("--write", type=pathlib.Path, metavar="FOLDER")
    args = parser.parse_args()
    if args.write:
        args.write.mkdir(parents=True, exist_ok=True)
        return print(write_scene(args.first, args.write))
    kept = study_scenes(args, lambda _, file, folder: (study_trade(args.tools, file, args) if args.trade else
                                                       study_pictures(args.tools, file, args, folder)))
    found = [result for result in kept.values() if result]
    print(f"{len(found)} scenes of {len(kept)}")
    if args.trade:
        alarms = [a for r in found for a in r["alarms"]]
        print(f"studies with a false alarm: {sum(bool(r['alarms']) for r in found)} of {len(found)}, of "
              f"{sum(r['tested'] for r in found)} settings: {alarms}")
    elif found:
        print_pictures(found)


if __name__ == "__main__":
    main()
