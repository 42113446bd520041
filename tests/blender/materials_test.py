"""Node trees of volumes as media and fires, without rendering."""

import math
import unittest

import bpy
import numpy as np

import scenes

GRIDS = {n: n for n in ("density", "flame", "temperature", "color")}


class Materials(unittest.TestCase):
    def setUp(self):
        scenes.empty()

    def matter(self, material, grids=GRIDS):
        from pvol_blender.translate import medium
        from pvol_blender.translate.notes import Notes

        self.notes = Notes()
        return medium.of_material(material, grids, self.notes, "Cloud")

    def chain(self, material, socket, *steps):
        """Links nodes to a socket of a Principled Volume: (type, settings, inputs) each, the first
        one nearest to the grid."""
        tree = material.node_tree
        output = None
        for kind, settings, inputs in steps:
            node = tree.nodes.new(kind)
            for name, value in settings.items():
                setattr(node, name, value)
            for index, value in inputs.items():
                node.inputs[index].default_value = value
            if output is not None:
                name = {"ShaderNodeMapRange": "Value", "ShaderNodeClamp": "Value"}.get(kind, 0)
                tree.links.new(output, node.inputs[name])
            output = node.outputs[node.outputs.find("Fac") if "Fac" in node.outputs else 0]
        tree.links.new(output, tree.nodes["Principled Volume"].inputs[socket])
        return node

    def test_principled(self):
        made = self.matter(scenes.smoke(3, (0.8, 0.5, 0.2), 0.4))
        self.assertEqual(made.grid, "density")
        self.assertEqual(made.medium["extinction"], 3)
        np.testing.assert_allclose(made.medium["albedo"], (0.8, 0.5, 0.2), atol=1e-6)
        self.assertAlmostEqual(made.medium["g"], 0.4)
        self.assertFalse(self.notes or made.fires)

    def test_absorption_color(self):
        made = self.matter(scenes.smoke(2, (0.5, 0.5, 0.5), Absorption_Color=(1, 0.25, 0, 1)))
        # Scattering 1; absorption (1 - 0.5) (1 - sqrt(a)) 2.
        np.testing.assert_allclose(
            np.array(made.medium["extinction_color"]) * made.medium["extinction"], (1, 1.5, 2),
            rtol=1e-6)
        np.testing.assert_allclose(made.medium["albedo"], (1, 2 / 3, 0.5), rtol=1e-6)

    def test_density_by_nodes(self):
        material = scenes.smoke(attribute="")
        self.chain(material, "Density",
                   ("ShaderNodeAttribute", {"attribute_name": "density"}, {}),
                   ("ShaderNodeMath", {"operation": "SUBTRACT"}, {1: 0.1}),
                   ("ShaderNodeMath", {"operation": "MAXIMUM"}, {1: 0.0}),
                   ("ShaderNodeMath", {"operation": "POWER"}, {1: 2.0}),
                   ("ShaderNodeMath", {"operation": "MULTIPLY"}, {1: 5.0}))
        made = self.matter(material)
        self.assertFalse(self.notes)
        self.assertEqual(made.medium["extinction"], 5)
        table = made.medium["density"]
        self.assertAlmostEqual(table["offset"], -0.1)
        self.assertEqual((table["clamp"][0], table["power"]), (0, 2))

    def test_map_range(self):
        material = scenes.smoke(attribute="")
        self.chain(material, "Density",
                   ("ShaderNodeVolumeInfo", {}, {}),
                   ("ShaderNodeMapRange", {}, {"From Min": 0.2, "From Max": 0.6, "To Min": 0.0,
                                               "To Max": 2.0}))
        tree = material.node_tree
        tree.links.new(tree.nodes["Volume Info"].outputs["Density"],
                       tree.nodes["Map Range"].inputs["Value"])
        table = self.matter(material).medium["density"]
        self.assertAlmostEqual(table["scale"], 5, places=5)
        self.assertAlmostEqual(table["offset"], -1, places=5)
        self.assertEqual(table["clamp"], [0, 2])

    def test_color_ramp(self):
        material = scenes.smoke(attribute="")
        node = self.chain(material, "Density",
                          ("ShaderNodeAttribute", {"attribute_name": "density"}, {}),
                          ("ShaderNodeValToRGB", {}, {}))
        node.color_ramp.elements[0].position = 0.3
        np.testing.assert_allclose(self.matter(material).medium["density"]["ramp"],
                                   [[0.3, 0], [1, 1]], atol=1e-6)

    def test_density_twice_is_its_square(self):
        material = scenes.smoke()
        self.chain(material, "Density", ("ShaderNodeAttribute", {"attribute_name": "density"}, {}))
        made = self.matter(material)
        self.assertEqual(made.medium["density"], {"power": 2})

    def test_textures_are_noted(self):
        material = scenes.smoke(1.5)
        self.chain(material, "Density", ("ShaderNodeTexNoise", {}, {}))
        made = self.matter(material)
        self.assertEqual(made.medium["extinction"], 1.5)
        self.assertEqual(len(self.notes), 1)
        self.assertIn("Density", str(self.notes[0]))
        self.assertEqual(self.notes[0].thing, f"Cloud, material {material.name}")

    def test_a_grid_that_is_missing_is_zero(self):
        material = scenes.smoke(2)
        self.chain(material, "Emission Strength",
                   ("ShaderNodeAttribute", {"attribute_name": "heat"}, {}),
                   ("ShaderNodeMath", {"operation": "MULTIPLY"}, {1: 12.0}))
        made = self.matter(material)
        self.assertEqual(made.fires, [])
        self.assertIn("heat", str(self.notes[0]))

    def test_color_attribute(self):
        material = scenes.smoke()
        material.node_tree.nodes["Principled Volume"].inputs[
            "Color Attribute"].default_value = "color"
        self.assertEqual(self.matter(material).color_grid, "color")

    def test_fire(self):
        material = scenes.smoke(2, Blackbody_Intensity=1, Temperature=1500)
        made = self.matter(material)
        fire = made.fires[0]
        self.assertEqual((fire["field"], fire["color_by"], fire["power"]),
                         ("temperature", "temperature", 4))
        self.assertEqual(fire["kelvin"], 1500)
        self.assertAlmostEqual(fire["intensity"], 5.670373e-14 / math.pi * 1500**4)

    def test_flames_with_colors(self):
        material = scenes.smoke(0)
        self.chain(material, "Emission Strength",
                   ("ShaderNodeAttribute", {"attribute_name": "flame"}, {}),
                   ("ShaderNodeMath", {"operation": "MULTIPLY"}, {1: 12.0}))
        node = self.chain(material, "Emission Color",
                          ("ShaderNodeAttribute", {"attribute_name": "flame"}, {}),
                          ("ShaderNodeValToRGB", {}, {}))
        node.color_ramp.elements[1].color = (1, 0.5, 0.1, 1)
        made = self.matter(material)
        self.assertEqual(made.grid, "none")
        fire = made.fires[0]
        self.assertEqual((fire["field"], fire["intensity"], fire["color_by"]),
                         ("flame", 12, "flame"))
        np.testing.assert_allclose(fire["colors"], [[0, 0, 0, 0], [1, 1, 0.5, 0.1]], atol=1e-6)

    def test_scatter_and_absorption(self):
        material = scenes.smoke()
        tree = material.node_tree
        grid = tree.nodes.new("ShaderNodeAttribute")
        grid.attribute_name = "density"
        add = tree.nodes.new("ShaderNodeAddShader")
        for i, (kind, color) in enumerate((("ShaderNodeVolumeScatter", (0.6, 0.6, 0.6, 1)),
                                           ("ShaderNodeVolumeAbsorption", (0.6, 0.6, 0.6, 1)))):
            node = tree.nodes.new(kind)
            node.inputs["Color"].default_value = color
            tree.links.new(grid.outputs["Fac"], node.inputs["Density"])
            tree.links.new(node.outputs[0], add.inputs[i])
        tree.links.new(add.outputs[0], tree.nodes["Material Output"].inputs["Volume"])
        made = self.matter(material)
        self.assertAlmostEqual(made.medium["extinction"], 1, places=5)
        np.testing.assert_allclose(made.medium["albedo"], 0.6, atol=1e-5)

    def test_boxes(self):
        from pvol_blender.translate import box

        corners = np.array([(x, y, z) for x in (0, 1) for y in (0, 2) for z in (0, 3)], float)
        self.assertTrue(box.is_box(corners))
        self.assertFalse(box.is_box(corners[:7]))
        corners[0] += 0.1
        self.assertFalse(box.is_box(corners))


if __name__ == "__main__":
    unittest.main()
