"""Volumes: how thick, how coloured and where, against closed forms and Cycles."""

import math
import os
import pathlib
import shutil
import subprocess
import tempfile
import unittest

import bpy
import numpy as np

import run
import scenes
from pvol_blender.translate.notes import Notes
from pictures import both, difference, framing, render, shot


class WithFile(unittest.TestCase):
    """Tests that share a .vdb file: a box of size 2 and density 1."""

    @classmethod
    def setUpClass(cls):
        cls.folder = tempfile.TemporaryDirectory()
        cls.vdb = pathlib.Path(cls.folder.name) / "box.vdb"
        scenes.empty()
        scenes.write_vdb(cls.vdb)

    @classmethod
    def tearDownClass(cls):
        cls.folder.cleanup()


class Volumes(WithFile):
    def through(self, space="WORLD", density=0.5, samples=256, **place):
        """Optical depth through the middle of the volume of the file, along y."""
        scene = scenes.empty()
        scene.render.film_transparent = True
        scene.render.resolution_x = scene.render.resolution_y = 16
        thing = scenes.volume(self.vdb, scenes.smoke(density, (0, 0, 0)), **place)
        thing.data.render.space = space
        scenes.camera((0, -20, 0), type="ORTHO", ortho_scale=0.2)
        return -math.log(1 - render("PVOL", samples)[..., 3].mean())

    def test_optical_depth(self):
        self.assertAlmostEqual(self.through(), 2 * 0.5, delta=0.02)

    def test_scale_in_world_space(self):
        self.assertAlmostEqual(self.through(scale=(1, 2, 1)), 4 * 0.5, delta=0.04)

    def test_scale_in_object_space(self):
        self.assertAlmostEqual(self.through("OBJECT", scale=(2, 2, 2)), 2 * 0.5, delta=0.02)
        # Cycles divides by the length that the object's diagonal is stretched to.
        self.assertAlmostEqual(self.through("OBJECT", scale=(1, 2, 1)), 4 * 0.5 / math.sqrt(2),
                               delta=0.03)

    def test_object_space_is_that_of_cycles(self):
        scene = scenes.empty()
        scene.render.film_transparent = True
        thing = scenes.volume(self.vdb, scenes.smoke(1.5, (0.5, 0.5, 0.5)), scale=(0.5, 1.5, 0.8),
                              rotation=(0.3, 0.2, 0.5))
        thing.data.render.space = "OBJECT"
        scene.cycles.volume_step_rate = 0.25
        scenes.camera((0, -6, 1), lens=40)
        p, c = both(64, 32)
        self.assertLess(np.abs(framing(p.alpha) - framing(c.alpha)).max(), 0.15)
        self.assertAlmostEqual(p.alpha.sum() / c.alpha.sum(), 1, delta=0.02)

    def test_light_in_a_grid(self):
        scene = scenes.empty()
        scenes.volume(self.vdb, scenes.smoke(0.7, (0.8, 0.6, 0.3), -0.3,
                                             Absorption_Color=(0.6, 0.2, 0.05, 1)))
        scenes.background((1, 0.8, 0.5), 0.3)
        scenes.lamp("SUN", (1, -2, 3), energy=2)
        scene.cycles.volume_step_rate = 0.5
        scenes.camera((0, -6, 1), lens=40)
        p, c = both(64, 64)
        excess, text = difference(p, c)
        print(f"    {text}")
        self.assertLess(excess, 1, text)

    def test_instances_share_a_volume(self):
        from pvol_blender.translate import Translation
        from pvol_blender.translate.files import DryFiles

        scenes.empty()
        material = scenes.smoke(2)
        for x in (-2, 0, 2):
            scenes.volume(self.vdb, material, location=(x, 0, 0), scale=(0.5, 0.5, 0.5))
        group = bpy.data.collections.new("Group")
        inner = scenes.volume(self.vdb, material, location=(0, 0, 1), scale=(0.5, 0.5, 0.5))
        bpy.context.scene.collection.objects.unlink(inner)
        group.objects.link(inner)
        empty = scenes.add("Instancer", None, location=(0, 0, 5))
        empty.instance_type, empty.instance_collection = "COLLECTION", group
        tables = Translation(bpy.context.evaluated_depsgraph_get(), DryFiles()).sections()
        self.assertEqual(len(tables["volume"]), 1)
        places = [t["matrix"][3::4][:3] for t in tables["volume"][0]["instance"]]
        half = 0.5 * 0.5 * 2 / 32  # of a voxel of the scaled object
        np.testing.assert_allclose(sorted(places), half + np.array(
            [[-2, 0, 0], [0, 0, 0], [0, 0, 6], [2, 0, 0]]), atol=1e-5)
        self.assertAlmostEqual(tables["medium"]["extinction"], 4, places=5)  # in object space

    def test_moving_volume(self):
        scene = scenes.empty()
        scene.render.film_transparent = True
        thing = scenes.volume(self.vdb, scenes.smoke(5))
        for frame, x in ((1, 0), (2, 2)):
            thing.location.x = x
            thing.keyframe_insert("location", frame=frame)
        for curve in thing.animation_data.action.fcurves:
            curve.extrapolation = "LINEAR"
            for point in curve.keyframe_points:
                point.interpolation = "LINEAR"
        scenes.camera((0, -12, 0), type="ORTHO", ortho_scale=10)
        scene.render.use_motion_blur, scene.render.motion_blur_shutter = True, 0.5
        scene.frame_set(1)
        moving = framing(render("PVOL", 128)[..., 3])
        scene.render.use_motion_blur = False
        still = framing(render("PVOL", 128)[..., 3])
        pixels = 96 / 10  # of a unit
        self.assertAlmostEqual(moving[0], still[0], delta=0.1)  # the shutter is centred
        spread = math.sqrt(moving[2] ** 2 - still[2] ** 2)
        self.assertAlmostEqual(spread, 2 * 0.5 * pixels / math.sqrt(12), delta=0.15)

    def test_a_sequence(self):
        folder = pathlib.Path(self.folder.name)
        scenes.empty()
        for frame, size in ((1, 1.0), (2, 2.0)):
            scenes.write_vdb(folder / f"smoke_{frame:04}.vdb", size)
        scene = scenes.empty()
        scene.render.film_transparent = True
        thing = scenes.volume(folder / "smoke_0001.vdb", scenes.smoke(10))
        thing.data.is_sequence, thing.data.frame_duration = True, 2
        scenes.camera((0, -12, 0), type="ORTHO", ortho_scale=5)
        spreads = []
        for frame in (1, 2):
            scene.frame_set(frame)
            spreads.append(framing(render("PVOL", 32)[..., 3])[2])
        self.assertAlmostEqual(spreads[1] / spreads[0], 2, delta=0.1)

    def test_grids_that_modifiers_make(self):
        scene = scenes.empty()
        scene.render.film_transparent = True
        source = scenes.add("Source", scenes.cube_mesh())
        source.hide_render = True
        data = bpy.data.volumes.new("Made")
        data.materials.append(scenes.smoke(0.5, (0, 0, 0)))
        data.render.space = "WORLD"
        made = scenes.add("Made", data)
        modifier = made.modifiers.new("Fill", "MESH_TO_VOLUME")
        modifier.object, modifier.resolution_mode = source, "VOXEL_SIZE"
        modifier.voxel_size, modifier.interior_band_width = 0.1, 2
        modifier.exterior_band_width = 0
        scene.render.resolution_x = scene.render.resolution_y = 16
        scenes.camera((0, -20, 0), type="ORTHO", ortho_scale=0.2)
        depth = -math.log(1 - render("PVOL", 256)[..., 3].mean())
        self.assertAlmostEqual(depth, 2 * 0.5, delta=0.08)

    def test_a_missing_file_is_noted_and_nothing_is_rendered(self):
        scene = scenes.empty()
        scene.render.film_transparent = True
        scenes.volume("/nowhere/cloud.vdb", scenes.smoke(1))
        scenes.camera()
        self.assertEqual(render("PVOL", 4)[..., 3].max(), 0)
        from pvol_blender import unmapped

        self.assertTrue(any("Cloud" in str(n) for n in unmapped.notes_of(bpy.context.scene)))


