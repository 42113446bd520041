"""Scenes drawn at random, each by a number: clouds of random forms, thick or thin, grey or coloured, one or
several; phase functions, maps, fires; suns, skies, points, spots, areas; grounds, balls, cubes; lenses and
motion. And what studies over them share."""
import argparse
import json
import math
import pathlib
import random
import struct
import sys
import tempfile

from scenes import SAMPLES


class Draw(random.Random):
    """Random parts of a scene file."""

    def happens(self, probability):
        return self.random() < probability

    def log(self, low, high):
        return math.exp(self.uniform(math.log(low), math.log(high)))

    def vector(self, low, high):
        return [round(self.uniform(low, high), 3) for _ in range(3)]

    def color(self, low, high):
        """Grey, or of another hue."""
        return self.vector(low, high) if self.happens(0.4) else [round(self.uniform(low, high), 3)] * 3

    def light(self, low, high):
        brightness = self.log(low, high)
        return [float(f"{brightness * c:.4g}") for c in self.color(0.3, 1)]

    def direction(self):
        while True:
            v = self.vector(-1, 1)
            if 0.1 < sum(x * x for x in v) < 1:
                return v


def form(draw):
    centre, radii = draw.vector(-0.6, 0.6), draw.vector(0.3, 1)
    return f'[[form]]\nshape = "ellipsoid"\ncentre = {centre}\nradii = {radii}\n'


def noise(draw):
    kind = draw.choice(['kind = "billow"\n', ""])
    return (f"[[displacement]]\n{kind}amplitude = {draw.uniform(0.05, 0.4):.3f}\n"
            f"cell = {draw.log(0.1, 0.8):.3f}\noctaves = {draw.randint(1, 5)}\ngain = 0.55\n"
            f"seed = {draw.randint(0, 999)}\n")


def recipe(draw):
    """A cloud some two units wide around the origin."""
    text = f"[recipe]\nresolution = {draw.randint(24, 64)}\nedge = {draw.log(0.01, 0.6):.3f}\n"
    text += "".join(form(draw) for _ in range(draw.randint(1, 4)))
    text += "".join(noise(draw) for _ in range(draw.randint(0, 2)))
    if draw.happens(0.15):
        text += f"[flow]\nvelocity = {draw.vector(-1, 1)}\n"
        text += f"turbulence = {draw.uniform(0, 2):.2f}\ncell = 0.5\n"
    return text


def phase_function(draw):
    """Its keys, of every kind; of the simplest in two thirds of all cases."""
    g = f"g = {draw.uniform(-0.4, 0.9):.2f}"
    values = [draw.log(0.2, 5) for _ in range(4)]
    return draw.choice([g] * 10 + [
        f"g_forward = {draw.uniform(0.3, 0.95):.2f}\ng_backward = {draw.uniform(-0.6, 0):.2f}\n"
        f"forward_share = {draw.random():.2f}",
        "rayleigh = true",
        f"draine_g = {draw.uniform(-0.5, 0.9):.2f}\ndraine_alpha = {draw.log(0.1, 100):.2f}",
        f"droplet_diameter = {draw.uniform(1, 20):.1f}",
        "phase_table = [" + ", ".join(f"[{60 * k}, {v:.3f}]" for k, v in enumerate(values)) + "]"])


def motion(draw, table, place):
    """Where a thing is one frame later."""
    return f"[{table}.to]\n{place} = {draw.vector(-1, 1)}\n" if draw.happens(0.15) else ""


def maps(draw, table):
    """Of the values of grids, in few media."""
    text = ""
    if draw.happens(0.1):
        text += f"[[{table}.component]]\nshare = {draw.random():.2f}\nalbedo = {draw.color(0.4, 1)}\n"
        text += phase_function(draw) + "\n"
    if draw.happens(0.1):
        text += f"[{table}.density]\n" + draw.choice([
            "ramp = [[0, 0], [0.3, 0.1], [0.6, 2], [1, 0.5]]\n",
            "ramp = [[0, 0], [0.3, 0], [0.35, 1], [1, 0.5]]\n",
            "ramp = [[0, 0], [0.5, 1.5], [1, 1]]\nsmooth = true\n",
            f"scale = {draw.log(0.3, 3):.2f}\noffset = {draw.uniform(-0.2, 0):.2f}\nclamp = [0, 1.2]\n",
            f"power = {draw.uniform(0.5, 3):.2f}\n"])
    if draw.happens(0.1):
        colors = [[end, *draw.vector(0, 1)] for end in (0, 1)]
        text += f'[{table}.albedo_field]\ngrid = "density"\ncolors = {colors}\n'
    return text


