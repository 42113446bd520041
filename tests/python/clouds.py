"""Volumes that the tests share, whose optical depths are known."""
import numpy as np

import pvol


def slab(mu=2.0, n=16, **settings):
    """Constant density in a box: trilinear samples of 1 ramp down to 0 within a cell around it."""
    return pvol.Volume(np.ones((n, n, n), np.float32), extinction=mu, **settings)


def ramp(n=24):
    """A field that differs in every direction, so that axes cannot be mistaken."""
    i, j, k = np.meshgrid(np.arange(n), np.arange(n + 2), np.arange(n + 5), indexing="ij")
    return (1 + 0.3 * i + 0.05 * j + 0.011 * k).astype(np.float32)


def lumps(n=32):
    x, y, z = np.meshgrid(*[np.linspace(-1, 1, n)] * 3, indexing="ij")
    return np.clip(3 * (0.8 - np.sqrt(x * x + y * y + z * z)) + 0.4 * np.sin(7 * x) * np.sin(6 * y), 0, 1)
