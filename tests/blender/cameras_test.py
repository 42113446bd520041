"""Cameras: either program sees small dense boxes at the same place in the picture."""

import math
import unittest

import bpy
import numpy as np

import scenes
from pictures import framing, render, shot


def dense():
    """Three boxes of different sizes, so that mirrored and turned pictures differ."""
    scene = scenes.empty()
    scene.render.film_transparent = True
    material = scenes.smoke(40, (0.5, 0.5, 0.5), attribute="")
    for location, size in (((0.9, 0, 0.3), 0.3), ((-0.5, 0.4, -0.4), 0.15), ((0.2, 1, 0.5), 0.1)):
        scenes.box(material, location=location, scale=(size, size, size))
    scenes.lamp("SUN", (0, -1, 1), energy=1)
    return scene


class Cameras(unittest.TestCase):
    def compare(self, pixels=0.15):
        p, c = render("PVOL", 64)[..., 3], render("CYCLES", 64)[..., 3]
        apart = np.abs(framing(p) - framing(c))
        print(f"    {self.id().rsplit('.', 1)[1]}: apart by {apart.max():.3f} pixels")
        self.assertLess(apart.max(), pixels, f"{framing(p)} {framing(c)}")
        self.assertLess(abs(p.sum() / c.sum() - 1), 0.02)
        return p, c

    def test_perspective(self):
        dense()
        scenes.camera((1, -5, 1), lens=50)
        self.compare()

    def test_a_wrong_lens_is_found(self):
        dense()
        thing = scenes.camera((1, -5, 1), lens=50)
        p = render("PVOL", 64)[..., 3]
        thing.data.lens = 51.5
        c = render("CYCLES", 64)[..., 3]
        self.assertGreater(np.abs(framing(p) - framing(c)).max(), 0.15)

    def test_sensors(self):
        for fit in ("AUTO", "HORIZONTAL", "VERTICAL"):
            for size in (scenes.SIZE, scenes.SIZE[::-1]):
                with self.subTest(fit=fit, size=size):
                    scene = dense()
                    scene.render.resolution_x, scene.render.resolution_y = size
                    scenes.camera((1, -7, 1), lens=35, sensor_fit=fit, sensor_width=30,
                                  sensor_height=20)
                    self.compare()

    def test_shift(self):
        for fit in ("AUTO", "VERTICAL"):
            with self.subTest(fit=fit):
                dense()
                scenes.camera((1, -6, 1), lens=50, shift_x=0.12, shift_y=-0.07, sensor_fit=fit)
                self.compare()

    def test_orthographic(self):
        dense()
        scenes.camera((1, -5, 1), type="ORTHO", ortho_scale=4, shift_x=0.1, shift_y=0.05)
        self.compare()

    def test_panorama(self):
        scene = dense()
        scene.render.resolution_x, scene.render.resolution_y = 96, 48
        thing = scenes.camera((0.2, -1.6, 0.3), (0.5, 0, 0), type="PANO")
        owner = thing.data if hasattr(thing.data, "panorama_type") else thing.data.cycles
        owner.panorama_type = "EQUIRECTANGULAR"
        self.compare()

    def test_border(self):
        scene = dense()
        scenes.camera((1, -5, 1), lens=50)
        scene.render.use_border = True
        scene.render.border_min_x, scene.render.border_max_x = 0.3, 0.9
        scene.render.border_min_y, scene.render.border_max_y = 0.2, 0.75
        for cropped in (False, True):
            with self.subTest(cropped=cropped):
                scene.render.use_crop_to_border = cropped
                p, c = self.compare()
                self.assertEqual(p.shape, c.shape)

    def test_percentage(self):
        scene = dense()
        scene.render.resolution_percentage = 50
        scenes.camera((1, -5, 1), lens=50)
        p, _ = self.compare()
        self.assertEqual(p.shape, (27, 48))

    def test_depth_of_field(self):
        dense()
        thing = scenes.camera((1, -5, 1), lens=50)
        sharp = render("PVOL", 64)[..., 3]
        thing.data.dof.use_dof = True
        thing.data.dof.aperture_fstop = 0.05
        target = scenes.add("Focus", None, location=(0, -2, 0))
        thing.data.dof.focus_object = target
        p, c = shot("PVOL", 256).alpha, shot("CYCLES", 256).alpha
        self.assertLess(np.abs(p - c).mean(), 0.25 * np.abs(p - sharp).mean())

    def test_moving_camera(self):
        scene = dense()
        thing = scenes.camera((1, -5, 1), lens=50)
        for frame, x in ((1, 1), (2, 1.6)):
            thing.location.x = x
            thing.keyframe_insert("location", frame=frame)
        for curve in thing.animation_data.action.fcurves:
            for point in curve.keyframe_points:
                point.interpolation = "LINEAR"
            curve.extrapolation = "LINEAR"
        scene.render.use_motion_blur = True
        scene.render.motion_blur_shutter = 1.0
        scene.frame_set(1)
        p, _ = self.compare(0.3)
        scene.render.use_motion_blur = False
        still = render("PVOL", 64)[..., 3]
        self.assertGreater(np.abs(p - still).mean(), 0.01, "nothing is blurred")


class Dicts(unittest.TestCase):
    def test_keys(self):
        from pvol_blender.translate import camera
        from pvol_blender.translate.notes import Notes

        scenes.empty()
        thing = scenes.camera((1, 2, 3), lens=35, sensor_fit="VERTICAL", sensor_height=20,
                              shift_x=0.1)
        thing.data.dof.use_dof = True
        thing.data.dof.focus_distance = 4
        thing.data.dof.aperture_fstop = 2
        thing.data.dof.aperture_blades = 5
        bpy.context.view_layer.update()
        notes = Notes()
        table = camera.of_object(thing, thing.matrix_world, bpy.context.scene, notes)
        self.assertEqual(table["sensor"], 20)
        self.assertEqual(table["sensor_fit"], "vertical")
        self.assertEqual(table["focal_length"], 35)
        self.assertEqual((table["f_stop"], table["focus_distance"]), (2, 4))
        self.assertEqual([table["matrix"][i] for i in (3, 7, 11)], [1, 2, 3])
        self.assertEqual([n.thing for n in notes], ["Camera"])

    def test_view(self):
        """A viewport's camera has the rays of its projection."""
        from mathutils import Matrix

        from pvol_blender.translate import camera

        x, y, offset_x, offset_y = 1.5, 2.4, 0.2, -0.3
        window = Matrix(((x, 0, offset_x, 0), (0, y, offset_y, 0), (0, 0, -1.002, -0.2),
                         (0, 0, -1, 0)))
        table = camera.of_view(Matrix.Identity(4), window)
        across = table["sensor"] / table["focal_length"]  # width of the view at distance 1
        self.assertAlmostEqual(across, 2 / x, places=6)
        self.assertAlmostEqual(table["shift"][0] * across, offset_x / x, places=6)
        self.assertAlmostEqual(table["shift"][1] * across, offset_y / y, places=6)
        window = Matrix(((0.5, 0, 0, 0.1), (0, 0.8, 0, -0.2), (0, 0, -0.002, 0), (0, 0, 0, 1)))
        table = camera.of_view(Matrix.Identity(4), window)
        self.assertAlmostEqual(table["ortho_scale"], 4, places=6)
        self.assertAlmostEqual(table["shift"][0] * 4, -0.1 / 0.5, places=6)
        self.assertAlmostEqual(table["shift"][1] * 4, 0.2 / 0.8, places=6)
        self.assertGreater(table["matrix"][11], 100)


if __name__ == "__main__":
    unittest.main()
