#!/usr/bin/env python3
"""Cost at equal noise of shots, each hard for another kind of light: two programs, or two settings of one, in
turn in one run, on one thread.

    tests/bench/shots.py OLD NEW [--rounds 3] [--size 160x90] [--spp 16] [--more 64] [--shot NAME]...
    tests/bench/shots.py NEW "NEW --guide off"

OLD and NEW are pvol-render, with options or without. Errors are those against a picture with MORE times as
many samples, by NEW. Prints for each shot, of NEW over OLD

  time    CPU time of rendering, the least of the rounds: without loading, with the guide
  E       time x mean squared error of a pixel
  rel     time x mean over the pixels of squared error / (value^2 + (1 % of the picture's mean)^2)

and the root of the last for NEW at this number of samples. kernels.py builds the program of another
revision; scenes.py does the same for scenes of every kind, by the variances that a picture reports."""
import argparse
import json
import math
import pathlib
import shlex
import subprocess
import sys
import tempfile

from scenes import SAMPLES, SUN, beside_brightness, instances, read_exr

NIGHT = '[environment]\ntype = "constant"\nradiance = [0.002, 0.003, 0.005]\n'
FLAME = """grid = "none"
[volume.medium.fire]
field = "density"
intensity = 160
kelvin = 4200
kelvin_of_intensity = 3000
"""


def camera(position, target, fov):
    return f"[camera]\nposition = {position}\ntarget = {target}\nfov = {fov}\n"


def volume(file, *lines, more=""):
    """A volume with a medium of its own."""
    return f'[[volume]]\nfile = "{SAMPLES}/{file}"\n{more}[volume.medium]\n' + "\n".join(lines) + "\n"


def plane(height, albedo):
    return f"[[plane]]\npoint = [0, {height}, 0]\nalbedo = {albedo}\n"


def point(position, intensity):
    return f"[[point]]\nposition = {list(position)}\nintensity = {intensity}\n"


def spot_down(position, intensity):
    return (f"[[spot]]\nposition = {list(position)}\nintensity = {intensity}\n"
            "direction = [0, -1, 0]\nangle = 120\n")


