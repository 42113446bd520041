"""Surfaces: colours, holdouts, shadow catchers, and which rays meet them."""

import unittest

import bpy
import numpy as np

import scenes
from pictures import both, difference, framing, render


def with_ball(**settings):
    scene = scenes.empty()
    scene.render.film_transparent = True
    bpy.ops.mesh.primitive_ico_sphere_add(subdivisions=3, radius=0.7, location=(0.4, -0.5, -0.4))
    ball = bpy.context.object
    ball.data.materials.append(scenes.diffuse((0.7, 0.2, 0.1)))
    for name, value in settings.items():
        setattr(ball, name, value)
    scenes.box(scenes.smoke(0.6, (0.9, 0.9, 0.9), attribute=""))
    scenes.lamp("SUN", (1, -2, 3), energy=3)
    scenes.background((0.3, 0.4, 0.5))
    scenes.camera((0, -7, 1), lens=40)
    return ball


class Surfaces(unittest.TestCase):
    def compare(self):
        p, c = both(96, 96)
        excess, text = difference(p, c)
        print(f"    {self.id().rsplit('.', 1)[1]}: {text}")
        self.assertLess(excess, 1, text)
        self.assertLess(np.abs(framing(p.alpha) - framing(c.alpha)).max(), 0.2)
        self.assertLess(abs(p.alpha.mean() - c.alpha.mean()), 0.01)

    def test_diffuse(self):
        with_ball()
        self.compare()

    def test_holdout(self):
        with_ball(is_holdout=True)
        self.compare()

    def test_holdout_of_a_collection(self):
        ball = with_ball()
        group = bpy.data.collections.new("Set")
        bpy.context.scene.collection.children.link(group)
        group.objects.link(ball)
        bpy.context.scene.collection.objects.unlink(ball)
        bpy.context.view_layer.layer_collection.children["Set"].holdout = True
        self.compare()

    def test_invisible_to_the_camera(self):
        with_ball(visible_camera=False)
        self.compare()

    def test_without_shadow(self):
        with_ball(visible_shadow=False)
        # Cycles lets the ball shade some of the sky's light all the same.
        scenes.background((0, 0, 0))
        self.compare()

    def test_shadow_catcher(self):
        """The shadow is where Cycles has it; how both lay it over a photograph differs."""
        scene = scenes.empty()
        scene.render.film_transparent = True
        scenes.floor().is_shadow_catcher = True
        scenes.box(scenes.smoke(20, (0.5, 0.5, 0.5), attribute=""), location=(0, 0, 0.6),
                   scale=(0.4, 0.4, 0.4))
        scenes.lamp("SUN", (1, -2, 3), energy=3)
        scenes.background((0.1, 0.1, 0.1))
        scenes.camera((0, -7, 3), lens=40)
        p, c = both(128, 128)
        self.assertLess(np.abs(framing(p.alpha) - framing(c.alpha)).max(), 1.5)


class Dicts(unittest.TestCase):
    def tables(self):
        from pvol_blender.translate import Translation
        from pvol_blender.translate.files import DryFiles

        self.translation = Translation(bpy.context.evaluated_depsgraph_get(), DryFiles())
        return self.translation.sections()

    def test_materials_split_a_mesh(self):
        scenes.empty()
        mesh = scenes.cube_mesh()
        for color in ((1, 0, 0), (0, 0, 1)):
            mesh.materials.append(scenes.diffuse(color))
        mesh.polygons[2].material_index = 1
        scenes.add("Cube", mesh, location=(1, 2, 3))
        meshes = self.tables()["mesh"]
        self.assertEqual([m["albedo"] for m in meshes], [[1, 0, 0], [0, 0, 1]])
        self.assertEqual(meshes[0]["matrix"][3::4], [1, 2, 3, 1])

    def test_rays(self):
        scenes.empty()
        cube = scenes.add("Cube", scenes.cube_mesh())
        cube.visible_camera = cube.visible_volume_scatter = cube.visible_diffuse = False
        table = self.tables()["mesh"][0]
        self.assertEqual((table["visible_camera"], table["visible_light"]), (False, False))
        self.assertNotIn("visible_shadow", table)

    def test_glossy_materials_are_noted(self):
        scenes.empty()
        mesh = scenes.cube_mesh()
        material = bpy.data.materials.new("Chrome")
        material.use_nodes = True
        material.node_tree.nodes["Principled BSDF"].inputs["Metallic"].default_value = 1
        mesh.materials.append(material)
        scenes.add("Cube", mesh)
        self.tables()
        self.assertEqual([n.thing for n in self.translation.notes], ["Cube, material Chrome"])

    def test_ply(self):
        import tempfile

        from pvol_blender.translate import ply

        with tempfile.NamedTemporaryFile(suffix=".ply") as file:
            ply.write(file.name, np.eye(3), np.array([[0, 1, 2]]))
            data = file.read()
        header, body = data.split(b"end_header\n")
        self.assertIn(b"element vertex 3\n", header)
        self.assertEqual(len(body), 36 + 13)


if __name__ == "__main__":
    unittest.main()
