#!/usr/bin/env python3
"""Tests of the Blender add-on: by Blender, with the add-on installed from its zip.

    blender -b --factory-startup -P tests/blender/run.py -- [TEST...]
    python3 tests/blender/run.py [TEST...]

The second finds Blender and starts the first in a scratch folder of user files; where there is no
Blender it says so and ends with 77, which CTest counts as skipped. The compiled module is taken
from PYTHONPATH and goes into the zip."""

import os
import pathlib
import shutil
import subprocess
import sys
import tempfile
import unittest

HERE = pathlib.Path(__file__).resolve().parent
MAKE_ZIP = HERE.parents[1] / "tools" / "blender" / "make_zip.py"
SKIPPED = 77


def start_blender(arguments):
    """Runs Blender with this file; returns its exit code."""
    blender = os.environ.get("BLENDER") or shutil.which("blender")
    if not blender:
        print("skipped: Blender is not installed (apt install blender, or set BLENDER to its path)")
        return SKIPPED
    with tempfile.TemporaryDirectory(prefix="pvol_blender_test_") as folder:
        environment = {**os.environ, "BLENDER_USER_RESOURCES": folder,
                       "BLENDER_USER_SCRIPTS": folder + "/scripts",
                       "BLENDER_USER_CONFIG": folder + "/config",
                       "PYTHONDONTWRITEBYTECODE": "1"}
        os.mkdir(folder + "/scripts")
        command = [blender, "-b", "--factory-startup", "--python-exit-code", "1", "-noaudio",
                   "-P", str(HERE / "run.py"), "--", *arguments]
        return subprocess.run(command, env=environment).returncode


def make_zip(folder, with_module=True):
    """The add-on, with the module that PYTHONPATH has."""
    path = pathlib.Path(folder) / "pvol_blender.zip"
    command = ["python3", str(MAKE_ZIP), "-o", str(path)]
    found = [p for p in os.environ.get("PYTHONPATH", "").split(":") if p and
             list((pathlib.Path(p) / "pvol").glob("_pvol*"))]
    if with_module and not found:
        sys.exit("run.py: PYTHONPATH has no folder with the package pvol; set it to "
                 "build/ci/python")
    subprocess.run(command + (["--module", found[0]] if with_module else []), check=True,
                   stdout=subprocess.DEVNULL)
    return path


def install():
    """As an artist does it, but for the clicks."""
    import bpy

    if not os.environ.get("BLENDER_USER_SCRIPTS"):
        sys.exit("run.py: set BLENDER_USER_SCRIPTS and BLENDER_USER_RESOURCES to scratch folders, "
                 "or start it by python3, which does")
    with tempfile.TemporaryDirectory() as folder:
        bpy.ops.preferences.addon_install(filepath=str(make_zip(folder)))
    bpy.ops.preferences.addon_enable(module="pvol_blender")
    if "pvol_blender" not in bpy.context.preferences.addons:
        sys.exit("run.py: Blender does not enable the add-on; its messages are above")
    # Not the one of PYTHONPATH: what is tested is the zip.
    sys.path[:] = [p for p in sys.path if not list(pathlib.Path(p or ".").glob("pvol/_pvol*"))]


def main():
    try:
        import bpy  # noqa: F401
    except ImportError:
        return start_blender(sys.argv[1:])
    names = sys.argv[sys.argv.index("--") + 1:] if "--" in sys.argv else []
    sys.path.insert(0, str(HERE))
    install()
    loader = unittest.TestLoader()
    tests = loader.loadTestsFromNames(names) if names else loader.discover(str(HERE), "*_test.py")
    result = unittest.TextTestRunner(verbosity=2).run(tests)
    return 0 if result.wasSuccessful() and result.testsRun else 1


if __name__ == "__main__":
    sys.stdout.flush()
    code = main()
    sys.stdout.flush()
    sys.stderr.flush()
    os._exit(code) if "bpy" in sys.modules else sys.exit(code)