def street_lamps(columns=20, rows=10, lamp=point):
    """In a grid, which is as bright whatever their number."""
    places = [(-1.9 + 3.8 * (k % columns) / (columns - 1), -0.12, -1.9 + 3.8 * (k // columns) / (rows - 1))
              for k in range(columns * rows)]
    share = 200 / (columns * rows)
    return "".join(lamp(p, [0.04 * share, 0.03 * share, 0.015 * share]) for p in places)


def lamps_around(count):
    """Of several colours, in a ring."""
    colors = [6, 4, 2], [1, 5, 3], [2, 2, 8]
    turns = [2 * math.pi * k / count for k in range(count)]
    return "".join(point((2.6 * math.cos(t), 0.1 + 0.2 * (k % 5), 2.6 * math.sin(t)),
                         [12 / count * c for c in colors[k % 3]]) for k, t in enumerate(turns))


def broken_clouds():
    """Small clouds with gaps between them."""
    places = [(-1.4 + 0.7 * (k % 5) + 0.2 * (k // 5 % 2), -1.4 + 0.7 * (k // 5)) for k in range(25)]
    return "".join(f"[[volume.instance]]\nscale = 0.3\nrotate = [0, 1, 0, {37 * k}]\n"
                   f"translate = [{x:.1f}, 0.1, {z:.1f}]\n" for k, (x, z) in enumerate(places))


SMOKE = "albedo = 0.9", "g = 0.3"
CLOUD = "albedo = 0.999", "g = 0.85"
STREET = (volume("stratus.toml", "extinction = 1.5", "albedo = 0.95", "g = 0.6") + plane(-0.25, 0.1) + NIGHT +
          camera([0, 1.4, 5], [0, 0, 0], 34))
BEFORE_COLUMN = camera([0.4, 1.3, 6.5], [0.2, 1.2, 0], 26)
SHOTS = {
    "lamp in thin smoke": volume("column.toml", "extinction = 0.6", *SMOKE) + NIGHT + BEFORE_COLUMN +
    point((0.15, 1.7, 0.3), [1, 0.8, 0.5]),
    "shafts of light": '[[volume]]\nfile = "' + str(SAMPLES) + '/cumulus.toml"\n' + broken_clouds() +
    volume("haze.toml", "extinction = 0.2", "albedo = 0.95", "g = 0.5") + NIGHT +
    "[medium]\nextinction = 30\nalbedo = 0.999\ng = 0.85\n" + camera([0, -0.6, 6], [0, -0.5, 0], 34) +
    "[[spot]]\nposition = [0.3, 2.5, 0]\ndirection = [-0.1, -1, 0]\nintensity = [40, 36, 28]\nangle = 50\n",
    "sun at the horizon": volume("stratus.toml", "extinction = 12", *CLOUD) +
    camera([0, 0.9, 6], [0, 0, 0], 30) +
    "[[sun]]\ndirection = [-0.6, 0.03, -0.8]\nirradiance = [3.3, 2.0, 1.0]\nangle = 0.53\n"
    '[environment]\ntype = "gradient"\nzenith = [0.05, 0.07, 0.12]\nhorizon = [0.2, 0.14, 0.1]\n'
    "ground = [0.02, 0.02, 0.02]\n",
    "clear sky over a ground": volume("cumulus.toml", "extinction = 60", *CLOUD) + plane(-0.6, 0.2) +
    camera([0.5, 0.5, 5], [0, 0.2, 0], 34) +
    '[environment]\ntype = "clear"\ndate = "2024-06-21T10:00:00+02:00"\nlatitude = 41.4\nlongitude = 2.2\n'
    "turbidity = 3\n",
    "street lamps in fog": STREET + street_lamps(),
    "50 street lamps in fog": STREET + street_lamps(10, 5),
    "5000 street lamps in fog": STREET + street_lamps(100, 50),
    "1000 street spots in fog": STREET + street_lamps(50, 20, spot_down),
    "twelve lamps over a ground": volume("cumulus.toml", "extinction = 40", *CLOUD) + plane(-0.9, 0.4) +
    NIGHT + camera([0, 1.2, 6], [0, 0, 0], 34) + lamps_around(12),
    "campfire with a ground": volume("column.toml", "extinction = 6", "albedo = 0.87", "g = 0.4",
                                     "translate = [0, 0.42, 0]") +
    f'[[volume]]\nfile = "{SAMPLES}/flame.toml"\n' + FLAME + plane(0, 0.2) + NIGHT +
    camera([1.1, 0.9, 6.2], [0.12, 1.35, 0], 28),
    "thin flame, dark wall": f'[[volume]]\nfile = "{SAMPLES}/flame.toml"\n' + FLAME + plane(0, 0.1) +
    "[[plane]]\npoint = [0, 0, -0.8]\nnormal = [0, 0, 1]\nalbedo = 0.05\n" + NIGHT +
    camera([0, 0.6, 4], [0, 0.5, 0], 34),
    "lamp between two smokes": volume("column.toml", "extinction = 8", "albedo = [0.97, 0.5, 0.22]",
                                      "g = 0.3") +
    volume("column.toml", "extinction = 8", "albedo = [0.35, 0.62, 0.95]", "g = 0.3",
           "rotate = [0, 1, 0, 160]", "translate = [0.9, 0, 0.1]") + NIGHT + BEFORE_COLUMN +
    point((0.5, 1.4, 0.5), 2),
    "sky of 100 clouds": instances(100).replace("{samples}", str(SAMPLES)),
    "sun behind a stratus": volume("stratus.toml", "extinction = 10", "albedo = 0.999", "g = 0.8") +
    camera([0, -0.6, 0], [0.3, 0.2, 0.2], 20) +
    "[[sun]]\ndirection = [0.3, 0.8, 0.2]\nirradiance = 3\nangle = 0.53\n"
    '[environment]\ntype = "constant"\nradiance = [0.2, 0.3, 0.5]\n',
    "window behind smoke": volume("column.toml", "extinction = 8", *SMOKE) + NIGHT + BEFORE_COLUMN +
    "[[area]]\nposition = [0.2, 1.2, -1.5]\ndirection = [0, 0, 1]\nsize = [2.4, 1.8]\n"
    "radiance = [6, 5, 4]\n",
    "inside a cloud": volume("cumulus.toml", "extinction = 3", *CLOUD) + SUN +
    camera([0.1, 0.3, 0.1], [-0.6, 0.5, 0.8], 60),
}
HAZE = """[recipe]
resolution = 64
edge = 0.2

[[form]]
shape = "ellipsoid"
centre = [0, -1, 0]
radii = [2.5, 1.2, 2.5]
"""


def scene_of(shot):
    """The text of a scene file beside haze.toml. Keys of the first volume's medium are in [medium]."""
    text = SHOTS[shot].replace(f"{SAMPLES}/haze.toml", "haze.toml")
    if "[[volume]]" not in text:
        return text
    first, *others = text.split("[[volume]]\n")[1:]
    return "[[volume]]\n".join(["", first.replace("[volume.medium", "[medium"), *others])


def render(program, scene, spp, size, folder, seed, *more):
    """CPU seconds, and the mean of R, G and B in each pixel."""
    picture, stats = folder / "a.exr", folder / "a.json"
    command = [*shlex.split(program), scene, "-o", picture, "--stats", stats, "--spp", spp, "--size", size,
               "--seed", seed, "--no-png", "--quiet", "--filter", "box", *more]
    run = subprocess.run([str(c) for c in command], capture_output=True, text=True)
    if run.returncode:
        sys.exit(run.stderr)
    planes = read_exr(picture)
    return json.loads(stats.read_text())["cpu_seconds"], [sum(v) / 3 for v in zip(*(planes[c] for c in "RGB"))]


def errors(picture, reference):
    """The mean squared error, and the mean relative one."""
    squares = [(a - b) ** 2 for a, b in zip(picture, reference)]
    return sum(squares) / len(squares), beside_brightness(squares, reference)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("old")
    parser.add_argument("new")
    parser.add_argument("--rounds", type=int, default=3)
    parser.add_argument("--size", default="160x90")
    parser.add_argument("--spp", type=int, default=16)
    parser.add_argument("--more", type=int, default=64)
    parser.add_argument("--shot", action="append", choices=SHOTS)
    given = parser.parse_args()
    print(f"{'shot':24} {'time':>6} {'E':>6} {'rel':>6}  error   CPU s of old and new")
    products = [1.0, 1.0]
    shots = given.shot or SHOTS
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        (folder / "haze.toml").write_text(HAZE)
        for shot in shots:
            scene = folder / "scene.toml"
            scene.write_text(scene_of(shot))
            _, reference = render(given.new, scene, given.spp * given.more, given.size, folder, 1000)
            seconds, squares, relatives = {}, {}, {}
            for seed in range(given.rounds):
                for program in (given.old, given.new):
                    took, picture = render(program, scene, given.spp, given.size, folder, seed,
                                           "--threads", 1)
                    square, relative = errors(picture, reference)
                    seconds[program] = min(seconds.get(program, took), took)
                    squares[program] = squares.get(program, 0) + square / given.rounds
                    relatives[program] = relatives.get(program, 0) + relative / given.rounds
            a, b = given.old, given.new
            time, e, rel = (v[b] / v[a] for v in (seconds, squares, relatives))
            products = [products[0] * time * e, products[1] * time * rel]
            print(f"{shot:24} {time:6.2f} {time * e:6.2f} {time * rel:6.2f} {100 * relatives[b] ** 0.5:5.0f} %"
                  f"  {seconds[a]:.3f} {seconds[b]:.3f}", flush=True)
    e, rel = (p ** (1 / len(shots)) for p in products)
    print(f"{'geometric mean':24} {'':6} {e:6.2f} {rel:6.2f}")


if __name__ == "__main__":
    sys.exit(main())
