"""The world, as a panorama of all directions: pictures of the sky, turned, and clear air."""

import math
import unittest

import bpy
import numpy as np

import scenes
from pictures import framing, render, shot


def panorama():
    scene = scenes.empty()
    scene.render.resolution_x, scene.render.resolution_y = 96, 48
    thing = scenes.camera((0, 0, 0), (0, 1, 0), type="PANO")
    owner = thing.data if hasattr(thing.data, "panorama_type") else thing.data.cycles
    owner.panorama_type = "EQUIRECTANGULAR"
    return scene


def picture_node(rotation=None, vector_type="POINT", is_float=True):
    """A sky with a bright spot right of the middle and above the horizon."""
    tree = bpy.context.scene.world.node_tree
    image = bpy.data.images.new("Sky", 64, 32, float_buffer=is_float)
    pixels = np.full((32, 64, 4), 0.1, dtype=np.float32)
    pixels[20:24, 40:46, :3] = (1.0, 0.5, 0.25)
    pixels[..., 3] = 1
    image.pixels.foreach_set(pixels.ravel())
    node = tree.nodes.new("ShaderNodeTexEnvironment")
    node.image = image
    tree.links.new(node.outputs["Color"], tree.nodes["Background"].inputs["Color"])
    if rotation is not None:
        place = tree.nodes.new("ShaderNodeTexCoord")
        mapping = tree.nodes.new("ShaderNodeMapping")
        mapping.vector_type = vector_type
        mapping.inputs["Rotation"].default_value = rotation
        tree.links.new(place.outputs["Generated"], mapping.inputs["Vector"])
        tree.links.new(mapping.outputs["Vector"], node.inputs["Vector"])
    return node


class Pictures(unittest.TestCase):
    def compare(self, tolerance=0.02):
        p, c = render("PVOL", 16)[..., :3], render("CYCLES", 16)[..., :3]
        np.testing.assert_allclose(p.mean(axis=(0, 1)), c.mean(axis=(0, 1)), rtol=tolerance)
        apart = np.abs(framing(np.maximum(p[..., 0] - 0.15, 0))
                       - framing(np.maximum(c[..., 0] - 0.15, 0)))
        self.assertLess(apart.max(), 0.5)

    def test_as_it_is(self):
        panorama()
        picture_node()
        bpy.context.scene.world.node_tree.nodes["Background"].inputs[1].default_value = 2
        self.compare()

    def test_bytes(self):
        panorama()
        picture_node(is_float=False)
        self.compare(0.1)  # Cycles interpolates before it makes bytes linear

    def test_turned(self):
        for kind in ("POINT", "TEXTURE", "VECTOR"):
            for degrees in (50, -110):
                with self.subTest(kind=kind, degrees=degrees):
                    panorama()
                    picture_node((0, 0, math.radians(degrees)), kind)
                    self.compare()

    def test_what_is_not_mapped(self):
        from pvol_blender import unmapped

        panorama()
        picture_node((0.4, 0, 0))
        notes = unmapped.look(bpy.context.evaluated_depsgraph_get())
        self.assertIn("Mapping", str(notes[0]))


class ClearSky(unittest.TestCase):
    def sky(self, elevation, rotation, disc=False):
        tree = bpy.context.scene.world.node_tree
        node = tree.nodes.new("ShaderNodeTexSky")
        kinds = [i.identifier for i in node.bl_rna.properties["sky_type"].enum_items]
        node.sky_type = "NISHITA" if "NISHITA" in kinds else "SINGLE_SCATTERING"
        node.sun_disc = disc
        node.sun_elevation, node.sun_rotation = scenes.radians(elevation, rotation)
        tree.links.new(node.outputs["Color"], tree.nodes["Background"].inputs["Color"])
        return node

    def test_the_sun_is_where_it_is_in_blender(self):
        panorama()
        self.sky(35, 70, disc=True)
        p, c = render("PVOL", 512)[:24, :, 1], render("CYCLES", 512)[:24, :, 1]
        near = [np.unravel_index(x.argmax(), x.shape) for x in (p, c)]
        self.assertLessEqual(np.abs(np.subtract(*near)).max(), 1)

    def test_a_floor_in_sunlight(self):
        """The sun within a tenth; Blender's sky, in which light scatters once, is dimmer."""
        lit = {}
        for disc in (False, True):
            scenes.empty()
            self.sky(40, 20, disc)
            scenes.floor(0, half=1000)
            scenes.camera((0, 0, 5), type="ORTHO", ortho_scale=1)
            bpy.context.scene.render.resolution_x = bpy.context.scene.render.resolution_y = 16
            lit[disc] = [shot(engine, 256).mean()[0] for engine in ("PVOL", "CYCLES")]
        sky = lit[False][0] / lit[False][1]
        sun = (lit[True][0] - lit[False][0]) / (lit[True][1] - lit[False][1])
        print(f"    sky {sky.round(3)}, sun {sun.round(3)} of Cycles'")
        np.testing.assert_allclose(sun, 1, atol=0.1)
        self.assertTrue(((sky > 1) & (sky < 1.9)).all())


if __name__ == "__main__":
    unittest.main()