class Fluids(WithFile):
    """The files of a fluid simulation, with a domain that stands for one of Blender's."""

    def domain(self, folder, **settings):
        from types import SimpleNamespace as Thing

        values = {"domain_type": "GAS", "cache_directory": folder, "use_noise": False,
                  "use_adaptive_domain": False, "cache_frame_start": 1, "cache_frame_end": 9,
                  "cell_size": (0.1, 0.1, 0.2), "start_point": (-1, -2, -3), "noise_scale": 2}
        modifier = Thing(type="FLUID", fluid_type="DOMAIN", show_render=True,
                         domain_settings=Thing(**{**values, **settings}))
        return Thing(modifiers=[modifier], name="Smoke")

    def test_files_of_a_frame(self):
        from pvol_blender.translate import fluid

        with tempfile.TemporaryDirectory() as folder:
            for name in ("data/fluid_data_0003.vdb", "noise/fluid_noise_0003.vdb"):
                path = pathlib.Path(folder) / name
                path.parent.mkdir()
                path.touch()
            notes = Notes()
            plain, fine = self.domain(folder), self.domain(folder, use_noise=True)
            self.assertEqual(fluid.cache_file(plain, 3, notes).name, "fluid_data_0003.vdb")
            self.assertEqual(fluid.cache_file(fine, 3, notes).name, "fluid_noise_0003.vdb")
            self.assertEqual(len(notes), 0)
            self.assertIsNone(fluid.cache_file(plain, 4, notes))
            self.assertEqual([n.thing for n in notes], ["Smoke"])

    def test_voxels_are_cells_of_the_domain(self):
        from mathutils import Vector

        from pvol_blender import preferences
        from pvol_blender.translate import fluid

        to_object = fluid.file_to_object(self.domain("/nowhere"), self.vdb, preferences.load(),
                                         Notes())
        voxel = 2 / 32
        place = to_object @ (voxel * Vector((5, 6, 7)))
        np.testing.assert_allclose(place, (-1 + 0.55, -2 + 0.65, -3 + 1.5), atol=1e-5)


