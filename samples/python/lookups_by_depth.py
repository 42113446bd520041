"""Why walks stop where they do: look-ups and segments against the depth of the octree.

With one box around everything (depth 0) most tentative collisions are null and cost a look-up each;
deeper, bounds get tighter and look-ups fewer, but a ray crosses more of them. Walks stop at the
depth if not above, where that costs least; without a depth nothing limits them. The flights follow
the same law at every depth.

    PYTHONPATH=build/release/python python3 samples/python/lookups_by_depth.py --out out/depth.png
"""

import argparse
import pathlib

import numpy as np

import pvol

CLOUD = pathlib.Path(__file__).parent.parent / "cumulus.toml"


def rays_across(volume: pvol.Volume, count: int, seed: int) -> tuple[np.ndarray, np.ndarray]:
    """Isotropic lines through the volume's bounding ball."""
    rng = np.random.default_rng(seed)
    lo, hi = volume.world_box
    centre, radius = (lo + hi) / 2, np.linalg.norm(hi - lo) / 2
    ends = rng.normal(size=(2, count, 3))
    ends *= radius / np.linalg.norm(ends, axis=2, keepdims=True)
    return centre + ends[0], ends[1] - ends[0]


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--rays", type=int, default=200_000)
    parser.add_argument("--cloud", default=str(CLOUD))
    parser.add_argument("--out", default="lookups_by_depth.png")
    args = parser.parse_args()

    chosen = pvol.load(args.cloud)
    origins, directions = rays_across(chosen, args.rays, seed=1)
    depths = list(range(chosen.depth + 1))
    figures: dict[str, list[float]] = {"look-ups": [], "segments": [], "null collisions": []}
    hits = []
    for depth in [*depths, None]:
        volume = chosen.with_options(depth=depth)
        t, work = volume.flights(origins, directions, seed=volume.depth, tracker="delta", counts=True)
        hits.append(np.isfinite(t).mean())
        means = {
            "look-ups": work["lookups"].mean(),
            "segments": work["segments"].mean(),
            "null collisions": work["null_collisions"].mean(),
        }
        limit = f"depth {depth}" if depth is not None else f"chosen by cost: depth {volume.depth}"
        print(
            f"{limit}: {means['look-ups']:7.2f} look-ups, "
            f"{means['segments']:6.2f} segments a flight, {hits[-1]:.4f} collide"
        )
        if depth is not None:
            for name, mean in means.items():
                figures[name].append(mean)
    assert all(means[name] == figures[name][-1] for name in means), "the chosen depth has other bounds"
    # One law: shares of flights that collide differ by noise alone.
    noise = np.sqrt(0.5 / args.rays)
    assert np.ptp(hits) < 6 * noise, "depth changed the law of free flights"

    import matplotlib

    matplotlib.use("Agg")
    from matplotlib import pyplot

    figure, axes = pyplot.subplots(figsize=(6.4, 4), layout="constrained")
    for name, values in figures.items():
        axes.plot(depths, values, marker="o", label=name)
    axes.set(
        xlabel="deepest octree level at which walks stop; the last is chosen by cost",
        ylabel="a flight (delta tracking)",
    )
    axes.set_yscale("log")
    axes.set_xticks(depths)
    axes.legend()
    figure.savefig(args.out, dpi=120)
    print("wrote", args.out)


if __name__ == "__main__":
    main()
