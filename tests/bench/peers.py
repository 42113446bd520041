#!/usr/bin/env python3
"""The scenes of tests/references by pvol, pbrt-v4 and Cycles: do they agree, and at what cost and noise?

    tests/bench/peers.py --tools build/release/tools [--pbrt BINARY] [--blender BINARY] [--scene NAME]...
    tests/bench/peers.py --tools build/release/tools --make     # the reference pictures anew, an hour

Each program renders each scene --seeds times with --spp samples on one thread, in turn. The table has, for
each scene and program,

  mean    of the picture over that of the reference picture
  Z       the difference of these means in standard errors of both
  chi2    the mean over blocks of 4 x 4 pixels of squared differences in units of their variances: about 1
          where they agree, somewhat less where samples are stratified, as those of the references are;
          of blocks of at least 1 % of the picture's mean, since darker ones are met by few samples
  CPU     seconds a run, without those of a run of one sample a pixel
  E       CPU times the mean variance of a pixel, over that of pvol
  rel     CPU times the mean of variance / (mean^2 + (1 % of the picture's mean)^2), over that of pvol

Scenes are grey and pvol's; what pbrt reads is written here, with densities as text, and Cycles is set up by
peers_cycles.py (Blender 3.4; it marches in steps, which has a bias). What a program does not have is left
out. References are made by flights one by one, against one majorant for all, without guiding, with analog
shadow rays: the plainest tracker of pvol, and not the one that renders by default.
"""
import argparse
import math
import pathlib
import re
import resource
import struct
import subprocess
import sys
import tempfile
import tomllib

from scenes import read_exr

REFERENCES = pathlib.Path(__file__).resolve().parents[1] / "references"
PLAINEST = ["--kernel", "scalar", "--tracker", "delta-global", "--guide", "off", "--transmittance", "analog",
            "--seed", "1000003"]
SAMPLES = 16384  # of a pixel of a reference


class NotThere(Exception):
    """A program lacks what a scene has."""


def names():
    return sorted(f.stem for f in REFERENCES.glob("*.toml") if "[camera]" in f.read_text())


def seconds_of(command, **more):
    """CPU seconds that the command takes."""
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    run = subprocess.run([str(c) for c in command], capture_output=True, text=True, check=False, **more)
    if run.returncode:
        sys.exit(f"{command[0]} fails:\n{run.stdout[-2000:]}{run.stderr[-2000:]}")
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime


def luminances(planes, layer=""):
    return [sum(v) / 3 for v in zip(*(planes[layer + c] for c in "RGB"))]


def read_scene(name):
    return tomllib.loads((REFERENCES / f"{name}.toml").read_text())


def volumes_of(scene):
    """(file, medium) of each; a volume in several places is as many."""
    volumes = scene["volume"] if isinstance(scene["volume"], list) else [scene["volume"]]
    return [(v["file"], v.get("medium", scene["medium"]) | place) for v in volumes
            for place in v.get("instance", [{}])]


def cloud_of(tools, file, folder):
    """The samples of a recipe, as a .vdb in the folder."""
    cloud = folder / f"{file}.vdb"
    if not cloud.exists():
        seconds_of([tools / "pvol-convert", REFERENCES / file, cloud])
    return cloud


# --- pvol

def render_by_pvol(tools, name, folder, spp, seed):
    picture = folder / "pvol.exr"
    seconds = seconds_of([tools / "pvol-render", REFERENCES / f"{name}.toml", "-o", picture, "--no-png",
                          "--quiet", "--threads", 1, "--spp", spp, "--seed", seed])
    return seconds, luminances(read_exr(picture))


def make_references(tools, chosen):
    for name in chosen:
        scene, picture = (REFERENCES / f"{name}.{ending}" for ending in ("toml", "exr"))
        command = [tools / "pvol-render", scene, "-o", picture, "--no-png", "--aov", "variance,samples",
                   "--spp", SAMPLES, *PLAINEST]
        subprocess.run([str(c) for c in command], check=True)


# --- pbrt

def grid_of(tools, file, folder):
    """Samples with a layer of zeros around, x fastest; their counts; place of the first; edge of a voxel."""
    sys.path.insert(0, str(tools.parent / "python"))
    import numpy as np
    import pvol
    volume = pvol.load(cloud_of(tools, file, folder))
    matrix = np.array(volume.index_to_world)
    edge = matrix[0, 0]
    if not np.allclose(matrix[:3, :3], edge * np.eye(3)):
        raise NotThere("turned grids")
    low, high = np.array(volume.support)
    axes = [np.arange(low[k] - 1, high[k] + 2) for k in range(3)]
    points = np.stack(np.meshgrid(*axes, indexing="ij"), -1) * edge + matrix[:3, 3]
    samples = np.asarray(volume.density(points)).transpose(2, 1, 0).reshape(-1)
    return samples, [len(a) for a in axes], points[0, 0, 0], edge


