"""Renders one shot by Cycles and by pvol in turn, and compares their noise and their CPU time.

    pvol-convert samples/cumulus.toml cumulus.vdb
    blender -b -P tests/bench/cycles.py -- build/release/tools/pvol-render cumulus.vdb

The shot: a cloud some two units wide, a cube and a ground of albedo 0.2 under a sun 20 degrees high and a grey
sky; 320 x 180 pixels of a box filter, one thread, no limit of bounces, no clamp. E is CPU time times variance,
by pixels of luminance, from as many renders of each as --seeds says. Made for Blender 3.4.
"""
import argparse
import math
import pathlib
import resource
import subprocess
import sys
import tempfile
import time

import bpy
import numpy as np
from mathutils import Vector

EXTINCTION, ANISOTROPY, SKY, SUN, GROUND, CUBE = 40, 0.5, 0.4, 3, 0.2, 0.3
TOWARDS_SUN = (0.8138, -0.4698, 0.3420)
FROM, TO, FOV = (0.5, -5.0, 0.4), (0.3, 0.0, -0.35), 30
SIZE = (320, 180)
LOW, LEFT = slice(120, 178), slice(0, 200)  # rows and columns that show nothing but the ground

SCENE = f"""[volume]
file = "CLOUD"
[medium]
extinction = {EXTINCTION}
albedo = 1
g = {ANISOTROPY}
[camera]
position = {list(FROM)}
target = {list(TO)}
up = [0, 0, 1]
fov = {FOV}
[environment]
radiance = {SKY}
[[sun]]
direction = {list(TOWARDS_SUN)}
irradiance = {SUN}
angle = 0.53
[[plane]]
point = [0, 0, -1]
normal = [0, 0, 1]
albedo = {GROUND}
[[mesh]]
file = "cube.obj"
albedo = {CUBE}
[render]
size = {list(SIZE)}
"""


def write_cube(file):
    corners = [(x, y, z) for z in (-1.0, -0.4) for x, y in ((1.0, -1.0), (1.6, -1.0), (1.6, -0.4), (1.0, -0.4))]
    faces = ("1 4 3 2", "5 6 7 8", "1 2 6 5", "2 3 7 6", "3 4 8 7", "4 1 5 8")
    file.write_text("".join("v %g %g %g\n" % c for c in corners) + "".join(f"f {f}\n" for f in faces))


def diffuse(albedo):
    material = bpy.data.materials.new("diffuse")
    material.use_nodes = True
    nodes = material.node_tree.nodes
    nodes.clear()
    out, bsdf = nodes.new("ShaderNodeOutputMaterial"), nodes.new("ShaderNodeBsdfDiffuse")
    bsdf.inputs["Color"].default_value = (albedo, albedo, albedo, 1)
    material.node_tree.links.new(bsdf.outputs[0], out.inputs["Surface"])
    return material


def cloud_material():
    material = bpy.data.materials.new("cloud")
    material.use_nodes = True
    nodes = material.node_tree.nodes
    nodes.clear()
    out, volume = nodes.new("ShaderNodeOutputMaterial"), nodes.new("ShaderNodeVolumePrincipled")
    volume.inputs["Color"].default_value = (1, 1, 1, 1)
    volume.inputs["Density"].default_value = EXTINCTION
    volume.inputs["Anisotropy"].default_value = ANISOTROPY
    material.node_tree.links.new(volume.outputs[0], out.inputs["Volume"])
    return material


def add_things(cloud):
    bpy.ops.mesh.primitive_plane_add(size=2000, location=(0, 0, -1))
    bpy.context.object.data.materials.append(diffuse(GROUND))
    bpy.ops.mesh.primitive_cube_add(size=0.6, location=(1.3, -0.7, -0.7))
    bpy.context.object.data.materials.append(diffuse(CUBE))
    bpy.ops.object.volume_import(filepath=cloud, align="WORLD", location=(0, 0, 0))
    bpy.context.object.data.materials.append(cloud_material())


def add_light_and_camera(scene):
    scene.world = bpy.data.worlds.new("sky")
    scene.world.use_nodes = True
    scene.world.node_tree.nodes["Background"].inputs[0].default_value = (SKY, SKY, SKY, 1)
    lamp = bpy.data.lights.new("sun", "SUN")
    lamp.energy, lamp.angle = SUN, math.radians(0.53)
    sun = bpy.data.objects.new("sun", lamp)
    sun.rotation_euler = Vector(TOWARDS_SUN).to_track_quat("Z", "Y").to_euler()
    lens = bpy.data.cameras.new("camera")
    lens.sensor_fit, lens.angle = "VERTICAL", math.radians(FOV)
    camera = bpy.data.objects.new("camera", lens)
    camera.location = FROM
    camera.rotation_euler = (Vector(TO) - Vector(FROM)).to_track_quat("-Z", "Y").to_euler()
    for thing in (sun, camera):
        scene.collection.objects.link(thing)
    scene.camera = camera


