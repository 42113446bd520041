"""Clouds, smoke and fire for people who measure: pvol from Python.

A volume is a density on a lattice with bounds. It comes from an array, where sample (i, j, k) is
array[i, j, k], or from a file::

    import numpy as np
    import pvol

    x, y, z = np.mgrid[-1:1:64j, -1:1:64j, -1:1:64j]
    ball = np.maximum(0, 1 - x * x - y * y - z * z)
    volume = pvol.Volume(ball, voxel_size=2 / 63, extinction=20, albedo=0.99, g=0.6)
    cloud = pvol.load("cloud.vdb")                     # or .pvol, .nvdb, a recipe (.toml)

Rays go in as arrays and come back as arrays, on all threads; origins, directions and limits
broadcast against each other, and directions are normalised. Results are the same for any number of
threads, and each call wants a seed of its own::

    t = volume.flights(origins, directions, seed=1)                    # inf: no collision
    t, work = volume.flights(origins, directions, counts=True)         # work["lookups"], ...
    T = volume.transmittance(origins, directions, estimator="ratio")
    tau = volume.optical_depth(origins, directions)                    # exact

What rays are led by can be looked at: ``volume.bounds()`` are the cubes where walks stop,
``volume.segments(origin, direction)`` the pieces of one ray, ``volume.shell`` or
``pvol.fit_shell(volume)`` a closed surface around all of it.

Pictures are rendered from a scene file, from a dict of the sections of one, or from volumes::

    picture = pvol.render(volume, size=(320, 240), spp=64, camera={"azimuth": 30})
    picture.rgb, picture.error           # (H, W, 3): means, standard errors
    picture.save("ball.png")
    pvol.compare(picture, pvol.render(volume, size=(320, 240), spp=64, seed=2, tracker="delta"))
    pvol.trade(volume, [{"depth": 0}, {"tracker": "delta"}])

Settings are called as they are in scene files and on command lines; what is wrong with one, the
message says, in a ``pvol.Error``. Lengths are in world units, extinction is per world unit and unit
of density.

Volumes and pictures never change: any number of threads may use them at once. Calls that take long
let other threads of Python run, and end on Ctrl-C.
"""

from ._pvol import (
    Error,
    Live,
    Picture,
    Shell,
    Volume,
    __version__,
    compare,
    fit_shell,
    load,
    read_picture,
    render,
    tone_maps,
    trade,
)

__all__ = [
    "Error",
    "Live",
    "Picture",
    "Shell",
    "Volume",
    "__version__",
    "compare",
    "fit_shell",
    "load",
    "read_picture",
    "render",
    "tone_maps",
    "trade",
]

for _thing in (
    Error, Live, Picture, Shell, Volume,
    compare, fit_shell, load, read_picture, render, tone_maps, trade,
):  # fmt: skip
    _thing.__module__ = "pvol"  # where people find it, in help and in messages
del _thing
