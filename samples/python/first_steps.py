"""An array becomes a volume, and the volume a picture.

    PYTHONPATH=build/release/python python3 samples/python/first_steps.py --out out/first.png
"""

import argparse

import numpy as np

import pvol


def smoke_ring(n: int) -> np.ndarray:
    """A torus of smoke with some waves on it: any array of densities will do."""
    x, y, z = np.meshgrid(*[np.linspace(-1, 1, n)] * 3, indexing="ij")
    around = np.arctan2(z, x)
    radius = 0.62 + 0.05 * np.sin(5 * around)
    tube = np.hypot(np.hypot(x, z) - radius, y + 0.06 * np.cos(3 * around))
    return np.clip(1.4 - tube / 0.2, 0, 1).astype(np.float32) ** 2


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--size", type=int, default=320, help="width of the picture")
    parser.add_argument("--spp", type=int, default=128)
    parser.add_argument("--voxels", type=int, default=96, help="along an edge")
    parser.add_argument("--out", default="first_steps.png")
    args = parser.parse_args()

    # Sample (i, j, k) is density[i, j, k]; the map of columns (i, j, k, 1) puts it into the world.
    density = smoke_ring(args.voxels)
    edge = 2 / (args.voxels - 1)
    to_world = np.diag([edge, edge, edge, 1.0])
    to_world[:3, 3] = -1
    ring = pvol.Volume(
        density, index_to_world=to_world, extinction=30, albedo=(0.98, 0.95, 0.9), g=0.3, name="ring"
    )
    print(ring)
    print("world box", ring.world_box.tolist(), "bytes", ring.bytes)

    # The density at any point, and what it does to a ray.
    print("density at the tube and in the hole:", ring.density([[0.62, 0, 0], [0, 0, 0]]))
    print("transmittance across:", ring.transmittance([-3, 0, 0], [1, 0, 0], estimator="exact"))

    # A picture: options and sections are called as in scene files.
    height = args.size * 3 // 4
    picture = pvol.render(
        ring, size=(args.size, height), spp=args.spp, camera={"elevation": 35}, count=True
    )
    print(picture)
    print(picture.plan)
    work = picture.counts["lookups_path"] + picture.counts["lookups_shadow"]
    print(f"look-ups a sample: {work / picture.samples.sum():.2f}")

    # The same smoke, darker: only the medium changes.
    soot = pvol.render(
        ring.with_medium(albedo=0.4), size=(args.size, height), spp=args.spp, camera={"elevation": 35}
    )
    print("mean radiance", picture.rgb.mean(), "and of soot", soot.rgb.mean())
    assert soot.rgb.mean() < picture.rgb.mean()
    picture.save(args.out)
    print("wrote", args.out)


if __name__ == "__main__":
    main()
