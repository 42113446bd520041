"""Estimators of transmittance against the exact one: bias, variance, and variance times cost.

    PYTHONPATH=build/release/python python3 samples/python/transmittance.py
"""

import argparse

import numpy as np

import pvol


def cloudlets(n: int) -> np.ndarray:
    """Balls of smoke with soft edges in a thin haze, which gives minorants something to do."""
    x, y, z = np.meshgrid(*[np.linspace(-1, 1, n)] * 3, indexing="ij")
    density = np.full((n, n, n), 0.05)
    for centre, radius in [((-0.3, 0, 0), 0.45), ((0.4, 0.2, 0.1), 0.35), ((0.1, -0.5, -0.2), 0.3)]:
        r = np.sqrt((x - centre[0]) ** 2 + (y - centre[1]) ** 2 + (z - centre[2]) ** 2)
        density += np.clip(1.5 * (1 - r / radius), 0, 1)
    return density


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--rays", type=int, default=256, help="different rays")
    parser.add_argument("--repeats", type=int, default=1024, help="estimates of each")
    parser.add_argument("--voxels", type=int, default=64)
    args = parser.parse_args()

    density = cloudlets(args.voxels)
    rng = np.random.default_rng(3)
    for extinction in (2.0, 10.0):
        volume = pvol.Volume(density, voxel_size=2 / (args.voxels - 1), extinction=extinction)
        lo, hi = volume.world_box
        origins = np.column_stack(
            [np.full(args.rays, lo[0] - 0.1), *rng.uniform(lo[1:], hi[1:], (args.rays, 2)).T]
        )
        direction = np.array([1.0, 0.0, 0.0])
        exact = volume.transmittance(origins, direction, estimator="exact")
        assert np.allclose(exact, np.exp(-volume.optical_depth(origins, direction)))
        print(f"extinction {extinction:g}: mean transmittance {exact.mean():.5f}")

        # Each ray so many times: an axis more, which broadcasting repeats without a copy.
        print("  estimator   bias / error   variance   look-ups   variance x look-ups")
        for estimator in ("ratio", "residual", "analog"):
            estimates, work = volume.transmittance(
                np.broadcast_to(origins, (args.repeats, args.rays, 3)),
                direction,
                estimator=estimator,
                seed=int(extinction),
                counts=True,
            )
            variance = estimates.var(axis=0, ddof=1).mean()
            error = np.sqrt(variance / (args.rays * args.repeats))
            z = (estimates.mean() - exact.mean()) / error
            lookups = work["lookups"].mean()
            print(
                f"  {estimator:10s} {z:12.2f}   {variance:10.2e} {lookups:9.2f} "
                f"{variance * lookups:14.2e}"
            )
            assert abs(z) < 5, f"{estimator} is biased"


if __name__ == "__main__":
    main()
