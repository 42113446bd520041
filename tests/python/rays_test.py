"""Rays against closed forms, and estimators against each other."""
import unittest

import numpy as np

import pvol
from clouds import lumps, slab
from messages import message

N = 400_000
TRACKERS = ["delta", "decomposition", "weighted-delta", "weighted-decomposition", "regular"]


def rays_through(volume, count, seed=1):
    rng = np.random.default_rng(seed)
    lo, hi = volume.world_box
    target = rng.uniform(lo, hi, (count, 3))
    d = rng.normal(size=(count, 3))
    d /= np.linalg.norm(d, axis=1, keepdims=True)
    return target - 2 * np.linalg.norm(hi - lo) * d, d


class Slab(unittest.TestCase):
    """Samples of 1 at 0..15: mu is constant from 0 to 15, and ramps to 0 within a cell at either
    side: optical depth mu (15 + 2 / 2)."""

    def test_beer_lambert(self):
        v = slab(mu=0.05)
        tau = 0.05 * 16
        self.assertAlmostEqual(v.optical_depth([-9, 5, 5], [1, 0, 0]), tau, places=6)
        self.assertAlmostEqual(v.transmittance([-9, 5, 5], [1, 0, 0], estimator="exact"), np.exp(-tau), places=6)
        origins = np.broadcast_to([-9.0, 5.0, 5.0], (N, 3))
        t = v.flights(origins, [1, 0, 0], seed=11)
        passed = np.isinf(t).mean()
        self.assertLess(abs(passed / np.exp(-tau) - 1), 0.005)
        for estimator in ("ratio", "analog", "residual"):
            T = v.transmittance(origins, [1, 0, 0], seed=12, estimator=estimator)
            self.assertLess(abs(T.mean() / np.exp(-tau) - 1), 0.005, estimator)

    def test_flights_are_exponential_for_every_tracker(self):
        v = slab(mu=0.4)
        origins = np.broadcast_to([2.0, 7.0, 7.0], (N, 3))
        for seed, tracker in enumerate(TRACKERS):
            with self.subTest(tracker):
                t = v.flights(origins, [0, 0, 1], t_max=8, seed=seed, tracker=tracker)
                hit = np.isfinite(t)
                self.assertLess(abs(hit.mean() / (1 - np.exp(-3.2)) - 1), 0.005)
                # Kolmogorov's distance to the exponential law, of those that hit.
                u = np.sort((1 - np.exp(-0.4 * t[hit])) / (1 - np.exp(-3.2)))
                grid = np.arange(1, u.size + 1) / u.size
                self.assertLess(np.abs(u - grid).max(), 2.0 / np.sqrt(u.size))
                self.assertLessEqual(t[hit].max(), 8)

    def test_limits(self):
        v = slab(mu=0.1)
        for t_max in (0.0, 3.0, 12.5):
            want = 0.1 * max(0, t_max - 5) if t_max <= 5 + 15 else None
            self.assertAlmostEqual(v.optical_depth([-5, 5, 5], [2, 0, 0], t_max),
                                   want + (0.05 if t_max > 5 else 0.0), places=6)
        limits = np.linspace(6, 20, 8)
        np.testing.assert_allclose(
            v.optical_depth([-5, 5, 5], [1, 0, 0], limits), 0.1 * (limits - 5) + 0.05, rtol=1e-6)