def medium(draw):
    """The keys of a medium: thin as haze to thick as a cumulus."""
    lines = [f"extinction = {draw.log(0.2, 200):.4g}", f"albedo = {draw.color(0.4, 1)}", phase_function(draw)]
    if draw.happens(0.1):
        lines.append(f"extinction_color = {[1, *draw.vector(0.4, 1)[:2]]}")
    if draw.happens(0.07):
        lines.append(f"emission = {draw.light(0.1, 2)}")
    return lines


def fire(draw, table):
    return (f'[{table}.fire]\nfield = "density"\nintensity = {draw.log(5, 200):.3g}\n'
            f"kelvin = {draw.randint(1800, 5000)}\n")


def volumes(draw, recipes):
    """The clouds, of which some burn, and how the first is repeated."""
    text = ""
    for k in range(draw.choice([1, 1, 1, 2, 3])):
        table = "volume.medium" if k else "medium"
        text += f'[[volume]]\nfile = "{draw.choice(recipes)}"\n'
        burns = draw.happens(0.2)
        if burns and draw.happens(0.5):
            text += 'grid = "none"\n'
        if k == 0 and draw.happens(0.15):
            text += "".join(f"[[volume.instance]]\nscale = {draw.uniform(0.2, 0.6):.2f}\n"
                            f"translate = {draw.vector(-1.2, 1.2)}\n" for _ in range(draw.randint(2, 9)))
        text += motion(draw, "volume", "translate") + f"[{table}]\n" + "\n".join(medium(draw)) + "\n"
        if k > 0 or draw.happens(0.3):
            text += f"rotate = [0, 1, 0, {draw.randint(0, 359)}]\ntranslate = {draw.vector(-0.8, 0.8)}\n"
        text += maps(draw, table) + (fire(draw, table) if burns else "")
    return text


def write_sky(draw, file):
    """A picture of 16 x 8 pixels, some of which are bright."""
    pixels = [(*(draw.randint(1, 255) for _ in range(3)), draw.choice([125] * 9 + [130])) for _ in range(128)]
    file.write_bytes(b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 8 +X 16\n" +
                     b"".join(struct.pack("4B", *pixel) for pixel in pixels))


def environment(draw):
    kind = draw.choice(["constant", "gradient", "clear", "image"])
    text = f'[environment]\ntype = "{kind}"\n'
    if kind == "constant":
        text += f"radiance = {draw.light(0.01, 1)}\n"
    if kind == "image":
        text += f'file = "sky.hdr"\nrotation = {draw.randint(0, 359)}\n'
    if kind == "clear":
        text += (f"azimuth = {draw.randint(0, 359)}\nelevation = {draw.randint(2, 90)}\n"
                 f"turbidity = {draw.uniform(2, 8):.1f}\n")
    return text


def lamp(draw):
    at, kind = [round(1.6 * x, 3) for x in draw.direction()], draw.choice(["point", "ball", "spot", "area"])
    text = f"[[{'point' if kind == 'ball' else kind}]]\nposition = {at}\n"
    if kind in ("area", "ball") and draw.happens(0.3):
        text += "visible_camera = false\n"
    if kind == "area":
        return text + (f"direction = {[-x for x in at]}\nsize = [{draw.uniform(0.1, 1.5):.2f}, 0.5]\n"
                       f"radiance = {draw.light(1, 20)}\n")
    text += f"intensity = {draw.light(0.3, 10)}\n"
    if kind == "ball":
        text += f"radius = {draw.log(0.01, 0.2):.3f}\n"
    if kind == "spot":
        text += f"direction = {[-x for x in at]}\n"
        text += f"angle = {draw.randint(10, 80)}\nblend = {draw.random():.2f}\n"
    return text


def lights(draw):
    text = environment(draw) if draw.happens(0.5) else ""
    if draw.happens(0.5):
        text += (f"[[sun]]\ndirection = {draw.direction()}\nirradiance = {draw.light(0.3, 5)}\n"
                 f"angle = {draw.choice([0, 0.53, 5])}\n")
    if not text or draw.happens(0.3):
        text += "".join(lamp(draw) for _ in range(draw.choice([1, 1, 2, 3, 12])))
    return text


