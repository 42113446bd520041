"""What leads rays through a cloud: bounds level by level, segments of one ray, and a shell.

    PYTHONPATH=build/release/python python3 samples/python/bounds_and_shells.py --out out/shell.obj
"""

import argparse
import pathlib

import numpy as np

import pvol

CLOUD = pathlib.Path(__file__).parent.parent / "cumulus.toml"


def volume_of(vertices: np.ndarray, faces: np.ndarray) -> float:
    a, b, c = (vertices[faces[:, k]] for k in range(3))
    return float(np.einsum("ij,ij->i", a, np.cross(b, c)).sum() / 6)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--cloud", default=str(CLOUD))
    parser.add_argument("--perturbations", type=int, default=8)
    parser.add_argument("--resolution", type=int, default=64, help="of the shell's mesh")
    parser.add_argument("--out", default="", help="an .obj for the shell")
    args = parser.parse_args()

    cloud = pvol.load(args.cloud)
    print(cloud)

    # The pyramid: each level's cubes with the least and greatest extinction in them.
    cell = abs(np.linalg.det(cloud.index_to_world[:3, :3]))
    for level in range(cloud.levels):
        nodes = cloud.bounds(level)
        volume = nodes["edge"].astype(float) ** 3 * cell
        print(
            f"level {level}: {len(nodes):6d} cubes of {nodes['edge'][0]:4d} cells, "
            f"mean majorant {np.average(nodes['majorant'], weights=volume):7.3f}, "
            f"minorant {np.average(nodes['minorant'], weights=volume):7.3f}"
        )

    # Where walks stop, and a ray through it: bounds hold everywhere along it.
    terminals = cloud.bounds()
    print(f"walks stop at {len(terminals)} cubes, of {np.unique(terminals['edge'])} cells")
    lo, hi = cloud.world_box
    origin, direction = np.array([lo[0] - 1, *((lo + hi) / 2)[1:]]), np.array([1.0, 0, 0])
    pieces = cloud.segments(origin, direction)
    inside = pieces["t0"] + (pieces["t1"] - pieces["t0"]) * np.linspace(0.01, 0.99, 33)[:, None]
    mu = cloud.extinction_at(origin + inside[..., None] * direction)
    assert (mu <= pieces["hi"] * (1 + 1e-6)).all() and (mu >= pieces["lo"] * (1 - 1e-6)).all()
    print(f"a ray of {len(pieces)} segments: mean majorant {pieces['hi'].mean():.2f}, "
          f"mean extinction {mu.mean():.2f}")

    # A shell: some quadrics that hold all of it.
    shell = pvol.fit_shell(cloud, perturbations=args.perturbations)
    print(f"{shell.kind} shell of {len(shell.quadrics)} quadrics: {shell.tightness}")
    rng = np.random.default_rng(1)
    points = rng.uniform(lo, hi, (20_000, 3))
    occupied = cloud.density(points) > 0
    assert shell.contains(points[occupied]).all(), "the shell cuts the cloud"
    targets = rng.uniform(lo, hi, (20_000, 3))
    start = points + 3 * (points - targets)
    spans = shell.intersect(start, targets - points)
    hit_shell = np.zeros(len(points), bool)
    hit_shell[spans["ray"]] = True
    hit_cloud = cloud.optical_depth(start, targets - points) > 0
    assert not (hit_cloud & ~hit_shell).any(), "a ray meets the cloud outside its shell"
    print(f"of rays through the box {hit_cloud.mean():.3f} meet the cloud, "
          f"{hit_shell.mean():.3f} its shell")

    vertices, faces = shell.mesh(args.resolution)
    print(f"its mesh: {len(faces)} triangles, volume {volume_of(vertices, faces):.4f} of the box's "
          f"{np.prod(hi - lo):.4f}")
    if args.out:
        with open(args.out, "w", encoding="utf-8") as file:
            file.writelines(f"v {x:.7g} {y:.7g} {z:.7g}\n" for x, y, z in vertices)
            file.writelines(f"f {a} {b} {c}\n" for a, b, c in faces + 1)
        print("wrote", args.out)


if __name__ == "__main__":
    main()
