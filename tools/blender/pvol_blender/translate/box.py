"""Boxes of fog: box-shaped meshes with a volume material, as volumes of one voxel."""

import numpy as np

from . import nodes


def has_surface(material):
    """Whether a material has a surface beside its volume."""
    return nodes.output(material.node_tree, "OUTPUT_MATERIAL", "Surface") is not None


def of_mesh(thing, matter, module, notes):
    """A [[volume]] that fills a mesh, or None."""
    corners = np.empty(len(thing.object.data.vertices) * 3)
    thing.object.data.vertices.foreach_get("co", corners)
    corners = corners.reshape(-1, 3)
    if not is_box(corners):
        notes.add(thing.name, "a volume in a mesh that is not a box",
                  "nothing: make it a volume with the modifier Mesh to Volume")
        return None
    if matter.density.grid is not None:
        notes.add(thing.name, "a density that varies within a mesh", "nothing")
        return None
    if not (thing.object.visible_camera and thing.object.visible_volume_scatter):
        notes.add(thing.name, "a volume that some kinds of rays do not see", "one that all see")
    table = dict(matter.medium)
    if matter.fires:
        table["emission"] = _emission(table, matter.fires, thing, notes)
    if table["extinction"] <= 0:
        return None
    if module is None:  # nothing is rendered
        return {}
    return {"file": module.Volume(np.ones((1, 1, 1), dtype=np.float32), interpolation="nearest",
                                  index_to_world=_box_to_world(corners, thing.matrix),
                                  name=thing.name, **table)}


def is_box(corners):
    """Whether points are the corners of a box along the axes, and all of them are."""
    if len(corners) < 8:
        return False
    lo, hi = corners.min(axis=0), corners.max(axis=0)
    size = hi - lo
    if (size <= 0).any():
        return False
    at_ends = np.minimum(corners - lo, hi - corners) <= 1e-5 * size
    ends = {tuple(row) for row in (corners - lo > size / 2)}
    return bool(at_ends.all()) and len(ends) == 8


def _box_to_world(corners, matrix):
    """What takes the one voxel, a cube of size 1 about the origin, to the box."""
    lo, hi = corners.min(axis=0), corners.max(axis=0)
    to_box = np.diag([*(hi - lo), 1.0])
    to_box[:3, 3] = (lo + hi) / 2
    return np.array(matrix) @ to_box


def _emission(medium, fires, thing, notes):
    """As pvol counts a medium's emission: per unit of absorption."""
    emitted = np.sum([f["intensity"] * np.array(f["color"]) for f in fires], axis=0)
    extinction = medium["extinction"] * np.array(medium.get("extinction_color", [1, 1, 1]))
    absorbed = extinction * (1 - np.array(medium.get("albedo", 0)))
    if (absorbed <= 0).any():
        notes.add(thing.name, "the emission of a box that absorbs nothing", "none")
        return [0.0] * 3
    return [float(e / a) for e, a in zip(emitted, absorbed)]
