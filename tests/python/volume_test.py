"""pvol.Volume: arrays in, samples out."""
import gc
import tempfile
import threading
import unittest

import numpy as np

import pvol
from clouds import lumps, ramp, slab
from messages import message


class Arrays(unittest.TestCase):
    def test_sample_i_j_k_is_array_i_j_k(self):
        a = ramp()
        v = pvol.Volume(a)
        points = np.array([[3, 5, 7], [20, 1, 2], [0, 0, 28]], float)
        np.testing.assert_allclose(v.density(points), [a[3, 5, 7], a[20, 1, 2], a[0, 0, 28]], rtol=1e-6)

    def test_what_no_memory_holds_is_refused(self):
        with self.assertRaisesRegex(pvol.Error, message("capi.needs_memory")):
            pvol.Volume(np.broadcast_to(np.float32(1), (100_000,) * 3))

    def test_other_types_are_named(self):
        for wrong in [[[[1.0]]], None, 3]:
            with self.assertRaisesRegex(TypeError, f"found a {type(wrong).__name__}, expected a NumPy array"):
                pvol.Volume(wrong)
        for wrong in [None, 3, ramp()]:
            with self.assertRaisesRegex(TypeError, f"found a {type(wrong).__name__}, expected a scene"):
                pvol.render(wrong)

    def test_interpolation_is_trilinear(self):
        a = ramp()
        v = pvol.Volume(a)
        i, j, k, f = 4, 9, 11, np.array([0.25, 0.5, 0.75])
        expected = a[i, j, k] + f @ [0.3, 0.05, 0.011]
        self.assertAlmostEqual(float(v.density([i, j, k] + f)), expected, places=5)

    def test_maps_put_it_into_the_world(self):
        a = ramp()
        m = np.array([[0, 0, 0.5, 10], [0.25, 0, 0, 20], [0, 2, 0, 30], [0, 0, 0, 1]], float)
        v = pvol.Volume(a, index_to_world=m)
        np.testing.assert_array_equal(v.index_to_world, m)
        at = m @ [3, 5, 7, 1]
        self.assertAlmostEqual(float(v.density(at[:3])), float(a[3, 5, 7]), places=5)
        w = pvol.Volume(a, voxel_size=(0.5, 1, 2))
        self.assertAlmostEqual(float(w.density([1.5, 5, 14])), float(a[3, 5, 7]), places=5)
        np.testing.assert_array_equal(pvol.Volume(a, index_to_world=m[:3]).index_to_world, m)

    def test_any_strides_and_types_give_the_same_volume(self):
        a = ramp()
        every = np.zeros((2 * a.shape[0], a.shape[1], 3 * a.shape[2]), np.float32)
        every[::2, :, ::3] = a
        records = np.zeros(a.shape, [("tag", "u1"), ("density", "f4")])
        records["density"] = a
        points = np.random.default_rng(1).uniform(0, 24, (2000, 3))
        expected = pvol.Volume(a).density(points)
        for name, other in {
            "fortran": np.asfortranarray(a),
            "every other": every[::2, :, ::3],
            "backwards": np.ascontiguousarray(a[::-1, :, ::-1])[::-1, :, ::-1],
            "transposed": np.ascontiguousarray(a.transpose(2, 0, 1)).transpose(1, 2, 0),
            "double": a.astype(np.float64),
            "records": records["density"],
            "read-only": np.lib.stride_tricks.as_strided(a, writeable=False),
        }.items():
            with self.subTest(name):
                np.testing.assert_array_equal(pvol.Volume(other).density(points), expected)
        half = pvol.Volume(a.astype(np.float16)).density(points)
        np.testing.assert_allclose(half, expected, rtol=1e-3)
        whole = pvol.Volume(np.full((4, 4, 4), 3, np.int32))
        self.assertEqual(float(whole.density([1, 1, 1])), 3)

    def test_float_arrays_are_read_where_they_are(self):
        # An array of 64 MB that is almost empty: a copy would show in the peak of memory.
        import resource

        big = np.zeros((256, 256, 256), np.float32)[::1, ::-1, :]
        big[100:108, 100:108, 100:108] = 1
        pvol.Volume(big)
        before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
        for _ in range(3):
            pvol.Volume(big)
        grown = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before
        self.assertLess(grown, 32 * 1024)  # KiB

    def test_a_volume_outlives_its_array(self):
        a = ramp().copy()
        v = pvol.Volume(a)
        at = [3, 5, 7]
        value = float(a[3, 5, 7])
        a[:] = 0
        del a
        gc.collect()
        self.assertAlmostEqual(float(v.density(at)), value, places=5)
        bounds, medium = v.bounds(), v.with_medium(albedo=0.5)
        del v
        gc.collect()
        self.assertGreater(len(bounds), 0)
        self.assertAlmostEqual(float(medium.density(at)), value, places=5)

    def test_shapes_of_points(self):
        v = pvol.Volume(ramp())
        self.assertIsInstance(v.density([1, 2, 3]), float)
        self.assertEqual(v.density(np.zeros((4, 5, 3))).shape, (4, 5))
        self.assertEqual(v.density(np.zeros((0, 3))).shape, (0,))
        self.assertEqual(v.density(np.zeros((1, 3))).dtype, np.float32)
        many = np.random.default_rng(2).uniform(0, 20, (3, 7000)).T  # strided, and enough for threads
        np.testing.assert_array_equal(v.density(many), v.density(many.copy()))
        np.testing.assert_array_equal(v.extinction_at(many), v.density(many))


