"""Renders, comparisons and studies, against closed forms and the tools' own answers."""
import os
import signal
import tempfile
import threading
import time
import unittest
import warnings

import numpy as np

import pvol
from clouds import lumps, slab
from messages import message

SAMPLES = os.environ.get("PVOL_SAMPLES", "samples")
SMALL = dict(size=(32, 24), spp=16)


class Furnace(unittest.TestCase):
    def test_albedo_one_in_constant_light_is_that_light(self):
        v = slab(mu=0.3, albedo=1, g=0.5)
        p = pvol.render(v, environment={"type": "constant", "radiance": 2.0}, **SMALL)
        np.testing.assert_allclose(p.rgb, 2, rtol=1e-4)
        self.assertTrue((p.error < 1e-3).all())

    def test_absorption_is_beer_lambert(self):
        v = slab(mu=0.05, albedo=0)
        p = pvol.render(
            v,
            environment={"type": "constant", "radiance": 1.0},
            camera={"position": [-400, 7.5, 7.5], "target": [0, 7.5, 7.5], "fov": 0.5},
            size=(16, 16),
            spp=256,
        )
        tau = 0.05 * 16
        self.assertLess(abs(p.rgb.mean() / np.exp(-tau) - 1), 0.005)
        self.assertLess(abs(p.alpha.mean() / (1 - np.exp(-tau)) - 1), 0.005)