def set_up_cycles(samples):
    scene = bpy.context.scene
    scene.render.engine = "CYCLES"
    c = scene.cycles
    c.samples, c.use_adaptive_sampling, c.use_denoising = samples, False, False
    c.max_bounces = c.diffuse_bounces = c.volume_bounces = 256
    c.sample_clamp_direct = c.sample_clamp_indirect = c.light_sampling_threshold = 0
    c.pixel_filter_type, c.volume_step_rate = "BOX", 1
    r = scene.render
    r.threads_mode, r.threads, r.use_persistent_data = "FIXED", 1, True
    r.resolution_x, r.resolution_y, r.resolution_percentage = *SIZE, 100
    r.image_settings.file_format, r.image_settings.color_depth = "OPEN_EXR", "32"
    return scene


def luminance(file):
    image = bpy.data.images.load(str(file))
    image.colorspace_settings.name = "Non-Color"
    pixels = np.array(image.pixels[:], dtype=np.float64).reshape(SIZE[1], SIZE[0], -1)[::-1]
    return pixels[..., :3] @ [0.2126, 0.7152, 0.0722]


def render_by_cycles(scene, folder, seed):
    scene.cycles.seed, scene.render.filepath = seed, str(folder / "cycles.exr")
    begin = time.process_time()
    bpy.ops.render.render(write_still=True)
    return time.process_time() - begin, luminance(scene.render.filepath)


def render_by_pvol(tool, folder, seed, options):
    def seconds():
        return resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime
    out, begin = folder / f"pvol{seed}.exr", seconds()
    subprocess.run([tool, folder / "shot.toml", "-o", out, "--no-png", "--quiet", "--threads", "1", "--seed",
                    str(seed), *options], check=True)
    return seconds() - begin, out


def main():
    parser = argparse.ArgumentParser(prog="cycles.py", description=__doc__.split("\n", maxsplit=1)[0])
    parser.add_argument("pvol_render")
    parser.add_argument("cloud", help=".vdb with a grid named density, some two units wide")
    parser.add_argument("--samples", type=int, default=16, help="of each pixel [16]")
    parser.add_argument("--seeds", type=int, default=4, help="renders of each [4]")
    given = parser.parse_args(sys.argv[sys.argv.index("--") + 1:] if "--" in sys.argv else ["--help"])
    bpy.ops.wm.read_factory_settings(use_empty=True)
    cloud = str(pathlib.Path(given.cloud).resolve())
    scene = set_up_cycles(given.samples)
    add_things(cloud)
    add_light_and_camera(scene)
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        write_cube(folder / "cube.obj")
        (folder / "shot.toml").write_text(SCENE.replace("CLOUD", cloud))
        start_up = render_by_pvol(given.pvol_render, folder, 0, ["--size", "1x1", "--spp", "1"])[0]
        render_by_cycles(scene, folder, 99)  # which loads the cloud
        runs = {"Cycles": [], "pvol": []}
        for seed in range(1, given.seeds + 1):
            runs["Cycles"].append(render_by_cycles(scene, folder, seed))
            took, file = render_by_pvol(given.pvol_render, folder, seed, ["--spp", str(given.samples)])
            runs["pvol"].append((took - start_up, luminance(file)))
    seconds = {who: float(np.median([t for t, _ in all_runs])) for who, all_runs in runs.items()}
    pictures = {who: np.array([p for _, p in all_runs]) for who, all_runs in runs.items()}
    print("CPU seconds: " + ", ".join(f"{who} {s:.2f}" for who, s in seconds.items()))
    print(f"{'pixels':10}{'mean, Cycles':>14}{'pvol':>10}{'E, Cycles/pvol':>16}{'of medians':>12}")
    for label, where in (("all", (slice(None), slice(None))), ("ground", (LOW, LEFT))):
        mean, noise, median = {}, {}, {}
        for who, p in pictures.items():
            part = p[(slice(None), *where)]
            variance = part.var(axis=0, ddof=1)
            mean[who] = part.mean()
            noise[who], median[who] = (seconds[who] * f(variance) for f in (np.mean, np.median))
        print(f"{label:10}{mean['Cycles']:14.5f}{mean['pvol']:10.5f}{noise['Cycles'] / noise['pvol']:16.2f}"
              f"{median['Cycles'] / median['pvol']:12.2f}")


if __name__ == "__main__":
    main()
