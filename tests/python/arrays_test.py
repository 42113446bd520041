"""Arrays that nobody would choose: random shapes, types, strides, byte orders and values. Each is taken as NumPy
itself reads it, or refused with an exception that says why."""
import unittest
import warnings

import numpy as np

import pvol

TYPES = ["f4", "f8", "f2", ">f4", ">f8", "i1", "u2", ">i4", "u8", "?", "f16", "c8", "O", "U3", "V4", "M8[s]"]
VALUES = [0, 0.5, 1, 3, 1e30, 65504, -1, -0.0, np.nan, np.inf, 1e39, 1e-45]
REFUSALS = (pvol.Error, ValueError, TypeError)


def any_array(random):
    """An array of few samples, of which most are good and some are not."""
    shape = random.integers(0, 9, random.choice([3, 3, 3, 3, 3, 3, 2, 4, 1, 0]))
    values = random.choice(VALUES[:4], shape)
    for _ in range(random.choice([0, 0, 1, 2]) if values.size else 0):
        values.flat[random.integers(values.size)] = random.choice(VALUES)
    with np.errstate(all="ignore"):
        array = values.astype(random.choice(TYPES[:10], p=[0.3, 0.2] + [0.0625] * 8) if random.random() < 0.9
                              else random.choice(TYPES))
    for axis in range(array.ndim):
        how = random.integers(5)
        if how == 0:
            array = np.flip(array, axis)
        elif how == 1:
            array = np.repeat(array, 2, axis)[(slice(None),) * axis + (slice(None, None, 2),)]
        elif how == 2 and array.shape[axis] == 1:
            array = np.broadcast_to(array, array.shape[:axis] + (4,) + array.shape[axis + 1:])
    if random.integers(3) == 0:
        array = array.transpose(random.permutation(array.ndim))
    return array


def samples_of(array):
    """The samples as doubles; None where they are no density."""
    if array.ndim != 3 or array.size == 0 or array.dtype.kind not in "fiu":
        return None
    with np.errstate(all="ignore"):
        samples = array.astype(np.float32)
    return samples if np.isfinite(samples).all() and (samples >= 0).all() else None


class AnyArray(unittest.TestCase):
    def test_is_read_as_numpy_reads_it_or_refused(self):
        taken = refused = 0
        for seed in range(1000):
            random = np.random.default_rng(seed)
            array = any_array(random)
            samples = samples_of(array)
            try:
                with np.errstate(all="ignore"):
                    volume = pvol.Volume(array)
            except REFUSALS as e:
                refused += 1
                self.assertGreater(len(str(e)), 20, seed)
                if samples is not None and array.dtype.itemsize <= 8:
                    empty_or_thick = not samples.any() or samples.max() > 1e12
                    self.assertTrue(empty_or_thick, f"{seed}: {array.dtype} {array.shape} is refused: {e}")
                continue
            taken += 1
            self.assertIsNotNone(samples, f"{seed}: {array.dtype} {array.shape} is taken")
            points = np.argwhere(np.ones(array.shape)).astype(float)
            np.testing.assert_allclose(volume.density(points), samples.reshape(-1), rtol=2e-7,
                                       err_msg=str(seed))
        self.assertGreater(taken, 200)
        self.assertGreater(refused, 200)

    def test_rays_of_any_arrays_are_answered_or_refused(self):
        volume = pvol.Volume(np.ones((8, 8, 8), np.float32))
        answered = 0
        for seed in range(1000):
            random = np.random.default_rng(seed)
            origins, directions, lengths = (any_array(random) for _ in range(3))
            if random.integers(2) == 0:  # shapes that fit together
                n = random.integers(1, 6)
                origins, directions = (random.choice(VALUES, (n, 3)) for _ in range(2))
                lengths = random.choice(VALUES, random.choice([n, 1]))
            try:
                with np.errstate(all="ignore"), warnings.catch_warnings():
                    warnings.simplefilter("error", np.ComplexWarning)  # of parts that NumPy leaves out
                    t = volume.flights(origins, directions, lengths, seed=seed)
            except REFUSALS as e:
                self.assertGreater(len(str(e)), 20, seed)
                continue
            answered += 1
            self.assertTrue((t >= 0).all(), f"{seed}: {t}")
        self.assertGreater(answered, 25)


if __name__ == "__main__":
    unittest.main()
