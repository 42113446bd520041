"""Bounds bound, segments follow them, and shells hold their cloud."""
import unittest

import numpy as np

import pvol
from clouds import lumps
from messages import message


class Bounds(unittest.TestCase):
    def setUp(self):
        self.samples = lumps()
        self.v = pvol.Volume(self.samples, extinction=3.0, voxel_size=0.25)
        rng = np.random.default_rng(3)
        lo, hi = self.v.support
        self.points = rng.uniform(lo, hi, (20_000, 3))  # in index space
        self.mu = self.v.extinction_at(0.25 * self.points)

    def check(self, rows):
        """Every point in one cube at most, within its bounds; outside of cubes nothing."""
        found = np.zeros(len(self.points), int)
        for row in rows:
            inside = ((self.points >= row["lo"]) & (self.points < row["lo"] + row["edge"])).all(axis=1)
            found += inside
            self.assertTrue((self.mu[inside] <= row["majorant"] * (1 + 1e-6)).all())
            self.assertTrue((self.mu[inside] >= row["minorant"] * (1 - 1e-6)).all())
        self.assertLessEqual(found.max(), 1)
        self.assertEqual(self.mu[found == 0].sum(), 0)

    def test_of_all_levels(self):
        for level in range(self.v.levels):
            rows = self.v.bounds(level)
            self.assertTrue((rows["edge"] == 8 << level).all())
            self.check(rows)
        self.assertEqual(len(self.v.bounds(self.v.levels - 1)), 1)

    def test_of_terminals(self):
        self.check(self.v.bounds())
        root = 8 << (self.v.levels - 1)
        for depth in range(self.v.depth + 1):
            v = pvol.Volume(self.samples, extinction=3.0, voxel_size=0.25, depth=depth)
            rows = v.bounds()
            self.check(rows)
            self.assertLessEqual(v.depth, depth)
            self.assertEqual(rows["edge"].min(), root >> v.depth)

    def test_of_a_depth_given_back(self):
        for extinction in [0.1, 3.0, 100.0]:
            v = pvol.Volume(self.samples, extinction=extinction, voxel_size=0.25)
            for limit in [v.depth, 23]:
                again = v.with_options(depth=limit)
                self.assertEqual(again.depth, v.depth)
                np.testing.assert_array_equal(again.bounds(), v.bounds())

    def test_segments(self):
        origin, direction = np.array([-3.0, 3.1, 4.2]), np.array([3.0, 0.4, -0.2])
        rows = self.v.segments(origin, direction)
        self.assertGreater(len(rows), 2)
        self.assertTrue((rows["t0"][1:] >= rows["t1"][:-1] - 1e-9).all())
        unit = direction / np.linalg.norm(direction)
        for row in rows:
            t = np.linspace(row["t0"], row["t1"], 20)[1:-1]
            mu = self.v.extinction_at(origin + t[:, None] * unit)
            self.assertTrue((mu <= row["hi"] * (1 + 1e-5)).all() and (mu >= row["lo"] * (1 - 1e-5)).all())
        between = self.v.segments(origin, direction, t_max=rows["t0"][1])
        self.assertLessEqual(between["t1"].max(), rows["t0"][1])
        self.assertEqual(len(self.v.segments([0, 99, 0], direction)), 0)

    def test_a_volume_of_nothing(self):
        v = pvol.Volume(np.zeros((4, 4, 4)))
        self.assertEqual(len(v.bounds()), 0)
        self.assertEqual(v.levels, 0)
        self.assertEqual(v.flights([0, 0, 0], [1, 0, 0]), np.inf)
        self.assertEqual(v.transmittance([0, 0, 0], [1, 0, 0]), 1)
        self.assertEqual(v.density([1, 1, 1]), 0)


class Shells(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        m = np.array([[0.1, 0, 0.02, 3], [0, -0.1, 0, 1], [0, 0, 0.1, -2], [0, 0, 0, 1]])  # mirrored
        cls.v = pvol.Volume(lumps(), index_to_world=m, extinction=8)
        cls.shells = {kind: pvol.fit_shell(cls.v, kind=kind, perturbations=4) for kind in ("hard", "soft")}
        rng = np.random.default_rng(4)
        lo, hi = cls.v.world_box
        cls.points = rng.uniform(lo - 0.5, hi + 0.5, (30_000, 3))

    def test_hold_the_cloud(self):
        for kind, s in self.shells.items():
            with self.subTest(kind):
                self.assertEqual(s.kind, kind)
                self.assertEqual(s.quadrics.shape, (1 + len(s.strengths), 10))
                self.assertGreaterEqual(s.certificate["bound"], s.certificate["margin"])
                inside = s.contains(self.points)
                self.assertTrue(inside[self.v.density(self.points) > 0].all())
                self.assertFalse(inside.all())

    def test_quadrics_and_frame_are_those_of_the_base(self):
        s = pvol.fit_shell(self.v, perturbations=0)
        p = self.points @ s.world_to_frame[:3, :3].T + s.world_to_frame[:3, 3]
        x, y, z = p.T
        terms = np.stack([x * x, y * y, z * z, y * z, z * x, x * y, x, y, z, np.ones_like(x)])
        value = s.quadrics[0] @ terms
        to_index = np.linalg.inv(self.v.index_to_world)
        index = self.points @ to_index[:3, :3].T + to_index[:3, 3]
        lo, hi = self.v.support
        in_box = ((index >= lo) & (index <= hi)).all(axis=1)
        far = abs(value) > 1e-9
        np.testing.assert_array_equal(s.contains(self.points)[far], ((value >= 0) & in_box)[far])

    def test_spans_are_where_rays_are_inside(self):
        rng = np.random.default_rng(5)
        origins, directions = self.points[:400], rng.normal(size=(400, 3))
        for s in self.shells.values():
            rows = s.intersect(origins, directions, 10)
            t = rng.uniform(0, 10, 400)
            unit = directions / np.linalg.norm(directions, axis=1, keepdims=True)
            inside = s.contains(origins + t[:, None] * unit)
            within = np.zeros(400, bool)
            hits = (rows["t0"] <= t[rows["ray"]]) & (t[rows["ray"]] <= rows["t1"])
            within[rows["ray"][hits]] = True
            self.assertTrue(within[inside].all())
            self.assertLess((within & ~inside).mean(), 0.02)

    def test_mesh_is_closed_and_its_front_outside(self):
        s = self.shells["soft"]
        vertices, faces = s.mesh(48)
        a, b, c = (vertices[faces[:, k]] for k in range(3))
        volume = np.einsum("ij,ij->i", a, np.cross(b, c)).sum() / 6
        share = s.contains(self.points).mean() * np.prod(np.ptp(self.v.world_box, axis=0) + 1)
        self.assertLess(abs(volume / share - 1), 0.05)

    def test_renders_take_them(self):
        v = self.v.with_shell(self.shells["hard"])
        self.assertEqual(v.shell.kind, "hard")
        self.assertIsNone(v.with_shell(None).shell)
        same = dict(size=(24, 18), spp=4, seed=5)
        np.testing.assert_array_equal(pvol.render(v, shells="on", **same).rgb, pvol.render(v, shells="off", **same).rgb)
        other = pvol.Volume(np.ones((40, 40, 40)), index_to_world=v.index_to_world)
        with self.assertRaisesRegex(pvol.Error, message("python.shell_without_cloud")):
            pvol.render(other.with_shell(v.shell), **same)


if __name__ == "__main__":
    unittest.main()