class Facts(unittest.TestCase):
    def test_what_it_says_of_itself(self):
        v = slab(mu=3, n=8, voxel_size=0.5, albedo=(0.9, 0.8, 0.7), name="slab")
        self.assertEqual(v.name, "slab")
        self.assertEqual(v.extinction, 3)
        self.assertEqual(v.interpolation, "trilinear")
        np.testing.assert_allclose(v.albedo, [0.9, 0.8, 0.7], rtol=1e-6)
        np.testing.assert_array_equal(v.support, [[-1] * 3, [8] * 3])
        self.assertEqual(v.shape, (9, 9, 9))
        np.testing.assert_allclose(v.world_box, [[-0.5] * 3, [4] * 3])
        self.assertGreater(v.bytes["samples"], 512 * 4 - 1)
        self.assertIn("slab", repr(v))
        self.assertIsNone(v.shell)

    def test_another_medium(self):
        v = slab(mu=3, albedo=0.5, g=0.2)
        w = v.with_medium(extinction=6)
        self.assertEqual(w.extinction, 6)
        np.testing.assert_allclose(w.albedo, 0.5)
        np.testing.assert_allclose(
            w.optical_depth([-2, 5, 5], [1, 0, 0]), 2 * v.optical_depth([-2, 5, 5], [1, 0, 0])
        )
        np.testing.assert_allclose(v.with_medium(albedo=0.25).albedo, 0.25)
        self.assertEqual(v.with_medium(albedo=0.25).extinction, 3)
        self.assertEqual(v.with_medium(g=None, rayleigh=True).extinction, 3)

    def test_other_options(self):
        v = pvol.Volume(lumps(), extinction=3, name="lumps")
        for depth in range(v.depth + 1):
            w = v.with_options(depth=depth)
            self.assertEqual((w.extinction, w.name), (3, "lumps"))
            self.assertLessEqual(w.depth, depth)
        self.assertEqual(w.depth, v.depth)
        w = v.with_options(depth=0)
        self.assertEqual(w.with_options(depth=None).depth, v.depth)
        self.assertEqual(w.with_medium(extinction=4).depth, w.depth)
        loose = v.with_options(majorant_scale=2)
        np.testing.assert_allclose(loose.bounds()["majorant"].max(), 2 * v.bounds()["majorant"].max())
        at = np.random.default_rng(8).uniform(0, 31, (100, 3))
        np.testing.assert_array_equal(loose.density(at), v.density(at))
        self.assertEqual(v.with_options(interpolation="nearest").interpolation, "nearest")
        with self.assertRaisesRegex(pvol.Error, message("python.bounds_not_for_tricubic")):
            v.with_options(interpolation="tricubic")
        with self.assertRaisesRegex(pvol.Error, message("python.no_option_deep")):
            v.with_options(deep=3)

    def test_files(self):
        with tempfile.TemporaryDirectory() as folder:
            recipe = folder + "/ball.toml"
            with open(recipe, "w", encoding="utf-8") as file:
                file.write('[recipe]\nresolution = 40\nedge = 0.1\n[[form]]\nshape = "ellipsoid"\n'
                           "centre = [0, 0, 0]\nradii = [1, 1, 1]\n")
            v = pvol.load(recipe)
            self.assertEqual(v.name, recipe)
            tau = v.optical_depth([-3, 0, 0], [1, 0, 0])
            self.assertGreater(tau, 20)  # chosen: about 40 on average over columns that hit
            p = pvol.load(recipe, interpolation="procedural", extinction=2.0)
            self.assertEqual(p.interpolation, "procedural")
            self.assertAlmostEqual(float(p.extinction_at([0, 0, 0])), 2, places=5)


