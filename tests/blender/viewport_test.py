"""The viewport, in a Blender with a window on a virtual screen."""

import os
import pathlib
import shutil
import subprocess
import tempfile
import unittest

import bpy

import run
from pictures import load


def srgb(linear):
    return 1.055 * linear ** (1 / 2.4) - 0.055


@unittest.skipUnless(shutil.which("xvfb-run"), "xvfb is not installed (apt install xvfb)")
class Viewport(unittest.TestCase):
    def test_pictures_and_colours(self):
        with tempfile.TemporaryDirectory() as folder:
            command = ["xvfb-run", "-a", "-s", "-screen 0 800x600x24", bpy.app.binary_path,
                       "--factory-startup", "--window-geometry", "0", "0", "800", "600", "-noaudio",
                       "-P", str(run.HERE / "window.py"), "--", folder]
            done = subprocess.run(command, env={**os.environ, "LIBGL_ALWAYS_SOFTWARE": "1"},
                                  capture_output=True, text=True, timeout=120)
            shots = {f.stem: load(f)[..., 0] for f in pathlib.Path(folder).glob("*.png")}
            log = done.stdout + done.stderr
        self.assertEqual(sorted(shots), ["brighter", "camera", "orthographic"], log)
        self.assertNotIn("Traceback", log)
        for name, world in (("camera", 0.2), ("orthographic", 0.2), ("brighter", 0.5)):
            with self.subTest(name=name):
                shot = shots[name]
                height, width = shot.shape
                middle = slice(height // 2 - 30, height // 2 + 30)  # headers are above
                # Beside the box, and in it; a step of 8 bits is 0.004.
                self.assertAlmostEqual(shot[height // 2, width // 8], srgb(world), delta=0.006)
                self.assertLess(shot[middle, width // 2].min(), 0.02)
        # The box of 1 m is 50 mm / 5 m of 36 mm wide.


if __name__ == "__main__":
    unittest.main()