def look(draw):
    """Keys of surfaces: mostly none."""
    text = f'look = "{draw.choice(["shadow-catcher", "holdout"])}"\n' if draw.happens(0.15) else ""
    ray = draw.choice(["camera", "shadow", "light"])
    return text + (f"visible_{ray} = false\n" if draw.happens(0.15) else "")


def surfaces(draw):
    text = ""
    if draw.happens(0.35):
        text += f"[[plane]]\npoint = [0, {draw.uniform(-1.2, -0.3):.2f}, 0]\nalbedo = {draw.color(0, 0.8)}\n"
        text += look(draw)
    if draw.happens(0.15):
        text += f'[[mesh]]\nfile = "{SAMPLES}/cube.obj"\nscale = 0.3\n'
        text += f"translate = {draw.vector(-1, 1)}\nalbedo = {draw.color(0, 0.9)}\n" + look(draw)
        text += motion(draw, "mesh", "translate")
    if draw.happens(0.15):
        text += f"[[ball]]\ncentre = {draw.vector(-0.8, 0.8)}\nradius = {draw.log(0.05, 0.5):.2f}\n"
        text += f"albedo = {draw.color(0, 0.9)}\n" + look(draw) + motion(draw, "ball", "centre")
    return text


def lens(draw):
    """Keys of the camera: how it projects."""
    return draw.choice([f"fov = {draw.randint(20, 70)}\n"] * 7 + [
        'projection = "orthographic"\northo_scale = 3\n', 'projection = "latlong"\n',
        f"focal_length = {draw.randint(24, 85)}\nshift = [0.1, -0.05]\nf_stop = 1.4\nmetres = 0.1\n"])


def scene(draw, recipes):
    at = draw.direction()
    distance = draw.log(2, 7) if draw.happens(0.9) else draw.uniform(0, 1.5)
    camera = [round(distance * x / math.hypot(*at), 3) for x in at]
    text = volumes(draw, recipes) + lights(draw) + surfaces(draw)
    text += f"[camera]\nposition = {camera}\n"
    text += f"target = {draw.vector(-0.3, 0.3)}\n" + lens(draw)
    if draw.happens(0.5):
        text += f"shutter = {draw.choice([[-0.1, 0.1], [-0.1, 0.1], [-0.5, 0.5]])}\n"
        if draw.happens(0.2):
            text += f"[camera.to]\nposition = {camera}\ntarget = {draw.vector(-0.3, 0.3)}\n"
    return text + ('[render]\ninterpolation = "tricubic"\n' if draw.happens(0.1) else "")


def write_scene(number, folder):
    """A scene and its recipes; returns the file."""
    draw, recipes = Draw(number), ["0.toml", "1.toml"]
    for file in recipes:
        (folder / file).write_text(recipe(draw))
    write_sky(draw, folder / "sky.hdr")
    file = folder / "scene.toml"
    file.write_text(scene(draw, recipes))
    return file


def study_parser(text, scenes, spp):
    """The arguments of a study: the tools, and by default so many scenes and samples a pixel."""
    parser = argparse.ArgumentParser(description=text, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("tools", type=pathlib.Path)
    parser.add_argument("--scenes", type=int, default=scenes)
    parser.add_argument("--first", type=int, default=0)
    parser.add_argument("--spp", type=int, default=spp)
    parser.add_argument("--size", default="32x24")
    parser.add_argument("--keep", type=pathlib.Path)
    return parser


def study_scenes(args, study):
    """What study(number, file, folder) returns of each scene, by number. Those that --keep has are not
    studied again, and the others are added to it."""
    kept = {}
    if args.keep and args.keep.exists():
        kept = {r["scene"]: r["result"] for r in map(json.loads, args.keep.read_text().splitlines())}
    for number in range(args.first, args.first + args.scenes):
        if number in kept:
            continue
        with tempfile.TemporaryDirectory() as name:
            folder = pathlib.Path(name)
            file = write_scene(number, folder)
            try:
                kept[number] = study(number, file, folder)
            except RuntimeError as e:
                sys.exit(f"{file.read_text()}\nscene {number}: {e}")
        if args.keep:
            with args.keep.open("a") as out:
                print(json.dumps({"scene": number, "result": kept[number]}), file=out)
    return kept
