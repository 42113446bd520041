"""The engine: passes, options, Esc, installation and what it says where the module is missing."""

import os
import pathlib
import subprocess
import sys
import tempfile
import unittest
import zipfile
from unittest import mock

import bpy
import numpy as np

import run
import scenes
from pictures import render


def lit(**settings):
    scene = scenes.empty()
    scenes.box(scenes.smoke(0.8, attribute=""))
    scenes.lamp("SUN", (1, -2, 3), energy=3)
    scenes.lamp("POINT", (-2, -2, 2), energy=300)
    scenes.background((0.3, 0.4, 0.5))
    scenes.camera((0, -7, 1), lens=40)
    for name, value in settings.items():
        setattr(scene.pvol, name, value)
    scene.render.engine = "PVOL"
    return scene


class Passes(unittest.TestCase):
    def passes(self, scene, layers):
        """Pixels of each pass as the compositor has them, by name."""
        bpy.context.view_layer.pvol.layers = layers
        scene.use_nodes = True
        tree = scene.node_tree
        tree.nodes.clear()
        source = tree.nodes.new("CompositorNodeRLayers")
        with tempfile.TemporaryDirectory() as folder:
            to = tree.nodes.new("CompositorNodeOutputFile")
            to.base_path = folder
            to.format.file_format, to.format.color_depth = "OPEN_EXR", "32"
            to.file_slots.clear()
            names = [o.name for o in source.outputs if o.enabled]
            for name in names:
                to.file_slots.new(name.replace(" ", "_") + "_")
                tree.links.new(source.outputs[name], to.inputs[-1])
            render("PVOL", 16)
            from pictures import load

            files = {f.name.rsplit("_", 1)[0]: f for f in pathlib.Path(folder).glob("*.exr")}
            return {n: load(files[n.replace(" ", "_")])
                    for n in names if n.replace(" ", "_") in files}

    def test_lights_add_up(self):
        scene = lit()
        found = self.passes(scene, {"lights", "depth", "normal", "samples"})
        parts = [v[..., :3] for n, v in found.items() if n.startswith("Light ")]
        self.assertEqual(sorted(n for n in found if n.startswith("Light ")),
                         ["Light Point", "Light Sun", "Light emission", "Light sky"])
        np.testing.assert_allclose(sum(parts), found["Image"][..., :3], atol=2e-3)
        self.assertAlmostEqual(float(np.median(found["Depth"][20:30, 40:50, 0])), 6.5, delta=1)
        np.testing.assert_array_equal(found["Samples"][..., 0], 16)

    def test_light_groups(self):
        scene = lit()
        for lamp in (o for o in scene.objects if o.type == "LIGHT"):
            lamp.lightgroup = "Key"
        found = self.passes(scene, {"lights", "scattering"})
        self.assertIn("Light Key", found)
        self.assertNotIn("Light Sun", found)
        parts = [v[..., :3] for n, v in found.items() if n.startswith("Scattering ")]
        self.assertEqual(len(parts), 3)
        np.testing.assert_allclose(sum(parts), found["Image"][..., :3], atol=2e-3)

    def test_film(self):
        scene = lit()
        self.assertEqual(render("PVOL", 4)[..., 3].min(), 1)
        scene.render.film_transparent = True
        picture = render("PVOL", 64)
        self.assertEqual(picture[0, 0].max(), 0)
        self.assertTrue(0.3 < picture[27, 48, 3] < 0.95)

    def test_denoise(self):
        lit()
        noisy = render("PVOL", 8)
        scene = lit(denoise=True)
        clean = render("PVOL", 8)
        self.assertLess(np.abs(np.diff(clean[20:34, 40:56, 1])).mean(),
                        0.6 * np.abs(np.diff(noisy[20:34, 40:56, 1])).mean())
        self.assertAlmostEqual(clean.mean() / noisy.mean(), 1, delta=0.02)
        found = self.passes(scene, set())
        removed = found["Noisy Image"][..., :3] - found["Image"][..., :3]
        self.assertGreater(np.abs(removed).mean(), 1e-4)


