"""Triangles as binary .ply files."""

import numpy as np


def write(path, vertices, triangles):
    """`vertices` is (n, 3), `triangles` (m, 3): indices of vertices."""
    faces = np.empty(len(triangles), dtype=[("corners", "u1"), ("vertices", "<i4", 3)])
    faces["corners"] = 3
    faces["vertices"] = triangles
    header = ("ply\nformat binary_little_endian 1.0\n"
              f"element vertex {len(vertices)}\n"
              "property float x\nproperty float y\nproperty float z\n"
              f"element face {len(faces)}\n"
              "property list uchar int vertex_indices\nend_header\n")
    with open(path, "wb") as file:
        file.write(header.encode("ascii"))
        file.write(np.ascontiguousarray(vertices, dtype="<f4").tobytes())
        file.write(faces.tobytes())