class Pictures(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.v = pvol.Volume(lumps(), extinction=1.0, albedo=0.9)
        cls.p = pvol.render(cls.v, aov=["depth", "lookups"], **SMALL)

    def test_arrays(self):
        p = self.p
        self.assertEqual(p.rgb.shape, (24, 32, 3))
        self.assertEqual(p.rgb.dtype, np.float32)
        self.assertEqual(p.alpha.shape, (24, 32))
        self.assertEqual(p.aov("depth").shape, (24, 32))
        np.testing.assert_allclose(p.aov("variance"), p.error**2, rtol=1e-4)
        np.testing.assert_array_equal(p.samples, 16)
        self.assertGreater(p.aov("lookups").max(), 0)
        self.assertIn("lookups", p.layers)
        self.assertGreater(p.counts["lookups_path"], 0)
        self.assertEqual(pvol.render(self.v, **SMALL).counts, {})
        self.assertIn("shadow rays", p.plan)
        with self.assertRaisesRegex(pvol.Error, message("python.no_layer")):
            p.aov("albedo")

    def test_errors_are_those_of_repeats(self):
        means = [pvol.render(self.v, seed=s, **SMALL).rgb for s in range(2, 34)]
        predicted = (self.p.error**2).mean()
        self.assertLess(abs(np.var(means, axis=0, ddof=1).mean() / predicted - 1), 0.25)

    def test_files(self):
        with tempfile.TemporaryDirectory() as folder:
            self.p.save(folder + "/p.exr")
            self.p.save(folder + "/p.png", exposure=1, tone_map="filmic")
            self.assertGreater(os.path.getsize(folder + "/p.png"), 100)
            view = pvol.tone_maps()[-1]  # of an OCIO configuration, where pvol has OpenColorIO
            self.p.save(folder + "/v.png", tone_map=view)
            with self.assertRaisesRegex(pvol.Error, "expected srgb"):
                self.p.save(folder + "/p.exr", tone_map="none such")
            self.assertEqual(self.p.color_space, "rec709")
            aces = pvol.render(self.v, color_space="acescg", **SMALL)
            aces.save(folder + "/aces.exr")
            self.assertEqual(pvol.read_picture(folder + "/aces.exr").color_space, "acescg")
            q = pvol.read_picture(folder + "/p.exr")
            np.testing.assert_allclose(q.rgb, self.p.rgb, rtol=1e-6)
            np.testing.assert_allclose(q.error, self.p.error, rtol=1e-3, atol=1e-7)
            np.testing.assert_allclose(q.aov("depth"), self.p.aov("depth"), rtol=1e-6)
            self.assertEqual(q.attributes["pvol:seed"], "1")
            self.assertEqual(set(q.layers), {"samples", "variance", "lookups", "depth"})
            np.testing.assert_allclose(q.aov("lookups"), self.p.aov("lookups"), rtol=1e-6)
            with self.assertRaisesRegex(pvol.Error, "no layer 'transmittance'"):
                q.aov("transmittance")
            self.assertFalse(pvol.compare(folder + "/p.exr", self.p)["verdict"]["bias_detected"])
            with self.assertRaisesRegex(Exception, "exr"):
                self.p.save(folder + "/p.tiff")

    def test_scenes_of_all_kinds_are_one(self):
        scene = os.path.join(SAMPLES, "cumulus.toml")
        from_path = pvol.render(scene, medium={"albedo": 0.8, "extinction": 20}, preview=2, **SMALL)
        as_dict = {"volume": {"file": scene}, "medium": {"albedo": 0.8, "extinction": 20.0},
                   "render": {"size": [32, 24], "spp": 16, "preview": 2}}
        np.testing.assert_array_equal(from_path.rgb, pvol.render(as_dict).rgb)
        loaded = pvol.load(scene, extinction=20, albedo=0.8)
        np.testing.assert_array_equal(
            pvol.render(scene, medium={"albedo": 0.8, "extinction": 20}, **SMALL).rgb,
            pvol.render(loaded, **SMALL).rgb)
        np.testing.assert_array_equal(
            pvol.render({"volume": loaded}, **SMALL).rgb, pvol.render([loaded], **SMALL).rgb)

    def test_lights_of_a_dict(self):
        scene = {"volume": self.v, "environment": {"type": "constant", "radiance": 0.0},
                 "sun": [{"direction": [0, 1, 0], "irradiance": 1.0}, {"direction": [1, 1, 0], "irradiance": 2.0}]}
        both = pvol.render(scene, aov=["lights"], **SMALL)
        np.testing.assert_allclose(
            both.aov("sun_1") + both.aov("sun_2") + both.aov("sky"), both.rgb, rtol=1e-4, atol=1e-6)

    def test_several_volumes_and_instances(self):
        two = {"volume": [self.v, {"file": self.v, "instance": [{"translate": [40, 0, 0]}]}]}
        p = pvol.render(two, **SMALL)
        self.assertGreater((p.alpha > 0.3).mean(), 0.05)
        left, right = p.alpha[:, :16].mean(), p.alpha[:, 16:].mean()
        self.assertGreater(min(left, right), 0.02)

    def test_messages_name_what_was_set(self):
        for says, settings in {"spp": dict(spp=0), "render.ssp": dict(ssp=3), "threads": dict(threads=-1),
                               "with_medium": dict(medium={"g": 0.3}), "camera.fov": dict(camera={"fov": 200})}.items():
            with self.assertRaisesRegex(pvol.Error, says):
                pvol.render(self.v, **{"size": (8, 8), **settings})
        with self.assertRaisesRegex(pvol.Error, "volume"):
            pvol.render({"camera": {"fov": 30}})

    def test_doubts_are_warnings(self):
        away = dict(camera={"position": [900, 0, 0], "target": [1800, 0, 0]})
        with warnings.catch_warnings(record=True) as caught:
            warnings.simplefilter("always")
            pvol.render(self.v, size=(8, 8), spp=1, **away)
        self.assertEqual(len(caught), 1)

    def test_bytes_do_not_hang_on_threads(self):
        one, two = (pvol.render(self.v, threads=n, **SMALL).rgb for n in (1, 2))
        np.testing.assert_array_equal(one, two)


class Interrupts(unittest.TestCase):
    def interrupted(self, work):
        """Presses Ctrl-C while `work` is at it."""
        # Background jobs of shells ignore it from the start.
        before = signal.signal(signal.SIGINT, signal.default_int_handler)
        self.addCleanup(signal.signal, signal.SIGINT, before)
        begun = threading.Event()

        def press():
            begun.wait()
            time.sleep(0.3)
            os.kill(os.getpid(), signal.SIGINT)

        thread = threading.Thread(target=press)
        thread.start()
        with self.assertRaises(KeyboardInterrupt):
            begun.set()
            work()
        thread.join()

    def test_ctrl_c_ends_a_render_of_hours(self):
        v = pvol.Volume(lumps(), extinction=5.0)
        self.interrupted(lambda: pvol.render(v, size=(400, 300), spp=1_000_000))
        self.assertEqual(pvol.render(v, size=(8, 8), spp=1).rgb.shape, (8, 8, 3))  # nothing is stuck

    def test_ctrl_c_ends_a_batch_and_a_study(self):
        v = pvol.Volume(lumps(), extinction=5.0, majorant_scale=1000)
        origins = np.broadcast_to([-5.0, 15.5, 15.5], (3_000_000, 3))  # some 1e5 steps a ray
        self.interrupted(lambda: v.transmittance(origins, [1, 0.01, 0], estimator="analog"))
        w = v.with_options(majorant_scale=None)
        self.interrupted(lambda: pvol.trade(w, budget=3600, size=(24, 18)))


class Studies(unittest.TestCase):
    def test_equal_laws_are_not_told_apart_and_others_are(self):
        v = pvol.Volume(lumps(), extinction=1.0, albedo=0.9)
        a = pvol.render(v, seed=1, size=(32, 24), spp=64)
        b = pvol.render(v, seed=2, size=(32, 24), spp=64, tracker="delta")
        c = pvol.render(v.with_medium(albedo=0.8), seed=3, size=(32, 24), spp=64)
        same, other = pvol.compare(a, b), pvol.compare(a, c)
        self.assertFalse(same["verdict"]["bias_detected"])
        self.assertTrue(other["verdict"]["bias_detected"])
        difference = (a.rgb.astype(float) - b.rgb).mean(axis=(0, 1))
        luminance = difference @ [0.2126, 0.7152, 0.0722]
        self.assertAlmostEqual(same["luminance"]["bias"], luminance, places=6)

    def test_trade(self):
        v = pvol.Volume(lumps(), extinction=1.0, albedo=0.9)
        rows = pvol.trade(v, [{"depth": 0}, {"tracker": "delta", "depth": 1}, {"max_bounces": 0}],
                          budget=600, most_samples=8, size=(12, 9))
        self.assertEqual([r["setting"] for r in rows],
                         ["default", "--depth 0", "--tracker delta --depth 1", "--max-bounces 0"])
        for r in rows[:3]:
            self.assertNotIn("left_out", r)
            self.assertFalse(r["biased_by_design"] or r["bias"]["detected"])
        self.assertTrue(rows[3]["biased_by_design"] and rows[3]["bias"]["detected"])
        self.assertEqual(rows[0]["time"]["value"], 1)
        with self.assertRaisesRegex(pvol.Error, message("python.no_option_depht")):
            pvol.trade(v, [{"depht": 0}], size=(8, 8))


if __name__ == "__main__":
    unittest.main()