def spectrum(value):
    return f"[ 200 {value} 900 {value} ]"


def triple(values):
    return " ".join(f"{float(v):.9g}" for v in values)


def pbrt_volume(tools, file, medium, number, folder):
    """Its definition, the box around it as a shape, and the two corners of that in the world."""
    samples, counts, first, edge = grid_of(tools, file, folder)
    low = [f - edge / 2 + m for f, m in zip(first, medium.get("translate", [0, 0, 0]))]
    high = [f + n * edge for f, n in zip(low, counts)]
    extinction, albedo = medium["extinction"], medium["albedo"]
    light = ""
    if "emission" in medium:  # by its own scales, without which it would fade towards the corners
        light = f'"rgb Le" [ {triple([medium["emission"]] * 3)} ] "float Lescale" [ {"1 " * len(samples)} ]'
    corners = [[(low, high)[(i >> k) & 1][k] for k in range(3)] for i in range(8)]
    definition = f"""MakeNamedMedium "m{number}" "string type" "uniformgrid"
  "point3 p0" [ {triple(low)} ] "point3 p1" [ {triple(high)} ]
  "integer nx" {counts[0]} "integer ny" {counts[1]} "integer nz" {counts[2]}
  "spectrum sigma_a" {spectrum(extinction * (1 - albedo))} "spectrum sigma_s" {spectrum(extinction * albedo)}
  "float g" {medium["g"]} {light}
  "float density" [ {" ".join(f"{v:.9g}" for v in samples)} ]
"""
    shape = f"""AttributeBegin
MediumInterface "m{number}" ""
Material "interface"
Shape "trianglemesh" "point3 P" [ {" ".join(triple(c) for c in corners)} ]
  "integer indices" [ 0 2 1 1 2 3 4 5 6 5 7 6 0 1 4 1 5 4 2 6 3 3 6 7 0 4 2 2 4 6 1 3 5 3 7 5 ]
AttributeEnd
"""
    return definition, shape, (low, high)


def directions_of(side):
    """Those of the pixels of pbrt's pictures of skies, side x side pixels of equal solid angles, row by row:
    four triangles meet in the middle, at +z, and four in the corners, at -z (Clarberg 2008)."""
    import numpy as np
    across, down = np.meshgrid(*[(np.arange(side) + 0.5) / side * 2 - 1] * 2)
    beyond = abs(across) + abs(down) - 1  # above 0: below the horizon
    r = 1 - abs(beyond)
    angle = (1 + (abs(down) - abs(across)) / np.maximum(r, 1e-12)) * math.pi / 4
    flat = r * np.sqrt(2 - r * r)
    return (np.copysign(np.cos(angle) * flat, across), np.copysign(np.sin(angle) * flat, down),
            np.copysign(1 - r * r, -beyond))


def pbrt_sky(file, folder):
    """The picture of a sky in the form and the shape that pbrt reads; its name in the folder."""
    import numpy as np
    head, size, pixels = re.fullmatch(rb"(.*?\n\n)(-Y \d+ \+X \d+)\n(.*)", (REFERENCES / file).read_bytes(),
                                      re.S).groups()
    height, width = (int(n) for n in re.findall(rb"\d+", size))
    rgbe = np.frombuffer(pixels, np.uint8).reshape(height, width, 4).astype(float)
    radiance = rgbe[..., 0] * 2.0 ** (rgbe[..., 3] - 136)
    x, y, z = directions_of(1024)
    rows = np.minimum(np.arccos(y) / math.pi * height, height - 1).astype(int)
    columns = (np.arctan2(z, x) / (2 * math.pi) % 1 * width).astype(int) % width
    values = radiance[rows, columns].astype("<f4")[::-1]
    name = pathlib.Path(file).with_suffix(".pfm").name
    (folder / name).write_bytes(b"PF\n%d %d\n-1\n" % values.shape + np.repeat(values, 3).tobytes())
    return name


def pbrt_mesh(mesh):
    """Triangles, in the first volume."""
    lines = [line.split() for line in (REFERENCES / mesh["file"]).read_text().splitlines()]
    points = " ".join(triple(words[1:]) for words in lines if words[0] == "v")
    corners = " ".join(str(int(i) - 1) for words in lines if words[0] == "f" for i in words[1:])
    return (f'AttributeBegin\nMediumInterface "m0" "m0"\n'
            f'Material "diffuse" "spectrum reflectance" {spectrum(mesh["albedo"])}\n'
            f'Shape "trianglemesh" "point3 P" [ {points} ]\n  "integer indices" [ {corners} ]\nAttributeEnd\n')


