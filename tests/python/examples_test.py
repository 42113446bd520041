"""The scripts of samples/python, small."""
import os
import pathlib
import subprocess
import sys
import tempfile
import unittest

from messages import message

EXAMPLES = pathlib.Path(os.environ.get("PVOL_SAMPLES", "samples")) / "python"


class Examples(unittest.TestCase):
    def setUp(self):
        self.folder = tempfile.TemporaryDirectory()
        self.addCleanup(self.folder.cleanup)

    def run_script(self, name, *arguments, makes=""):
        if makes:
            arguments += ("--out", makes)
        done = subprocess.run([sys.executable, EXAMPLES / name, *arguments], cwd=self.folder.name,
                              capture_output=True, text=True)
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
        if makes:
            self.assertGreater((pathlib.Path(self.folder.name) / makes).stat().st_size, 100)
        return done.stdout

    def test_first_steps(self):
        out = self.run_script("first_steps.py", "--size", "48", "--spp", "16", "--voxels", "40",
                              makes="ring.png")
        self.assertRegex(out, message("python.lookups_of_a_sample"))

    def test_lookups_by_depth(self):
        import importlib.util

        if importlib.util.find_spec("matplotlib") is None:
            self.skipTest("there is no matplotlib")
        out = self.run_script("lookups_by_depth.py", "--rays", "20000", makes="depth.png")
        self.assertRegex(out, message("python.depth_by_cost"))

    def test_transmittance(self):
        out = self.run_script("transmittance.py", "--rays", "64", "--repeats", "256", "--voxels", "32")
        self.assertIn("residual", out)

    def test_bounds_and_shells(self):
        out = self.run_script("bounds_and_shells.py", "--perturbations", "2", "--resolution", "24",
                              makes="shell.obj")
        self.assertIn("triangles", out)

    def test_own_path_tracer(self):
        out = self.run_script("own_path_tracer.py", "--size", "40", "--spp", "16", "--voxels", "32",
                              makes="own.npy")
        self.assertRegex(out, message("python.standard_errors"))

    def test_all_are_here(self):
        ours = {n.removeprefix("test_") + ".py" for n in dir(self) if n.startswith("test_")}
        self.assertEqual({p.name for p in EXAMPLES.glob("*.py")}, ours - {"all_are_here.py"})


if __name__ == "__main__":
    unittest.main()