class Errors(unittest.TestCase):
    def refused(self, key, make):
        with self.assertRaisesRegex(pvol.Error, message(key)):
            make()

    def test_are_the_librarys(self):
        self.assertTrue(issubclass(pvol.Error, ValueError))
        self.refused("python.sample_nan", lambda: pvol.Volume(self.with_value(np.nan)))
        self.refused("python.sample_negative", lambda: pvol.Volume(self.with_value(-1)))
        self.refused("python.two_axes", lambda: pvol.Volume(np.ones((3, 3))))
        self.refused("python.complex_samples", lambda: pvol.Volume(np.ones((3, 3, 3), complex)))
        masked = np.ma.masked_greater(np.full((3, 3, 3), 5.0), 3)
        self.refused("python.masked_samples", lambda: pvol.Volume(masked))
        self.refused("python.matrix_of_three",
                     lambda: pvol.Volume(np.ones((3, 3, 3)), index_to_world=np.eye(3)))
        self.refused("python.matrix_last_row",
                     lambda: pvol.Volume(np.ones((3, 3, 3)), index_to_world=np.ones((4, 4))))
        self.refused("python.g_above_one", lambda: slab(g=2))
        self.refused("python.no_key_abledo", lambda: slab(abledo=0.5))  # the keys that there are
        self.refused("python.no_interpolation", lambda: slab(interpolation="linear"))
        self.refused("python.voxel_size_and_matrix", lambda: slab(voxel_size=1, index_to_world=np.eye(4)))
        self.refused("python.no_file", lambda: pvol.load("none.vdb"))
        v = slab()
        self.refused("python.point_of_two", lambda: v.density([1, 2]))
        self.refused("python.shapes_do_not_broadcast", lambda: v.flights(np.zeros((4, 3)), np.ones((3, 3))))
        self.refused("python.ray_without_direction",
                     lambda: v.flights(np.zeros((4, 3)), [[1, 0, 0]] * 2 + [[0, 0, 0]] * 2))
        self.refused("python.no_tracker", lambda: v.flights([0, 0, 0], [1, 0, 0], tracker="newton"))
        self.refused("python.no_level", lambda: v.bounds(99))
        self.refused("python.fire_without_field", lambda: slab(fire={"kelvin": 2000}))
        self.refused("python.no_closed_form",
                     lambda: slab(interpolation="tricubic").optical_depth([0, 0, 0], [1, 0, 0]))

    @staticmethod
    def with_value(value):
        a = np.ones((3, 4, 5), np.float32)
        a[1, 2, 0] = value
        return a


class Threads(unittest.TestCase):
    def test_others_run_meanwhile(self):
        v = pvol.Volume(lumps(), extinction=50)
        rng = np.random.default_rng(5)
        origins = rng.uniform(0, 31, (300_000, 3))
        results, turns = [], 0
        thread = threading.Thread(
            target=lambda: results.append(v.flights(origins, [1, 0, 0], seed=3, counts=False)))
        thread.start()
        while thread.is_alive():
            turns += 1  # Python goes on here only where the call lets it
        thread.join()
        self.assertGreater(turns, 0)
        np.testing.assert_array_equal(results[0], v.flights(origins, [1, 0, 0], seed=3))

    def test_many_threads_at_once(self):
        v = pvol.Volume(lumps(), extinction=50)
        origins = np.random.default_rng(6).uniform(0, 31, (20_000, 3))
        expected = v.flights(origins, [0, 1, 0], seed=9)
        results = [None] * 8

        def work(i):
            results[i] = v.flights(origins, [0, 1, 0], seed=9)

        threads = [threading.Thread(target=work, args=(i,)) for i in range(8)]
        [t.start() for t in threads]
        [t.join() for t in threads]
        for r in results:
            np.testing.assert_array_equal(r, expected)


if __name__ == "__main__":
    unittest.main()
