"""Settings at the ends of their ranges, and what a scene may hold without anybody thinking of it: none
of it may end a render or go wrong without a note."""

import math
import pathlib
import re
import tempfile
import unittest

import bpy
import numpy as np

import scenes
from pictures import render


def translated(files=None):
    from pvol_blender.translate import Translation
    from pvol_blender.translate.files import DryFiles

    translation = Translation(bpy.context.evaluated_depsgraph_get(), files or DryFiles())
    return translation.sections(), [str(note) for note in translation.notes]


def noted(notes, part):
    return any(part in note for note in notes)


def lit_ball():
    scene = scenes.empty()
    bpy.ops.mesh.primitive_ico_sphere_add(subdivisions=2, radius=1)
    lamp = scenes.lamp("AREA", (2, -2, 4), energy=300, shape="SQUARE", size=1)
    scenes.camera((0, -6, 0), lens=40)
    return scene, lamp


class Pictures(unittest.TestCase):
    def test_sizes_are_those_of_blender(self):
        scene, _ = lit_ball()
        scenes.background((1, 1, 1))
        scene.render.resolution_x = scene.render.resolution_y = 100
        for percentage, border in ((29, None), (57, None), (100, (0, 0.7)), (100, (0.29, 0.7))):
            for cropped in (False, True):
                scene.render.resolution_percentage = percentage
                scene.render.use_border = border is not None
                scene.render.use_crop_to_border = cropped
                if border:
                    scene.render.border_min_x = scene.render.border_min_y = border[0]
                    scene.render.border_max_x = scene.render.border_max_y = border[1]
                lit = render("PVOL", 1)[..., :3].sum(axis=2) > 0
                rows, columns = np.flatnonzero(lit.any(axis=1)), np.flatnonzero(lit.any(axis=0))
                shown = len(rows), len(columns)
                if border is None or cropped:
                    self.assertEqual(shown, lit.shape, (percentage, border))
                else:
                    self.assertEqual(shown, (70 - round(100 * border[0]),) * 2, border)

    def test_settings_at_their_ends(self):
        scene, _ = lit_ball()
        scene.render.resolution_x = scene.render.resolution_y = 8
        scene.frame_set(-5)
        scene.pvol.seed, scene.pvol.animate_seed = 0, True
        scene.render.filter_size = 200
        scene.pvol.samples, scene.pvol.denoise = 1, True
        scene.camera.scale = (-1, -1, -1)
        self.assertGreater(np.nanmax(render("PVOL", 1)), 0)
        self.assertTrue(noted(translated_camera(), "mirrors"))


def translated_camera():
    from pvol_blender.translate import Translation
    from pvol_blender.translate.files import DryFiles

    translation = Translation(bpy.context.evaluated_depsgraph_get(), DryFiles())
    table = translation.camera(bpy.context.scene.camera)
    matrix = np.array(table["matrix"]).reshape(4, 4)
    assert np.linalg.det(matrix[:3, :3]) > 0
    return [str(note) for note in translation.notes]