class Estimators(unittest.TestCase):
    def test_agree_with_the_exact_one_on_a_field(self):
        v = pvol.Volume(lumps(), extinction=0.2)
        origins, directions = rays_through(v, N)
        exact = v.transmittance(origins, directions, estimator="exact")
        self.assertTrue(0.1 < exact.mean() < 0.9)
        for seed, estimator in enumerate(["ratio", "analog", "residual-ratio", "auto"]):
            with self.subTest(estimator):
                difference = v.transmittance(origins, directions, seed=seed, estimator=estimator) - exact
                sigma = difference.std() / np.sqrt(N)
                self.assertLess(sigma, 0.002 * exact.mean())
                self.assertLess(abs(difference.mean()), 4.5 * sigma)

    def test_fields_of_every_interpolation(self):
        for interpolation in ("nearest", "trilinear", "tricubic"):
            with self.subTest(interpolation):
                v = pvol.Volume(lumps(), extinction=0.2, interpolation=interpolation)
                origins, directions = rays_through(v, 200_000)
                T = v.transmittance(origins, directions, seed=4)
                passed = np.isinf(v.flights(origins, directions, seed=5))
                sigma = np.sqrt((T.var() + passed.var()) / T.size)
                self.assertLess(abs(T.mean() - passed.mean()), 4.5 * sigma)
                # By the density itself, along some of the rays.
                steps = np.linspace(0, 1, 4001)[:, None, None]
                length = 4 * np.linalg.norm(v.world_box[1] - v.world_box[0])
                some = slice(0, 64)
                mu = v.extinction_at(origins[some] + steps * length * directions[some])
                tau = mu.mean(axis=0) * length
                again = v.transmittance(np.broadcast_to(origins[some], (4000, 64, 3)), directions[some], seed=6)
                error = again.std(axis=0) / np.sqrt(4000)
                self.assertTrue((abs(again.mean(axis=0) - np.exp(-tau)) < 5 * error + 0.004).all())

    def test_counts_are_those_of_a_known_case(self):
        # One terminal with the ramp, whose minorant is 0; nothing but look-ups decides.
        v = slab(mu=0.5, depth=0, micro_bounds="none")
        origins = np.broadcast_to([-4.0, 7.0, 7.0], (1000, 3))
        t, work = v.flights(origins, [1, 0, 0], counts=True, tracker="delta")
        self.assertEqual(set(work), {"lookups", "bounds_tests", "segments", "null_collisions"})
        hits = np.isfinite(t)
        np.testing.assert_array_equal(work["lookups"], work["null_collisions"] + hits)
        np.testing.assert_array_equal(work["segments"], 1)
        np.testing.assert_array_equal(work["bounds_tests"], 0)
        _, cells = v.optical_depth([-4, 7.5, 7.5], [1, 0, 0], counts=True)
        self.assertEqual(int(cells["lookups"]), 17)
        _, missed = v.flights([-4, 90, 7], [1, 0, 0], counts=True)
        self.assertEqual(int(missed["segments"]), 0)

    def test_results_follow_from_seed_and_number(self):
        v = pvol.Volume(lumps(), extinction=5)
        origins, directions = rays_through(v, 30_000)
        t = v.flights(origins, directions, seed=1)
        np.testing.assert_array_equal(t, v.flights(origins, directions, seed=1))
        np.testing.assert_array_equal(t[:100], v.flights(origins[:100], directions[:100], seed=1))
        self.assertTrue((t != v.flights(origins, directions, seed=2)).any())
        np.testing.assert_array_equal(t, v.flights(origins, 4 * directions, seed=1))
        counted, _ = v.flights(origins, directions, seed=1, counts=True)
        np.testing.assert_array_equal(v.flights(origins, directions, seed=1, kernel="scalar"), counted)
        with self.assertRaisesRegex(pvol.Error, message("python.no_kernel")):
            v.flights(origins, directions, kernel="sse")

    def test_one_at_a_time_and_many_at_once_agree(self):
        v = pvol.Volume(lumps(), extinction=5)
        origins, directions = rays_through(v, 200_000)
        for values in (lambda k: np.isinf(v.flights(origins, directions, seed=3, kernel=k)).astype(float),
                       lambda k: v.transmittance(origins, directions, seed=4, kernel=k),
                       lambda k: v.transmittance(origins, directions, seed=5, estimator="analog", kernel=k)):
            difference = values("auto") - values("scalar")
            self.assertLess(abs(difference.mean()), 4.5 * difference.std() / len(difference) ** 0.5)
            self.assertGreater(difference.std(), 0)
        bad = np.array(origins)
        bad[777, 1] = np.nan
        with self.assertRaisesRegex(pvol.Error, "ray 777: "):
            v.flights(bad, directions)

    def test_shapes(self):
        v = slab()
        self.assertIsInstance(v.flights([0, 0, 0], [1, 0, 0]), float)
        self.assertEqual(v.flights(np.zeros((5, 1, 3)), np.ones((4, 3))).shape, (5, 4))
        self.assertEqual(v.flights([0, 0, 0], [1, 0, 0], t_max=np.ones(7)).shape, (7,))
        self.assertEqual(v.transmittance(np.zeros((0, 3)), [1, 0, 0]).shape, (0,))
        T, work = v.transmittance(np.zeros((2, 3, 3)), [1, 0, 0], counts=True)
        self.assertEqual(work["lookups"].shape, T.shape)
        strided = np.zeros((6, 8, 3))[::2, ::3]
        self.assertEqual(v.flights(strided, np.asfortranarray(strided + 1)).shape, (3, 3))


if __name__ == "__main__":
    unittest.main()
