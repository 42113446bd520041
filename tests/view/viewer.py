"""pvol-view on a scene of a ball, in a folder of its own, for tests."""

import os
import pathlib
import signal
import subprocess
import tempfile

BALL = """
[recipe]
resolution = 24
[[form]]
shape = "ellipsoid"
centre = [0, 0, 0]
radii = 1
"""
SCENE = """
[volume]
file = "ball.toml"
[medium]
extinction = 20
g = 0.3
[camera]
position = [0, 0, 4]
target = [0, 0, 0]
[environment]
radiance = [0.1, 0.2, 0.4]
[[sun]]
direction = [1, 1, 1]
irradiance = 3
[render]
size = [160, 90]
spp = 8
"""


def tool(name):
    """A tool of the build that is tested."""
    os.environ.pop("OCIO", None)  # views are those of pvol itself
    return os.path.join(os.environ["PVOL_TOOLS"], name)


class Viewer:
    """The tool while it runs, at its address."""

    def __init__(self, *arguments):
        self.scratch = tempfile.TemporaryDirectory()
        self.folder = pathlib.Path(self.scratch.name)
        (self.folder / "ball.toml").write_text(BALL)
        (self.folder / "scene.toml").write_text(SCENE)
        self.process = subprocess.Popen(
            [tool("pvol-view"), self.folder / "scene.toml", "--quiet", *arguments],
            stdout=subprocess.PIPE,
            stderr=subprocess.DEVNULL,
            text=True,
        )
        self.address = self.process.stdout.readline().strip()
        if not self.address.startswith("http://127.0.0.1:"):
            raise AssertionError(f"no address: '{self.address}'")

    def __enter__(self):
        return self

    def __exit__(self, *exception):
        self.process.send_signal(signal.SIGINT)
        self.process.wait()
        self.process.stdout.close()
        self.scratch.cleanup()
