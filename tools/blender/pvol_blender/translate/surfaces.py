"""Meshes, and all else that has faces, as surfaces that scatter light evenly."""

import os

import numpy as np

from . import camera, motion, nodes

_KINDS = {"MESH", "CURVE", "SURFACE", "FONT", "META"}
_LEFT_OUT = {"CURVES": "hair curves", "POINTCLOUD": "a point cloud", "GPENCIL": "grease pencil",
             "GREASEPENCIL": "grease pencil"}


def tables(thing, translation):
    """The [[mesh]] tables of a thing: one for each of its materials, none if it has no faces."""
    if thing.object.type in _LEFT_OUT:
        translation.notes.add(thing.name, _LEFT_OUT[thing.object.type], "nothing")
    if thing.object.type not in _KINDS:
        return []
    shared = visibility(thing, translation)
    if shared is None:
        return []
    if abs(thing.matrix.to_3x3().determinant()) < 1e-30:
        translation.notes.add(thing.name, "an object that is scaled to nothing", "nothing")
        return []
    place = {"matrix": camera.rows(thing.matrix)}
    later = translation.later.get(thing.key)
    if motion.moved(thing.matrix, later):
        place["to"] = {"matrix": camera.rows(later)}
    found = []
    for slot, vertices, triangles in _parts(thing.object):
        slots = thing.object.material_slots
        material = slots[min(slot, len(slots) - 1)].material if slots else None
        if (layer := translation.view_layer) is not None and layer.material_override:
            material = layer.material_override
        path = translation.files.mesh(thing.object, slot, vertices, triangles)
        found.append({"file": os.fspath(path), **place, **shared,
                      "albedo": translation.albedo(material, thing.name)})
    return found


def _parts(thing):
    """Slot, vertices and triangles for each material that has faces."""
    mesh = thing.to_mesh()
    try:
        mesh.calc_loop_triangles()
        count = len(mesh.loop_triangles)
        vertices = np.empty(len(mesh.vertices) * 3, dtype=np.float32)
        triangles = np.empty(count * 3, dtype=np.int32)
        slots = np.empty(count, dtype=np.int32)
        mesh.vertices.foreach_get("co", vertices)
        mesh.loop_triangles.foreach_get("vertices", triangles)
        mesh.loop_triangles.foreach_get("material_index", slots)
    finally:
        thing.to_mesh_clear()
    vertices, triangles = vertices.reshape(-1, 3), triangles.reshape(-1, 3)
    return [(int(s), vertices, triangles[slots == s]) for s in np.unique(slots)]


def visibility(thing, translation):
    """`look` and the kinds of rays that meet a surface, as far as they are not the usual ones; None
    if none do."""
    layer, owner, notes = translation.view_layer, thing.owner, translation.notes
    seen, shadow = thing.object.visible_camera, thing.object.visible_shadow
    light = thing.object.visible_volume_scatter
    if layer is not None and owner.indirect_only_get(view_layer=layer):
        seen = False
    if thing.object.visible_diffuse != light:
        notes.add(thing.name, "ray visibility that differs for diffuse and volume scattering",
                  "that of volume scattering for both")
    table = {}
    if thing.object.is_holdout or (layer is not None and owner.holdout_get(view_layer=layer)):
        table["look"] = "holdout"
    elif thing.object.is_shadow_catcher:
        table["look"] = "shadow-catcher"
    rays = {"visible_camera": seen, "visible_shadow": shadow, "visible_light": light}
    if not any(rays.values()):
        return None
    return {**table, **{name: on for name, on in rays.items() if not on}}


def albedo(material, notes, name):
    """The colour of a material's diffuse part; what else it does is noted, of the object `name`."""
    if material is None:
        return [0.8] * 3
    if not material.use_nodes or material.node_tree is None:
        return _clipped(list(material.diffuse_color)[:3])
    node = nodes.output(material.node_tree, "OUTPUT_MATERIAL", "Surface")
    if node is None:
        return [0.0] * 3
    name = f"{name}, material {material.name}"
    color_of = {"BSDF_PRINCIPLED": "Base Color", "BSDF_DIFFUSE": "Color"}.get(node.type)
    if color_of is None:
        return _other(name, node, notes)
    color, plain = nodes.color(node, color_of)
    if not plain:
        notes.add(name, f"a texture or nodes at {color_of}", "the colour of the socket")
    if node.type == "BSDF_PRINCIPLED":
        _check_principled(name, node, notes)
    return _clipped(color)


def _clipped(color):
    return [min(max(float(c), 0.0), 1.0) for c in color]


def _other(name, node, notes):
    socket = node.inputs.get("Color")
    color = _clipped(nodes.value(node, "Color")) if socket is not None else [0.5] * 3
    if node.type == "EMISSION":
        color = [0.0] * 3
    notes.add(name, f"a {node.bl_label} surface",
              "black, without light of its own" if node.type == "EMISSION" else
              "a diffuse surface of its colour" if socket is not None else "a diffuse grey")
    return color


def _check_principled(name, node, notes):
    """Names what a Principled BSDF does beside scattering evenly, if it shows."""
    def above(least, *names):
        return any(n in node.inputs and (node.inputs[n].is_linked or
                                         nodes.value(node, n) > least) for n in names)

    gloss = "Roughness" in node.inputs and not node.inputs["Roughness"].is_linked and nodes.value(
        node, "Roughness") < 0.3
    if above(0.01, "Metallic") or gloss:
        notes.add(name, "a glossy or metallic surface", "a diffuse one of its colour")
    if above(0.01, "Transmission", "Transmission Weight"):
        notes.add(name, "a transparent surface", "an opaque one")
    alpha = node.inputs.get("Alpha")
    if alpha is not None and (alpha.is_linked or alpha.default_value < 0.99):
        notes.add(name, "the alpha of a surface", "an opaque one")
    emits = node.inputs.get("Emission Strength")
    color = "Emission Color" if "Emission Color" in node.inputs else "Emission"
    if emits is not None and emits.default_value > 0 and any(
            c > 0 for c in nodes.color(node, color)[0]):
        notes.add(name, "a surface that emits", "one that does not")