class Options(unittest.TestCase):
    def options(self, scene):
        from pvol_blender import render_options

        return render_options.of_scene(scene, bpy.context.view_layer,
                                       render_options.size(scene.render))

    def test_ends(self):
        self.assertEqual(self.options(lit(samples=7))["spp"], 7)
        made = self.options(lit(end="NOISE", noise=0.02))
        self.assertAlmostEqual(made["noise"], 0.02)
        self.assertNotIn("spp", made)
        self.assertEqual(self.options(lit(end="TIME", seconds=3))["time"], 3)

    def test_seed_and_threads(self):
        scene = lit(seed=5, animate_seed=True)
        scene.frame_set(3)
        made = self.options(scene)
        self.assertEqual((made["seed"], made["threads"]), (8, 2))
        scene.render.threads_mode = "AUTO"
        self.assertNotIn("threads", self.options(scene))

    def test_crop_counts_from_the_top(self):
        scene = lit()
        render_settings = scene.render
        render_settings.use_border = True
        render_settings.border_min_x, render_settings.border_max_x = 0.25, 0.5
        render_settings.border_min_y, render_settings.border_max_y = 0.5, 1.0
        self.assertEqual(self.options(scene)["crop"], [24, 0, 24, 27])

    def test_noise_is_reached(self):
        scene = lit(end="NOISE", noise=0.05)
        scene.pvol.seed = 1
        self.assertGreater(render("PVOL", 1).mean(), 0.1)


class Ending(unittest.TestCase):
    def test_escape(self):
        """A render that is ended leaves what there is of the picture."""
        from pvol_blender import final, preferences

        scene = lit()
        depsgraph = bpy.context.evaluated_depsgraph_get()
        module = preferences.load()
        engine = mock.MagicMock()
        engine.camera_override = None
        engine.test_break.side_effect = [False, True] + [True] * 99
        written = {}
        with mock.patch.object(final, "_show"), mock.patch.object(
                final, "_write", lambda _, picture, *rest: written.update(picture=picture)):
            scene.pvol.samples = 4096
            final.render(engine, depsgraph, module)
        self.assertLess(written["picture"].samples.max(), 4096)
        self.assertGreater(written["picture"].rgb.mean(), 0)
        engine.update_progress.assert_called()


class Module(unittest.TestCase):
    """What the add-on says where pvol cannot be imported."""

    def load(self, folder):
        from pvol_blender import pvol_module

        with mock.patch.dict(sys.modules), mock.patch.object(
                pvol_module, "BUNDLED", pathlib.Path("/nowhere")):
            for name in [n for n in sys.modules if n == "pvol" or n.startswith("pvol.")]:
                del sys.modules[name]
            with self.assertRaises(pvol_module.Missing) as caught:
                pvol_module.load(folder)
        return str(caught.exception)

    def package(self, folder, *files):
        package = pathlib.Path(folder) / "pvol"
        package.mkdir()
        (package / "__init__.py").write_text("from ._pvol import nothing\n")
        for name in files:
            (package / name).write_bytes(b"")
        return folder

    def test_nowhere(self):
        self.assertIn("Preferences", self.load(""))

    def test_for_another_python(self):
        with tempfile.TemporaryDirectory() as folder:
            self.package(folder, "_pvol.cpython-39-x86_64-linux-gnu.so")
            message = self.load(folder)
        self.assertIn("another Python", message)
        self.assertIn("cpython-39", message)
        self.assertIn("Python {}.{}".format(*sys.version_info[:2]), message)

    def test_not_built(self):
        with tempfile.TemporaryDirectory() as folder:
            self.assertIn("PVOL_BUILD_PYTHON", self.load(self.package(folder)))

    def test_damaged(self):
        with tempfile.TemporaryDirectory() as folder:
            tag = "cpython-{}{}".format(*sys.version_info[:2])
            self.package(folder, f"_pvol.{tag}-x86_64-linux-gnu.so")
            self.assertIn("does not load", self.load(folder))


class Zip(unittest.TestCase):
    def test_without_module(self):
        with tempfile.TemporaryDirectory() as folder:
            names = zipfile.ZipFile(run.make_zip(folder, with_module=False)).namelist()
        self.assertIn("pvol_blender/__init__.py", names)
        self.assertIn("pvol_blender/translate/volumes.py", names)
        self.assertFalse([n for n in names if "modules/" in n or "__pycache__" in n])

    def test_a_folder_without_module_is_refused(self):
        with tempfile.TemporaryDirectory() as folder:
            done = subprocess.run(["python3", str(run.MAKE_ZIP), "-o", os.path.join(folder, "x.zip"),
                                   "--module", folder], capture_output=True, text=True)
        self.assertEqual(done.returncode, 1)
        self.assertIn("no package pvol", done.stderr)

    def test_registers_twice(self):
        for _ in range(2):
            bpy.ops.preferences.addon_disable(module="pvol_blender")
            bpy.ops.preferences.addon_enable(module="pvol_blender")
        self.assertTrue(hasattr(bpy.types.Scene, "pvol"))

    def test_the_module_is_the_one_of_the_zip(self):
        from pvol_blender import preferences

        self.assertIn("modules", pathlib.Path(preferences.load().__file__).parts)


if __name__ == "__main__":
    unittest.main()
