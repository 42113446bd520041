"""A program in Python, against the module as it is installed: bounds, flights, transmittances and a
picture of an array, by closed forms, and the shared library of C in the same process.

    PYTHONPATH=PREFIX/lib/python3/dist-packages python3 module.py PREFIX BUILD [LIBPVOL]

Nothing may come from BUILD but what is below PREFIX. With LIBPVOL that library is loaded first, for
all to see, as in a program that is linked with it.
"""
import ctypes
import os
import sys

import numpy as np

SIZE, EXTINCTION, RAYS = 40, 1.0, 400_000


def density() -> np.ndarray:
    """Waves on a slope, equal in y and z, as in c_client.c."""
    x = np.arange(SIZE)
    wave = 0.001 * x * (1.2 + np.sin(0.5 * x))
    return np.broadcast_to(wave[:, None, None], (SIZE,) * 3).astype(np.float32)


def optical_depth() -> float:
    """Along x through the middle: the trapezia of the samples, which end a cell outside at 0."""
    return EXTINCTION * density()[:, 20, 20].sum(dtype=float)


def check(what: str, found: float, exact: float, tolerance: float) -> None:
    """Seeds are fixed; tolerances of what is random are four standard errors, below 1 %."""
    print(f"{what:28} {found:.5f}, exactly {exact:.5f}")
    assert abs(found - exact) <= tolerance, f"{what} is wrong"


def check_files(pvol, prefix: str, build: str) -> None:
    for module in (pvol, pvol._pvol):
        path = os.path.realpath(module.__file__)
        assert path.startswith(prefix + os.sep), f"{path} is not below {prefix}"
    if os.path.exists("/proc/self/maps"):
        with open("/proc/self/maps") as maps:
            mapped = {line[line.index("/") :].rstrip("\n") for line in maps if "/" in line}
        assert os.path.realpath(pvol._pvol.__file__) in mapped
        strays = [p for p in mapped if p.startswith(build + os.sep) and not p.startswith(prefix + os.sep)]
        assert not strays, f"of the build tree: {strays}"


def check_rays(volume) -> None:
    depth = optical_depth()
    through = np.array([-1.0, 20.0, 20.0]), np.array([2.0, 0.0, 0.0])
    check("optical depth", float(volume.optical_depth(*through)), depth, 1e-5)
    exact = float(volume.transmittance(*through, estimator="exact"))
    check("transmittance, exact", exact, np.exp(-depth), 1e-5)

    origins = np.broadcast_to(through[0], (RAYS, 3))
    t = volume.flights(origins, through[1], seed=1)
    check("flights that pass", np.isinf(t).mean(), np.exp(-depth), 0.0035)
    assert t[np.isfinite(t)].min() >= 0 and t[np.isfinite(t)].max() <= SIZE + 1
    for seed, estimator in enumerate(("ratio", "residual-ratio", "analog"), start=2):
        mean = volume.transmittance(origins, through[1], seed=seed, estimator=estimator).mean()
        check(f"transmittance, {estimator}", mean, np.exp(-depth), 0.0035)


def check_bounds(volume) -> None:
    """No extinction above its majorant, none below its minorant, in the middles of all cubes."""
    cubes = volume.bounds()
    found = volume.extinction_at(cubes["lo"] + cubes["edge"][:, None] / 2)
    assert len(cubes) > 1 and found.max() > 0
    assert (cubes["minorant"] <= found).all() and (found <= cubes["majorant"]).all()


def check_picture(pvol, volume) -> None:
    """Without scattering a picture is the transmittance; two of them differ by noise alone."""
    view = {
        "size": (24, 24),
        "spp": 512,
        "environment": {"type": "constant", "radiance": 1.0},
        "camera": {"position": [-2000.0, 20.0, 20.0], "target": [0.0, 20.0, 20.0], "fov": 0.5},
    }
    dark = volume.with_medium(albedo=0)
    picture = pvol.render(dark, seed=1, **view)
    check("a picture", picture.rgb.mean(), np.exp(-optical_depth()), 0.0035)
    other = pvol.render(dark, seed=2, tracker="delta", **view)
    assert not pvol.compare(picture, other)["verdict"]["bias_detected"]


class Array(ctypes.Structure):
    """pvol_array of pvol/pvol.h."""

    _fields_ = [
        ("values", ctypes.c_void_p),
        ("size", ctypes.c_int32 * 3),
        ("origin", ctypes.c_int32 * 3),
        ("stride", ctypes.c_int64 * 3),
        ("type", ctypes.c_int),
        ("reserved", ctypes.c_uint32 * 3),
    ]


def check_library(library: ctypes.CDLL, volume) -> None:
    """The same volume by the C API of the program's library has the same density, to the bit."""
    library.pvol_new_volume.restype = ctypes.c_void_p
    library.pvol_density.restype = ctypes.c_float
    values = np.ascontiguousarray(density())
    array = Array(values=values.ctypes.data, size=(ctypes.c_int32 * 3)(*values.shape))
    own = ctypes.c_void_p(library.pvol_new_volume())
    assert library.pvol_set_array(own, 0, ctypes.byref(array)) == 0
    assert library.pvol_commit(own, None) == 0
    places = np.random.default_rng(3).uniform(0, SIZE, (500, 3))
    found = [library.pvol_density(own, (ctypes.c_double * 3)(*p)) for p in places]
    np.testing.assert_array_equal(np.float32(found), volume.density(places))
    library.pvol_release(own)


def main() -> None:
    prefix, build = (os.path.realpath(path) for path in sys.argv[1:3])
    library = ctypes.CDLL(sys.argv[3], ctypes.RTLD_GLOBAL) if len(sys.argv) > 3 else None
    import pvol  # after the library, as where the program is linked with it

    check_files(pvol, prefix, build)
    volume = pvol.Volume(density(), extinction=EXTINCTION)
    check_bounds(volume)
    check_rays(volume)
    check_picture(pvol, volume)
    if library:
        check_library(library, volume)


main()
