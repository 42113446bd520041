"""Finds the Python module pvol: in the add-on, where the preferences say, or on Python's path."""

import importlib
import pathlib
import sys

ADDON = pathlib.Path(__file__).parent
BUNDLED = ADDON / "modules"  # where make_zip.py --module puts it


class Missing(Exception):
    """pvol cannot be imported. The message says why and what to do."""


def _folders(chosen):
    """Where the module may be, best first: folders that contain `pvol`."""
    if chosen:
        folder = pathlib.Path(chosen).expanduser()
        yield folder.parent if folder.name == "pvol" and folder.is_dir() else folder
    yield BUNDLED


def _built_for(package):
    """Names of the compiled parts of a package, which tell the Python that they are for."""
    return sorted(p.name for p in package.glob("_pvol*") if p.suffix in (".so", ".pyd", ".dylib"))


def _reason(error, folder):
    """What keeps the package in `folder` from being imported, and what to do."""
    ours = "Python {}.{}".format(*sys.version_info[:2])
    compiled = _built_for(folder / "pvol")
    if not compiled:
        return (f"{folder / 'pvol'} has no compiled module (_pvol*.so). Build it with "
                "-DPVOL_BUILD_PYTHON=ON and choose the folder that contains the package.")
    digits = "{}{}".format(*sys.version_info[:2])
    tags = ("cpython-" + digits, "cp" + digits, "abi3")
    if not any(tag in name for name in compiled for tag in tags):
        return (f"{folder / 'pvol' / compiled[0]} is built for another Python; Blender has {ours}. "
                f"Build pvol with -DPython3_EXECUTABLE=PATH of a {ours}, or use the Blender of "
                "your system's packages.")
    return f"{folder / 'pvol'} does not load: {error}. Install the libraries that it names."


def load(chosen=""):
    """The module; raises Missing. `chosen` is the folder of the preferences, or ""."""
    if "pvol" in sys.modules:
        return sys.modules["pvol"]
    for folder in _folders(chosen):
        if not (folder / "pvol").is_dir():
            continue
        sys.path.insert(0, str(folder))
        try:
            return importlib.import_module("pvol")
        except ImportError as error:
            sys.modules.pop("pvol", None)
            raise Missing(_reason(error, folder)) from error
        finally:
            sys.path.remove(str(folder))
    try:
        return importlib.import_module("pvol")
    except ImportError as error:
        where = f"neither in {chosen} nor on Python's path" if chosen else "not on Python's path"
        raise Missing(f"The Python module pvol is {where} ({error}). Set its folder in Edit > "
                      "Preferences > Add-ons > pvol, or install a zip made with make_zip.py "
                      "--module.") from error