CONVERT = next((str(path) for folder in os.environ.get("PYTHONPATH", "").split(":")
                for path in [pathlib.Path(folder).parent / "tools" / "pvol-convert"]
                if folder and path.is_file()), shutil.which("pvol-convert"))


@unittest.skipUnless(CONVERT, "pvol-convert is neither built nor on the path")
class Velocities(unittest.TestCase):
    """Smoke that moves by a grid of velocities."""

    def test_units_are_those_of_cycles(self):
        with tempfile.TemporaryDirectory() as folder:
            vdb = pathlib.Path(folder) / "column.vdb"
            recipe = run.HERE.parents[1] / "samples" / "column.toml"
            subprocess.run([CONVERT, recipe, vdb], check=True, capture_output=True)
            cases = (("SECOND", 12, 1.0), ("SECOND", 24, 2.0), ("FRAME", 24, 1 / 12))
            for unit, fps, scale in cases:
                with self.subTest(unit=unit, fps=fps):
                    self.compare(vdb, unit, fps, scale)

    def compare(self, vdb, unit, fps, scale):
        scene = scenes.empty()
        scene.render.film_transparent = True
        scene.render.fps = fps
        scene.render.motion_blur_shutter = 1.0
        data = scenes.volume(vdb, scenes.smoke(10), rotation=(math.pi / 2, 0, 0)).data
        data.render.space = "WORLD"
        data.velocity_grid, data.velocity_unit, data.velocity_scale = "v", unit, scale
        scenes.camera((0, -7, 1), (0, 0, 1), lens=50)
        still = shot("PVOL", 32).alpha
        scene.render.use_motion_blur = True
        p, c = both(32, 32)
        apart, blurred = (np.abs(c.alpha - x).mean() for x in (p.alpha, still))
        self.assertLess(apart, 0.7 * blurred)


class Fires(WithFile):
    """Emission of grids, against Cycles."""

    def compare(self, material, tolerance=0.02, **place):
        scene = scenes.empty()
        scenes.volume(self.vdb, material(), **place)
        scene.cycles.volume_step_rate = 0.5
        scenes.camera((0, -6, 1), lens=40)
        p, c = both(64, 64)
        excess, text = difference(p, c, tolerance=tolerance)
        print(f"    {self.id().rsplit('.', 1)[1]}: {text}")
        self.assertLess(excess, 1, text)
        self.assertGreater(difference(p.scaled(1.08), c, tolerance=tolerance)[0], 1)

    @staticmethod
    def along_density():
        made = scenes.smoke(0.5)
        tree = made.node_tree
        grid = tree.nodes.new("ShaderNodeAttribute")
        grid.attribute_name = "density"
        times = tree.nodes.new("ShaderNodeMath")
        times.operation = "MULTIPLY"
        times.inputs[1].default_value = 0.8
        tree.links.new(grid.outputs["Fac"], times.inputs[0])
        tree.links.new(times.outputs[0],
                       tree.nodes["Principled Volume"].inputs["Emission Strength"])
        return made

    def test_emission_along_a_grid(self):
        self.compare(self.along_density)

    def test_black_body(self):
        self.compare(lambda: scenes.smoke(0.5, Blackbody_Intensity=1.0, Temperature=1800,
                                          Temperature_Attribute="density"))

    def test_emission_of_a_scaled_object(self):
        self.compare(self.along_density, scale=(0.5, 0.5, 0.5))

    def test_even_emission(self):
        """Where the density is above 0; of Cycles' pictures the voxels around it shine as well."""
        for inputs in ({"Emission_Strength": 0.3, "Emission_Color": (1, 0.5, 0.2, 1)},
                       {"Blackbody_Intensity": 0.5, "Temperature": 2000,
                        "Temperature_Attribute": "none"}):
            with self.subTest(inputs=inputs):
                scene = scenes.empty()
                scene.render.resolution_x = scene.render.resolution_y = 8
                thing = scenes.volume(self.vdb, scenes.smoke(1e-3, **inputs))
                thing.data.render.space = "WORLD"
                scenes.camera((0, -20, 0), type="ORTHO", ortho_scale=0.2)
                got = render("PVOL", 64)[..., :3].mean(axis=(0, 1))
                sigma = 5.670373e-14 / math.pi
                luminance = 0.5 * sigma * 2000**4 * 2
                if "Emission_Strength" in inputs:
                    np.testing.assert_allclose(got, [0.6, 0.3, 0.12], rtol=0.04)
                else:
                    self.assertAlmostEqual(got @ [0.2126, 0.7152, 0.0722] / luminance, 1,
                                           delta=0.04)


if __name__ == "__main__":
    unittest.main()