def pbrt_lights(scene, folder):
    def grey(key, value):
        return f'"rgb {key}" [ {value} {value} {value} ]'
    text = ""
    if "file" in scene["environment"]:
        text += f'LightSource "infinite" "string filename" "{pbrt_sky(scene["environment"]["file"], folder)}"\n'
    elif scene["environment"]["radiance"]:
        text += f'LightSource "infinite" {grey("L", scene["environment"]["radiance"])}\n'
    for sun in scene.get("sun", []):
        text += (f'LightSource "distant" "point3 from" [ {triple(sun["direction"])} ] "point3 to" [ 0 0 0 ] '
                 f'{grey("L", sun["irradiance"])}\n')
    for lamp in scene.get("point", []):
        text += (f'LightSource "point" "point3 from" [ {triple(lamp["position"])} ] '
                 f'{grey("I", lamp["intensity"])}\n')
    for spot in scene.get("spot", []):
        to = [a + b for a, b in zip(spot["position"], spot["direction"])]
        cone = spot["angle"] / 2
        text += (f'LightSource "spot" "point3 from" [ {triple(spot["position"])} ] '
                 f'"point3 to" [ {triple(to)} ] {grey("I", spot["intensity"])} "float coneangle" {cone} '
                 f'"float conedeltaangle" {cone * spot["blend"]}\n')
    for area in scene.get("area", []):
        if area["direction"] != [0, 0, 1]:
            raise NotThere("areas that look elsewhere than along z")
        x, y, z = area["position"]
        w, h = (edge / 2 for edge in area["size"])
        corners = [(x - w, y - h, z), (x + w, y - h, z), (x - w, y + h, z), (x + w, y + h, z)]
        text += (f'AttributeBegin\nMaterial "diffuse" "spectrum reflectance" {spectrum(0)}\n'
                 f'AreaLightSource "diffuse" {grey("L", area["radiance"])}\n'
                 f'Shape "bilinearmesh" "point3 P" [ {" ".join(triple(c) for c in corners)} ]\nAttributeEnd\n')
    for plane in scene.get("plane", []):
        height = plane["point"][1]
        text += (f'AttributeBegin\nMaterial "diffuse" "spectrum reflectance" {spectrum(plane["albedo"])}\n'
                 f'Shape "bilinearmesh" "point3 P" [ -1e4 {height} -1e4 1e4 {height} -1e4 -1e4 {height} 1e4 '
                 f'1e4 {height} 1e4 ]\nAttributeEnd\n')
    return text + "".join(pbrt_mesh(mesh) for mesh in scene.get("mesh", []))


def pbrt_scene(tools, scene, folder):
    camera, size = scene["camera"], scene["render"]["size"]
    volumes = [pbrt_volume(tools, file, medium, i, folder)
               for i, (file, medium) in enumerate(volumes_of(scene))]
    around_eye = [f"m{i}" for i, (_, _, (low, high)) in enumerate(volumes)
                  if all(a < x < b for a, x, b in zip(low, camera["position"], high))]
    return f"""Film "rgb" "integer xresolution" {size[0]} "integer yresolution" {size[1]}
  "bool savefp16" false "string filename" "picture.pfm"
PixelFilter "box" "float xradius" 0.5 "float yradius" 0.5
Sampler "independent" "integer pixelsamples" 16
Integrator "volpath" "integer maxdepth" 100000
{"".join(definition for definition, _, _ in volumes)}
Scale -1 1 1
LookAt {triple(camera["position"])}  {triple(camera["target"])}  0 1 0
MediumInterface "" "{"".join(around_eye)}"
Camera "perspective" "float fov" {camera["fov"]}
WorldBegin
MediumInterface "" ""
{pbrt_lights(scene, folder)}""" + "".join(shape for _, shape, _ in volumes)


def read_pfm(file):
    head, size, scale, data = file.read_bytes().split(b"\n", 3)
    width, height = (int(v) for v in size.split())
    channels = 3 if head == b"PF" else 1
    values = struct.unpack(f"{'<' if float(scale) < 0 else '>'}{width * height * channels}f", data)
    rows = [values[y * width * channels:(y + 1) * width * channels] for y in range(height)]
    return [sum(row[channels * x:channels * x + channels]) / channels for row in reversed(rows)
            for x in range(width)]


def render_by_pbrt(pbrt, tools, name, folder, spp, seed):
    scene = folder / f"{name}.pbrt"
    if not scene.exists():
        scene.write_text(pbrt_scene(tools, read_scene(name), folder))
    picture = folder / "picture.pfm"
    # Media are defined before the camera, which may be in one: its place must not move them.
    seconds = seconds_of([pbrt.resolve(), "--nthreads", 1, "--spp", spp, "--seed", seed, "--quiet",
                          "--render-coord-sys", "world", "--outfile", picture, scene], cwd=folder)
    return seconds, read_pfm(picture)


# --- Cycles

