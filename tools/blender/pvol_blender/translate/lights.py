"""Lamps. The factors between Blender's watts and pvol's radiances are those of Cycles, and the
tests compare pictures of both."""

import math
import re
import zlib

from . import nodes
from .blackbody import blackbody_color

# Names that pvol's pictures have for something else.
_TAKEN = {
    "r", "g", "b", "a", "x", "y", "z", "depth", "nearest", "position", "normal", "albedo",
    "velocity", "transmittance", "transmittance_rgb", "variance", "samples", "lookups", "bounds_tests",
    "segments", "collisions", "unscattered", "single", "multiple", "half_1", "half_2", "sky",
    "emission", "noisy", "noisy_variance", "lights", "scattering", "halves", "objects", "sums", "picture",
    "rgba", "cryptoobject",
}
_LONGEST = 57  # of Blender's 63, with "Light " before it


def group_of(lamp):
    """The layer that a lamp's light goes to: its light group, else one of its own name."""
    own = getattr(lamp, "lightgroup", "") or lamp.name
    # Letters of other alphabets by their numbers, so that names stay apart.
    name = re.sub(r"[^A-Za-z0-9_]", lambda m: "_" if ord(m[0]) < 128 else f"u{ord(m[0]):x}", own)
    if name.lower() in _TAKEN:
        name += "_light"
    if len(name) > _LONGEST:
        name = f"{name[:_LONGEST - 9]}_{zlib.crc32(own.encode()):08x}"
    return name


def of_object(lamp, matrix, notes):
    """A lamp as the name of its section and its keys; None if it shines nowhere."""
    kinds = {"SUN": _sun, "POINT": _point, "SPOT": _spot, "AREA": _area}
    power = _power(lamp, notes)
    if not any(c > 0 for c in power) or _own(lamp, "is_portal", False):
        return None
    if min(axis.length for axis in matrix.to_3x3().col) < 1e-12 or (
            lamp.data.type == "AREA" and min(_sides(lamp.data)) <= 0):
        notes.add(lamp.name, "a lamp that is scaled to nothing", "nothing")
        return None
    _check(lamp, notes)
    kind, table = kinds[lamp.data.type](lamp, matrix, power, notes)
    table["group"] = group_of(lamp)
    return kind, table


def _own(lamp, name, default):
    """A property of Cycles' part of a lamp, where there is one."""
    return getattr(getattr(lamp.data, "cycles", None), name, default)


def _check(lamp, notes):
    if not (_own(lamp, "cast_shadow", True) and lamp.data.use_shadow):
        notes.add(lamp.name, "a lamp without shadows", "one with shadows")
    if not (lamp.visible_diffuse and lamp.visible_volume_scatter):
        notes.add(lamp.name, "a lamp that some kinds of rays do not see", "one that all see")
    linking = getattr(lamp, "light_linking", None)
    if linking and (linking.receiver_collection or linking.blocker_collection):
        notes.add(lamp.name, "light linking", "a lamp that shines on everything")


def _power(lamp, notes):
    """Watts by channel; of a sun watts per square metre."""
    data = lamp.data
    strength = data.energy * 2 ** getattr(data, "exposure", 0)
    color = [strength * c for c in data.color]
    if getattr(data, "use_temperature", False):
        color = [c * t for c, t in zip(color, blackbody_color(data.temperature))]
    if data.use_nodes and data.node_tree:
        color = [c * f for c, f in zip(color, _emission(lamp, notes))]
    if min(color) < 0:
        notes.add(lamp.name, "a lamp that takes light away", "none where it does")
    return [max(0.0, c) for c in color]


def _emission(lamp, notes):
    """The factor of a lamp's nodes."""
    node = nodes.output(lamp.data.node_tree, "OUTPUT_LIGHT", "Surface")
    if node is None:
        return [0, 0, 0]
    if node.type != "EMISSION":
        notes.add(lamp.name, "nodes of the lamp", "its colour and power alone")
        return [1, 1, 1]
    color, plain = nodes.color(node, "Color")
    strength, even = nodes.number(node, "Strength")
    falloff = nodes.source(node.inputs["Strength"])
    if falloff and falloff[0].type == "LIGHT_FALLOFF" and falloff[1].name == "Quadratic":
        strength, even = nodes.number(falloff[0], "Strength")  # the light's own, unless smooth
        even = even and not nodes.value(falloff[0], "Smooth")
    if not (plain and even):
        notes.add(lamp.name, "textures, falloff or IES profiles of the lamp", "an even lamp")
        color = color if plain else [1, 1, 1]
        strength = strength if even else 1
    return [strength * c for c in color]


def _back(matrix):
    """Where a lamp's light comes from: lamps shine along their -z."""
    return list(matrix.to_3x3().col[2].normalized())


def _sun(lamp, matrix, power, notes):
    angle = math.degrees(lamp.data.angle)
    return "sun", {"direction": _back(matrix), "irradiance": power,
                   "angle": 0 if angle < 0.01 else min(angle, 179.9)}


def _intensity(power):
    """Of a lamp that radiates its power evenly in all directions."""
    return [p / (4 * math.pi) for p in power]


def _visibility(lamp):
    """New lamps of Blender are hidden from the camera."""
    return {} if lamp.visible_camera else {"visible_camera": False}


def _point(lamp, matrix, power, notes):
    table = {"position": list(matrix.translation), "intensity": _intensity(power)}
    if lamp.data.shadow_soft_size > 0:
        table.update(radius=lamp.data.shadow_soft_size, **_visibility(lamp))
    return "point", table


def _spot(lamp, matrix, power, notes):
    data = lamp.data
    if data.shadow_soft_size > 0:
        notes.add(lamp.name, "the radius of a spot lamp", "a point, whose shadows are sharp")
    return "spot", {
        "position": list(matrix.translation),
        "direction": [-x for x in _back(matrix)],
        "intensity": _intensity(power),
        "angle": math.degrees(data.spot_size),
        "blend": spot_blend(data.spot_size, data.spot_blend),
    }


def spot_blend(angle, blend):
    """The share of the angle over which a spot fades: Blender's is one of 1 - cosine."""
    rim = math.cos(angle / 2)
    full = math.acos(min(1.0, rim + (1 - rim) * blend))
    return min(max(1 - full / (angle / 2), 0.0), 1.0)


def _sides(data):
    return data.size, data.size_y if data.shape in ("RECTANGLE", "ELLIPSE") else data.size


def _area(lamp, matrix, power, notes):
    data = lamp.data
    axes = matrix.to_3x3()
    width, height = (side * axes.col[i].length for i, side in enumerate(_sides(data)))
    if data.shape in ("DISK", "ELLIPSE"):
        notes.add(lamp.name, f"an area lamp that is a {data.shape.lower()}",
                  "a rectangle of the same area")
        width, height = (side * math.sqrt(math.pi / 4) for side in (width, height))
    if getattr(data, "spread", math.pi) < math.pi - 1e-3:
        notes.add(lamp.name, "the spread of an area lamp", "one that shines to all of its front")
    return "area", {
        "position": list(matrix.translation),
        "direction": [-x for x in _back(matrix)],
        "up": list(axes.col[1].normalized()),
        "size": [width, height],
        **_visibility(lamp),
        # Over the area and a factor of 4, not pi: Cycles measures the watts of area lamps so.
        "radiance": [p / (4 * width * height) for p in power],
    }
