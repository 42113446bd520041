"""Pictures of a scene by pvol and by Cycles, and comparisons that know their noise."""

import math
import os
import tempfile
from dataclasses import dataclass

import bpy
import numpy as np

SIGMAS = 4.0  # a chance of 1 in 16 000
TOLERANCE = 0.01  # of what both programs approximate in their own ways


@dataclass
class Shot:
    """Two independent pictures of one scene: rows from above, RGBA."""

    a: np.ndarray
    b: np.ndarray

    @property
    def rgba(self):
        return (self.a + self.b) / 2

    @property
    def alpha(self):
        return self.rgba[..., 3]

    def mean(self, where=None):
        """Mean radiance by channel and its standard error, from the difference of the two."""
        where = np.ones(self.a.shape[:2], dtype=bool) if where is None else where
        d = (self.a - self.b)[where][:, :3]
        error = np.sqrt((d * d).sum(axis=0)) / 2 / len(d)
        return self.rgba[where][:, :3].mean(axis=0), error

    def scaled(self, factor):
        return Shot(self.a * factor, self.b * factor)


def load(path):
    image = bpy.data.images.load(str(path))
    width, height = image.size
    pixels = np.array(image.pixels[:], dtype=np.float64).reshape(height, width, image.channels)
    bpy.data.images.remove(image)
    return pixels[::-1]


def render(engine, samples, seed=1):
    """One picture."""
    scene = bpy.context.scene
    scene.render.engine = engine
    scene.cycles.samples = scene.pvol.samples = samples
    scene.cycles.seed = scene.pvol.seed = seed
    scene.pvol.animate_seed = False
    settings = scene.render.image_settings
    settings.file_format, settings.color_mode, settings.color_depth = "OPEN_EXR", "RGBA", "32"
    with tempfile.TemporaryDirectory() as folder:
        scene.render.filepath = os.path.join(folder, "picture.exr")
        bpy.ops.render.render(write_still=True)
        return load(scene.render.filepath)


def shot(engine, samples):
    return Shot(render(engine, samples, 1), render(engine, samples, 2))


def both(pvol_samples=64, cycles_samples=64):
    """The scene by either program."""
    return shot("PVOL", pvol_samples), shot("CYCLES", cycles_samples)


def difference(p, c, where=None, tolerance=TOLERANCE):
    """Largest difference of the mean radiances over what noise and tolerance allow, and a text. The
    tolerance of a channel is half its own and half the brightest one's."""
    (mean_p, error_p), (mean_c, error_c) = p.mean(where), c.mean(where)
    size = (np.abs(mean_c) + np.abs(mean_c).max()) / 2
    allowed = SIGMAS * np.hypot(error_p, error_c) + tolerance * size
    excess = float((np.abs(mean_p - mean_c) / np.maximum(allowed, 1e-12)).max())
    ratio = mean_p[1] / mean_c[1] if mean_c[1] else math.nan
    noise = math.hypot(error_p[1], error_c[1]) / abs(mean_c[1]) if mean_c[1] else math.nan
    return excess, f"pvol / Cycles {ratio:.4f} +- {noise:.4f} (one sigma)"


def framing(alpha):
    """Centroid of what is there, and its spread across and down, in pixels."""
    y, x = np.mgrid[:alpha.shape[0], :alpha.shape[1]]
    total = alpha.sum()
    cx, cy = (alpha * x).sum() / total, (alpha * y).sum() / total
    return np.array([cx, cy, math.sqrt((alpha * (x - cx) ** 2).sum() / total),
                     math.sqrt((alpha * (y - cy) ** 2).sum() / total)])