def render_by_cycles(blender, tools, name, folder, spp, seed):
    scene = read_scene(name)
    if "spot" in scene or "area" in scene or any("emission" in medium for _, medium in volumes_of(scene)):
        raise NotThere("a spot that fades so, areas that are seen, or emission by absorption")
    for file, _ in volumes_of(scene):
        cloud_of(tools, file, folder)
    picture = folder / "cycles.exr"
    script = pathlib.Path(__file__).with_name("peers_cycles.py")
    seconds = seconds_of([blender, "-b", "-P", script, "--", REFERENCES / f"{name}.toml", folder, picture,
                          spp, seed])
    return seconds, luminances(read_exr(picture))


# --- the table

def blocks_of(pixels):
    """Means over blocks of 4 x 4 pixels of a square picture."""
    side = math.isqrt(len(pixels))
    return [sum(pixels[(y + j) * side + x + i] for j in range(4) for i in range(4)) / 16
            for y in range(0, side, 4) for x in range(0, side, 4)]


def moments(values):
    """The mean of equal positions in several lists, and their variance."""
    count = len(values)
    means = [sum(v) / count for v in zip(*values)]
    return means, [sum((x - m) ** 2 for x in v) / (count - 1) for v, m in zip(zip(*values), means)]


def measure(render, name, folder, spp, seeds):
    """CPU seconds a run, without what takes no samples, and the pictures of all seeds."""
    base = render(name, folder, 1, 1)[0]
    runs = [render(name, folder, spp, seed) for seed in range(1, seeds + 1)]
    return (sum(r[0] for r in runs) / seeds - base) * spp / (spp - 1), [r[1] for r in runs]


def row_of(seconds, pictures, reference, own):
    expected, expected_variances = reference
    seeds, count = len(pictures), len(expected)
    means, variances = moments(pictures)
    blocks, block_variances = moments([blocks_of(p) for p in pictures])
    error = math.sqrt(sum(variances) / seeds + sum(expected_variances))
    # The variance of a block from few seeds is rough: this ratio is (seeds - 1) / (seeds - 3) on the average.
    rows = zip(blocks, blocks_of(expected), block_variances, blocks_of(expected_variances))
    dark = 0.01 * sum(expected) / count
    rounding = 1e-6  # of an open sky, whose variance is 0
    ratios = [(m - e) ** 2 / (v / seeds + w / 16 + (rounding * e) ** 2) for m, e, v, w in rows if e > dark]
    chi2 = sum(ratios) / len(ratios) * (seeds - 3) / (seeds - 1)
    e = seconds * sum(variances) / count
    rel = seconds * sum(v / (x * x + dark * dark) for v, x in zip(variances, expected)) / count
    own = own or (e, rel)
    return (f"{sum(means) / sum(expected):.4f} | {(sum(means) - sum(expected)) / error:+.1f} | {chi2:.2f} | "
            f"{seconds:.2f} | {e / own[0]:.2f} | {rel / own[1]:.2f}"), own


def main():
    a = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    a.add_argument("--tools", type=pathlib.Path, required=True,
                   help="folder of pvol-render and pvol-convert; the Python module is in ../python")
    a.add_argument("--pbrt", type=pathlib.Path)
    a.add_argument("--blender", type=pathlib.Path)
    a.add_argument("--scene", action="append", choices=names(), help="may be repeated; all without")
    a.add_argument("--spp", type=int, default=512,
                   help="enough that times are well above those of a start (512)")
    a.add_argument("--seeds", type=int, default=8, help="at least 4")
    a.add_argument("--make", action="store_true", help="render the references anew")
    o = a.parse_args()
    chosen, tools = o.scene or names(), o.tools.resolve()
    if o.make:
        make_references(tools, chosen)
        return
    programs = {"pvol": lambda *more: render_by_pvol(tools, *more)}
    if o.pbrt:
        programs["pbrt-v4"] = lambda *more: render_by_pbrt(o.pbrt, tools, *more)
    if o.blender:
        programs["Cycles"] = lambda *more: render_by_cycles(o.blender, tools, *more)
    print("| scene | program | mean | Z | chi2 | CPU | E | rel |\n|---|---|---|---|---|---|---|---|")
    with tempfile.TemporaryDirectory() as temporary:
        for name in chosen:
            planes = read_exr(REFERENCES / f"{name}.exr")
            # Channels of a grey scene share their samples: the variance of their mean is that of each.
            reference, own = (luminances(planes), luminances(planes, "variance.")), None
            for program, render in programs.items():
                try:
                    measured = measure(render, name, pathlib.Path(temporary), o.spp, o.seeds)
                except NotThere:
                    continue
                row, own = row_of(*measured, reference, own)
                print(f"| {name} | {program} | {row} |", flush=True)


if __name__ == "__main__":
    main()