class Lamps(unittest.TestCase):
    def test_names_stay_apart(self):
        from pvol_blender.translate.lights import group_of

        _, lamp = lit_ball()
        found = set()
        names = ("Ж", "Ю", "objects", "Sun", "l" * 63, "l" * 62 + "m")
        for name in names:
            lamp.name = name
            found.add(group_of(lamp))
        self.assertEqual(len(found), len(names), found)
        self.assertLessEqual(max(map(len, found)), 57)
        self.assertNotIn("objects", found)

    def test_no_name_is_that_of_another_layer(self):
        from pvol_blender.translate.lights import group_of

        library = pathlib.Path(__file__).resolve().parents[2] / "libpvol"
        layers = re.findall(r'\{Aov::\w+, "(\w+)"', (library / "include/pvol/render/aov.h").read_text())
        groups = (library / "src/render/scene/light_group.cpp").read_text()
        taken = re.findall(r'"(\w+)"', groups[groups.index("kTaken"):groups.index("is_among")])
        self.assertGreater(len(layers), 10)
        self.assertGreater(len(taken), 5)
        _, lamp = lit_ball()
        for name in layers + taken:
            lamp.name = name
            self.assertNotEqual(group_of(lamp), name)

    def test_longest_name_has_its_pass(self):
        scene, lamp = lit_ball()
        scene.render.resolution_x = scene.render.resolution_y = 8
        lamp.name = "x" * 63
        bpy.context.view_layer.pvol.layers = {"lights"}
        self.assertGreater(np.nanmax(render("PVOL", 1)), 0)

    def test_of_no_size(self):
        _, lamp = lit_ball()
        for data, scale in ((0, 1), (1, 0)):
            lamp.data.size, lamp.scale = data, (scale,) * 3
            bpy.context.view_layer.update()
            sections, notes = translated()
            self.assertNotIn("area", sections)
            self.assertTrue(noted(notes, "scaled to nothing"))

    def test_that_differ_are_noted(self):
        _, lamp = lit_ball()
        lamp.visible_diffuse = False
        lamp.data.energy = -5
        self.assertTrue(noted(translated()[1], "takes light away"))
        lamp.data.energy = 5
        self.assertTrue(noted(translated()[1], "do not see"))

    def test_quadratic_falloff_is_the_lamps_own(self):
        _, lamp = lit_ball()
        before = translated()[0]["area"][0]["radiance"]
        lamp.data.use_nodes = True
        tree = lamp.data.node_tree
        falloff = tree.nodes.new("ShaderNodeLightFalloff")
        falloff.inputs["Strength"].default_value = 5
        tree.links.new(falloff.outputs["Quadratic"], tree.nodes["Emission"].inputs["Strength"])
        sections, notes = translated()
        np.testing.assert_allclose(sections["area"][0]["radiance"], 5 * np.array(before), rtol=1e-6)
        self.assertFalse(notes)
        tree.nodes.remove(tree.nodes["Light Output"])
        self.assertNotIn("area", translated()[0])


class Meshes(unittest.TestCase):
    def test_instances_of_nodes_have_their_own(self):
        from pvol_blender.translate.files import Files

        scenes.empty()
        thing = scenes.add("Tree", bpy.data.meshes.new("Nothing"))
        tree = bpy.data.node_groups.new("Instances", "GeometryNodeTree")
        tree.outputs.new("NodeSocketGeometry", "Geometry")
        output = tree.nodes.new("NodeGroupOutput")
        join = tree.nodes.new("GeometryNodeJoinGeometry")
        tree.links.new(join.outputs[0], output.inputs[0])
        for kind in ("GeometryNodeMeshCone", "GeometryNodeMeshCube"):
            mesh = tree.nodes.new(kind)
            instance = tree.nodes.new("GeometryNodeGeometryToInstance")
            tree.links.new(mesh.outputs["Mesh"], instance.inputs[0])
            tree.links.new(instance.outputs[0], join.inputs[0])
        thing.modifiers.new("Nodes", "NODES").node_group = tree
        bpy.context.view_layer.update()
        files = Files()
        try:
            sections, _ = translated(files)
            sizes = {pathlib.Path(m["file"]).stat().st_size for m in sections["mesh"]}
        finally:
            files.close()
        self.assertEqual(len(sections["mesh"]), 2)
        self.assertEqual(len(sizes), 2, "a cone and a cube")

    def test_have_the_material_of_the_view_layer(self):
        lit_ball()
        bpy.context.view_layer.material_override = scenes.diffuse((0.25, 0.5, 0.75))
        np.testing.assert_allclose(translated()[0]["mesh"][0]["albedo"], (0.25, 0.5, 0.75))


