"""A path tracer of one's own, on arrays: free flights from pvol, everything else in NumPy.

All paths take a step at a time: pvol says where they collide, NumPy scatters them by
Henyey-Greenstein until they leave for a sky of constant light. The picture is the one that
pvol.render makes of the same scene, within noise, which is checked.

    PYTHONPATH=build/release/python python3 samples/python/own_path_tracer.py --out out/own.png
"""

import argparse

import numpy as np

import pvol

ALBEDO, G, SKY = 0.8, 0.6, 1.0


def density_of(n: int) -> np.ndarray:
    """A lumpy ball."""
    x, y, z = np.meshgrid(*[np.linspace(-1, 1, n)] * 3, indexing="ij")
    lumps = 0.12 * np.sin(5 * x) * np.sin(6 * y + 1) * np.sin(5 * z + 2)
    return np.clip(4 * (0.75 + lumps - np.sqrt(x * x + y * y + z * z)), 0, 1)


def scatter(directions: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    """New directions by Henyey-Greenstein, sampled exactly."""
    n = len(directions)
    term = (1 - G * G) / (1 - G + 2 * G * rng.random(n))
    cosine = (1 + G * G - term * term) / (2 * G)
    sine, angle = np.sqrt(np.maximum(0, 1 - cosine**2)), 2 * np.pi * rng.random(n)
    # Two axes across each direction (Duff et al. Building an Orthonormal Basis, Revisited. 2017).
    x, y, z = directions.T
    sign = np.copysign(1.0, z)
    a = -1 / (sign + z)
    b = x * y * a
    u = np.column_stack([1 + sign * x * x * a, sign * b, -sign * x])
    v = np.column_stack([b, sign + y * y * a, -y])
    across = np.cos(angle)[:, None] * u + np.sin(angle)[:, None] * v
    return cosine[:, None] * directions + sine[:, None] * across


def trace(
    volume: pvol.Volume, origins: np.ndarray, directions: np.ndarray, seed: int
) -> tuple[np.ndarray, int]:
    """Radiance along each ray, and how many flights that took."""
    rng = np.random.default_rng(seed)
    light = np.zeros(len(origins))
    path = np.arange(len(origins))  # numbers of those that go on
    throughput = np.ones(len(origins))
    flights = 0
    while path.size:
        t = volume.flights(origins, directions, seed=(seed << 20) + flights)
        flights += 1
        leaves = np.isinf(t)
        light[path[leaves]] += throughput[leaves] * SKY
        # The others scatter, or are absorbed in proportion: weights stay 1.
        goes_on = ~leaves & (rng.random(path.size) < ALBEDO)
        path, throughput = path[goes_on], throughput[goes_on]
        origins = origins[goes_on] + t[goes_on, None] * directions[goes_on]
        directions = scatter(directions[goes_on], rng)
    return light, flights


def camera_rays(
    width: int, height: int, rng: np.random.Generator, distance: float, fov: float
) -> tuple[np.ndarray, np.ndarray]:
    """A sample anywhere in each pixel of a camera on +z that looks at the origin."""
    y, x = np.mgrid[:height, :width] + rng.random((2, height, width))
    half = np.tan(np.radians(fov) / 2)  # half the height
    right = (2 * x - width) / height * half
    up = (height - 2 * y) / height * half
    directions = np.stack([right, up, -np.ones_like(x)], axis=-1).reshape(-1, 3)
    directions /= np.linalg.norm(directions, axis=1, keepdims=True)
    return np.broadcast_to([0.0, 0.0, distance], directions.shape), directions


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--size", type=int, default=96, help="width of the picture")
    parser.add_argument("--spp", type=int, default=64)
    parser.add_argument("--voxels", type=int, default=64)
    parser.add_argument("--out", default="", help="a .npy, or a .png by matplotlib")
    args = parser.parse_args()

    edge = 2 / (args.voxels - 1)
    to_world = np.diag([edge, edge, edge, 1.0])
    to_world[:3, 3] = -1
    volume = pvol.Volume(
        density_of(args.voxels), index_to_world=to_world, extinction=12, albedo=ALBEDO, g=G
    )
    width, height = args.size, args.size * 3 // 4
    distance, fov = 4.0, 32.0

    rng = np.random.default_rng(7)
    total = np.zeros((2, width * height))  # of radiance and of its square
    for sample in range(args.spp):
        light, steps = trace(volume, *camera_rays(width, height, rng, distance, fov), seed=sample + 1)
        total += light, light**2
    own = total[0] / args.spp
    own_variance = (total[1] / args.spp - own**2) / (args.spp - 1)
    print(f"{width} x {height} pixels, {args.spp} samples each, the last in {steps} steps")

    picture = pvol.render(
        volume,
        size=(width, height),
        spp=args.spp,
        filter="box",
        environment={"type": "constant", "radiance": SKY},
        camera={"position": [0, 0, distance], "target": [0, 0, 0], "fov": fov},
    )
    theirs, their_error = picture.rgb[..., 1].ravel(), picture.error[..., 1].ravel()
    difference = own.mean() - theirs.mean()
    sigma = np.sqrt(own_variance.sum() + (their_error.astype(float) ** 2).sum()) / own.size
    print(f"means {own.mean():.5f} and {theirs.mean():.5f}: {difference / sigma:+.2f} standard errors")
    assert abs(difference) < 4 * sigma, "the two tracers differ"
    covered = picture.alpha.ravel() > 0.5
    local = (own - theirs)[covered].mean()
    local_sigma = np.sqrt((own_variance + their_error.astype(float) ** 2)[covered].sum()) / covered.sum()
    print(f"where the cloud is: {local / local_sigma:+.2f} standard errors")
    assert abs(local) < 4 * local_sigma, "the two tracers differ where the cloud is"

    if args.out.endswith(".npy"):
        np.save(args.out, own.reshape(height, width))
    elif args.out:
        import matplotlib

        matplotlib.use("Agg")
        from matplotlib import pyplot

        both = np.hstack([own.reshape(height, width), picture.rgb[..., 1]])
        pyplot.imsave(args.out, np.clip(both, 0, 1) ** (1 / 2.2), cmap="gray", vmin=0, vmax=1)
    if args.out:
        print("wrote", args.out)


if __name__ == "__main__":
    main()
