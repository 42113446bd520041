"""One shot by Cycles and by pvol, for the guide: two pictures of the same noise, and the CPU time
that each program takes for it.

    blender -b --factory-startup -P tests/blender/pair.py -- cumulus.vdb FOLDER

The .vdb is `pvol-convert samples/cumulus.toml cumulus.vdb`. Environment as for run.py."""

import math
import pathlib
import sys
import time

import bpy
import numpy as np

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent))

import pictures
import run
import scenes

SIZE = (400, 225)
NOISE = 0.06  # of the pictures that are saved


def scene_of(vdb):
    scene = scenes.empty()
    scene.render.resolution_x, scene.render.resolution_y = SIZE
    cloud = scenes.volume(vdb, scenes.smoke(60, (0.99, 0.99, 0.99), 0.5),
                          rotation=(math.pi / 2, 0, 0))
    cloud.data.render.space = "WORLD"
    scenes.lamp("SUN", (-3, -2.5, 3), energy=4, color=(1, 0.92, 0.8), angle=math.radians(0.5))
    scenes.background((0.16, 0.27, 0.5))
    scenes.floor(-0.35, color=(0.3, 0.28, 0.22))
    scenes.camera((0.6, -5.2, 0.7), (0, 0, 0.42), lens=60)
    scene.cycles.max_bounces = scene.cycles.volume_bounces = 256
    scene.view_settings.view_transform = "Standard"
    return scene


def measure(engine, samples):
    """CPU time of a picture in seconds, and its noise: the root mean square of the standard error
    over the mean, in the part that shows the cloud."""
    shots, seconds = [], []
    for seed in (1, 2):
        start = time.process_time()
        shots.append(pictures.render(engine, samples, seed)[..., :3])
        seconds.append(time.process_time() - start)
    a, b = (s[17:158, 92:308] for s in shots)
    # Fireflies would decide over a mean of squares: the middle of the squares stands for normal
    # noise, of which 0.4549 is the median square.
    middle = np.median((a - b) ** 2, axis=(0, 1)).mean() / 2 / 0.4549
    return min(seconds), math.sqrt(middle) / a.mean(), a.mean(axis=(0, 1))


def save(engine, samples, path):
    scene = bpy.context.scene
    scene.render.engine = engine
    scene.cycles.samples = scene.pvol.samples = samples
    scene.render.image_settings.file_format = "PNG"
    scene.render.image_settings.color_mode, scene.render.image_settings.color_depth = "RGB", "8"
    scene.render.filepath = str(path)
    bpy.ops.render.render(write_still=True)


def main():
    vdb, folder = map(pathlib.Path, sys.argv[sys.argv.index("--") + 1:])
    run.install()
    scene_of(vdb)
    found = {}
    for engine, samples in (("PVOL", 32), ("CYCLES", 32)):
        found[engine] = seconds, noise, mean = measure(engine, samples)
        print(f"pair: {engine}: {samples} samples, {seconds:.2f} s, noise {100 * noise:.2f} %, "
              f"{seconds * (noise / NOISE) ** 2:.1f} s to {NOISE:.0%}, mean {mean.round(4)}")
    cost = {engine: seconds * noise**2 for engine, (seconds, noise, _) in found.items()}
    print(f"pair: Cycles takes {cost['CYCLES'] / cost['PVOL']:.1f} times as long to the same noise")
    for engine, (_, noise, _) in found.items():
        save(engine, max(1, round(32 * (noise / NOISE) ** 2)), folder / f"{engine.lower()}.png")


main()