class Volumes(unittest.TestCase):
    def test_glow_of_a_box_that_absorbs_by_channel(self):
        """Seen through a box of side 2: emission over absorption times what it hides."""
        scene = scenes.empty()
        color = np.array([0.9, 0.5, 0.1])
        material = bpy.data.materials.new("Glow")
        material.use_nodes = True
        tree = material.node_tree
        tree.nodes.clear()
        output, add = tree.nodes.new("ShaderNodeOutputMaterial"), tree.nodes.new("ShaderNodeAddShader")
        absorption = tree.nodes.new("ShaderNodeVolumeAbsorption")
        absorption.inputs["Color"].default_value = (*color, 1)
        absorption.inputs["Density"].default_value = 1
        emission = tree.nodes.new("ShaderNodeEmission")
        tree.links.new(absorption.outputs[0], add.inputs[0])
        tree.links.new(emission.outputs[0], add.inputs[1])
        tree.links.new(add.outputs[0], output.inputs["Volume"])
        scenes.box(material)
        scenes.camera((0, -60, 0), type="ORTHO", ortho_scale=0.1)
        scene.render.resolution_x = scene.render.resolution_y = 8
        absorbed = 1 - color
        expected = (1 - np.exp(-2 * absorbed)) / absorbed
        found = render("PVOL", 64)[..., :3].mean(axis=(0, 1))
        np.testing.assert_allclose(found, expected, rtol=0.02)

    def test_ramps_ascend(self):
        from pvol_blender.translate.fields import ramp_points

        scenes.empty()
        tree = bpy.data.materials.new("Ramp")
        tree.use_nodes = True
        ramp = tree.node_tree.nodes.new("ShaderNodeValToRGB").color_ramp
        for interpolation in ("LINEAR", "CONSTANT"):
            ramp.interpolation = interpolation
            for places in ((0.5, 0.5), (0.0, 5e-5)):
                for element, place in zip(ramp.elements, places):
                    element.position = place
                points = [p for p, _ in ramp_points(ramp)]
                self.assertTrue(all(a < b for a, b in zip(points, points[1:])), points)
                self.assertGreaterEqual(points[0], 0)


class Skies(unittest.TestCase):
    def test_radiance_files_keep_the_mean(self):
        from pvol_blender.translate import radiance

        rng = np.random.default_rng(3)
        rgb = np.exp(rng.normal(size=(64, 64, 3))).astype(np.float32)
        rgb[0, 0] = 0.99999  # rounds to the next power of two
        with tempfile.TemporaryDirectory() as folder:
            path = pathlib.Path(folder) / "sky.hdr"
            radiance.write(path, rgb)
            raw = path.read_bytes()
        pixels = np.frombuffer(raw[-64 * 64 * 4:], dtype=np.uint8).reshape(64, 64, 4).astype(float)
        back = pixels[..., :3] * 2.0 ** (pixels[..., 3:] - 136)
        self.assertAlmostEqual(back.mean() / rgb.mean(), 1, delta=1e-4)
        self.assertLess(np.abs(back - rgb).max() / rgb.max(), 1 / 256)

    def test_coordinates_before_a_mapping_are_checked(self):
        scenes.empty()
        tree = bpy.context.scene.world.node_tree
        sky = tree.nodes.new("ShaderNodeTexSky")
        sky.sky_type = "PREETHAM"
        place, mapping = (tree.nodes.new("ShaderNode" + kind) for kind in ("TexCoord", "Mapping"))
        tree.links.new(mapping.outputs["Vector"], sky.inputs["Vector"])
        tree.links.new(sky.outputs["Color"], tree.nodes["Background"].inputs["Color"])
        tree.links.new(place.outputs["Generated"], mapping.inputs["Vector"])
        before = translated()[0]["environment"]["azimuth"]
        mapping.inputs["Rotation"].default_value = (0, 0, math.radians(30))
        sections, notes = translated()
        turned = abs(sections["environment"]["azimuth"] - before)
        self.assertAlmostEqual(min(turned, 360 - turned), 30, places=4)
        self.assertFalse(noted(notes, "coordinates"))
        tree.links.new(place.outputs["Object"], mapping.inputs["Vector"])
        self.assertTrue(noted(translated()[1], "coordinates"))
