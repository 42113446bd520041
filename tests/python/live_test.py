"""Pictures while they are rendered: between passes, and in the background."""

import contextlib
import gc
import threading
import unittest

import numpy as np

import pvol
from clouds import lumps

LONG = 300  # no machine is so slow


def cloud():
    return pvol.Volume(lumps(), extinction=1.0, albedo=0.9)


def finished(live):
    while not live.finished:
        live.wait(live.version, LONG)
    return live.picture()


class OnPass(unittest.TestCase):
    def test_sees_every_pass_and_changes_nothing(self):
        seen = []
        volume = cloud()
        picture = pvol.render(
            volume, size=(24, 16), spp=9, on_pass=lambda p, share: seen.append((share, p))
        )
        shares = [share for share, _ in seen]
        self.assertEqual(shares, sorted(shares))
        self.assertTrue(all(0 < share < 1 for share in shares))
        self.assertTrue((seen[0][1].samples == 1).all(), "the first pass is whole")
        plain = pvol.render(volume, size=(24, 16), spp=9)
        np.testing.assert_array_equal(picture.rgb, plain.rgb)

    def test_false_ends_the_render(self):
        picture = pvol.render(
            cloud(), size=(24, 16), spp=1000, on_pass=lambda p, share: p.samples.mean() < 4
        )
        self.assertLess(picture.samples.mean(), 64)
        self.assertGreaterEqual(picture.samples.min(), 4)
        self.assertIn(" of ", picture.attributes["pvol:samples"])

    def test_what_it_raises_goes_on(self):
        with self.assertRaises(ZeroDivisionError):
            pvol.render(cloud(), size=(24, 16), spp=64, on_pass=lambda p, share: 1 / 0)


class Denoise(unittest.TestCase):
    def test_filters_the_picture(self):
        noisy = pvol.render(cloud(), size=(32, 24), spp=8, aov=["halves"])
        filtered = pvol.render(cloud(), size=(32, 24), spp=8, denoise=True)
        np.testing.assert_array_equal(filtered.aov("noisy"), noisy.rgb)
        self.assertGreater(float(filtered.attributes["pvol:estimated_error"]), 0)
        good = pvol.render(cloud(), size=(32, 24), spp=1024, seed=2)
        error = lambda p: float(((p.rgb - good.rgb) ** 2).mean())
        self.assertLess(error(filtered), error(noisy))

    def test_of_one_sample_is_refused(self):
        with self.assertRaisesRegex(pvol.Error, "spp 2"):
            pvol.render(cloud(), size=(8, 8), spp=1, denoise=True)


class Live(unittest.TestCase):
    def test_ends_in_what_render_makes(self):
        volume = cloud()
        with pvol.Live(volume, size=(24, 16), spp=8) as live:
            one = finished(live)
            np.testing.assert_array_equal(one.rgb, pvol.render(volume, size=(24, 16), spp=8).rgb)
            live.change(volume, size=(24, 16), spp=8, camera={"azimuth": 40})
            two = finished(live)
        other = pvol.render(volume, size=(24, 16), spp=8, camera={"azimuth": 40})
        np.testing.assert_array_equal(two.rgb, other.rgb)
        self.assertEqual(two.attributes["pvol:tracker"], other.attributes["pvol:tracker"])

    def test_is_coarse_at_first(self):
        with pvol.Live(cloud(), size=(1280, 960), spp=1) as live:
            self.assertTrue(live.wait(0, LONG))
            shapes, version = [], 0
            while not shapes or not live.finished:
                live.wait(version, LONG)
                version = live.version
                if live.picture() is not None:
                    shapes.append(live.picture().rgb.shape[1])
        self.assertEqual(shapes, sorted(shapes))

    def test_nothing_of_before_is_shown_as_later(self):
        with pvol.Live(cloud(), size=(16, 12), spp=4) as live:
            finished(live)
            live.change(cloud(), size=(400, 300), spp=100)
            picture = live.picture()
            self.assertTrue(picture is None or picture.rgb.shape != (12, 16, 3))

    def test_tells_errors(self):
        with pvol.Live({"volume": {"file": "absent.vdb"}}) as live:
            while not live.finished:
                live.wait(live.version, LONG)
            self.assertIn("absent.vdb", live.error)
            self.assertIsNone(live.picture())
            live.change(cloud(), size=(8, 8), spp=2)
            finished(live)
            self.assertIsNone(live.error)
        with self.assertRaises(pvol.Error):
            pvol.Live({"volume": {"file": "a.vdb"}, "camera": {"fov": 500}})
        with self.assertRaisesRegex(pvol.Error, "closed"):
            live.change(cloud())

    def test_may_be_dropped_while_it_renders(self):
        live = pvol.Live(cloud(), size=(640, 480), spp=10000)
        live.wait(0, LONG)
        del live
        gc.collect()

    def test_may_be_closed_while_others_wait(self):
        live = pvol.Live(cloud(), size=(64, 48), spp=100000)

        def wait():
            with contextlib.suppress(pvol.Error):  # that it is closed
                live.wait(2**62, 0.2)

        waiting = threading.Thread(target=wait)
        waiting.start()
        live.close()
        waiting.join()

    def test_waits_of_any_length(self):
        with pvol.Live(cloud(), size=(8, 8), spp=2) as live:
            self.assertTrue(live.wait(0, float("inf")))
            for seconds in (0, -1, float("nan")):
                self.assertFalse(live.wait(2**62, seconds))

    def test_filters(self):
        with pvol.Live(cloud(), size=(24, 16), spp=8, denoise=True) as live:
            picture = finished(live)
        self.assertIn("noisy", picture.layers)


if __name__ == "__main__":
    unittest.main()
