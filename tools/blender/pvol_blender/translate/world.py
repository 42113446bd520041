"""The world: a constant, a picture of the sky, or clear air."""

import math
import os

from . import nodes

# Blender's sky has sunlight of this irradiance above the air, in its own unit: measured as the
# factor that makes the suns of both programs equal at 40 and 80 degrees.
SKY_IRRADIANCE = 158.0


def of_world(world, files, notes):
    """The [environment] of a world."""
    if world is None:
        return _constant([0, 0, 0])
    if not _seen(world):
        notes.add(world.name, "a world that the camera does not see", "one that it sees")
    if not world.use_nodes or world.node_tree is None:
        return _constant(world.color)
    if nodes.output(world.node_tree, "OUTPUT_WORLD", "Volume") is not None:
        notes.add(world.name, "a volume that fills the world", "none: use a box with the volume")
    node = nodes.output(world.node_tree, "OUTPUT_WORLD", "Surface")
    if node is None:
        return _constant([0, 0, 0])
    if node.type not in ("BACKGROUND", "EMISSION"):
        notes.add(world.name, f"a {node.bl_label} node at the world's output", "black")
        return _constant([0, 0, 0])
    return _background(world, node, files, notes)


def _seen(world):
    """By the camera: a setting of Cycles, whose owner changed."""
    owner = getattr(world, "cycles_visibility", world)
    return getattr(owner, "camera", getattr(owner, "visible_camera", True))


def _background(world, node, files, notes):
    strength, even = nodes.number(node, "Strength")
    if not even:
        notes.add(world.name, "a strength that is not a number", f"{strength:g}")
    fed = nodes.source(node.inputs["Color"])
    kinds = {"TEX_ENVIRONMENT": _image, "TEX_SKY": _sky}
    if fed is not None and fed[0].type in kinds:
        return kinds[fed[0].type](world, fed[0], strength, files, notes)
    color, plain = nodes.color(node, "Color")
    if not plain:
        notes.add(world.name, f"a {fed[0].bl_label} node as colour of the world",
                  "the colour of the socket")
    return _constant([strength * c for c in color])


def _constant(radiance):
    return {"type": "constant", "radiance": [max(0.0, float(r)) for r in radiance]}


def _turn(world, node, notes):
    """Degrees by which a Mapping node turns the sky about z."""
    fed = nodes.source(node.inputs["Vector"])
    turn = 0.0
    if fed is not None and fed[0].type == "MAPPING":
        turn = _mapping(world, fed[0], notes)
        fed = nodes.source(fed[0].inputs["Vector"])
    if fed is not None and (fed[0].type != "TEX_COORD" or fed[1].name != "Generated"):
        notes.add(world.name, "texture coordinates of the sky", "those of the world")
    return turn


def _mapping(world, node, notes):
    turn, shift, scale = (nodes.value(node, name) for name in ("Rotation", "Location", "Scale"))
    linked = any(i.is_linked for i in node.inputs if i.name != "Vector")
    askew = abs(turn[0]) + abs(turn[1]) > 1e-6
    moved = any(abs(x) > 1e-6 for x in shift) and node.vector_type != "VECTOR"
    scaled = any(abs(x - 1) > 1e-6 for x in scale)
    if linked or askew or moved or scaled:
        notes.add(world.name, "a Mapping node that does more than turn about z",
                  "its rotation about z alone")
    back = node.vector_type == "TEXTURE"
    return math.degrees(-turn[2] if back else turn[2])


def _image(world, node, strength, files, notes):
    if node.image is None:
        return _constant([strength, 0, strength])  # what Blender shows of a missing picture
    if node.projection != "EQUIRECTANGULAR":
        notes.add(world.name, "a mirror ball as picture of the sky", "the picture in latitude and "
                  "longitude")
    file = files.picture(node.image)
    if file is None:
        notes.add(world.name, f"the picture {node.image.name}, which cannot be read", "black")
        return _constant([0, 0, 0])
    # pvol's skies are turned by half a turn against Blender's.
    turn = _within_a_turn(180 + _turn(world, node, notes))
    return {"type": "image", "file": os.fspath(file), "scale": max(0.0, strength),
            "rotation": turn}


def _sky(world, node, strength, files, notes):
    table = {"type": "clear", "ground": 0.0}
    if node.sky_type in ("PREETHAM", "HOSEK_WILKIE"):
        x, y, z = node.sun_direction
        table.update(elevation=math.degrees(math.atan2(z, math.hypot(x, y))),
                     azimuth=_within_a_turn(math.degrees(math.atan2(x, y)) -
                                            _turn(world, node, notes)),
                     turbidity=max(1.0, node.turbidity),
                     sun=False, irradiance=4 * max(0.0, strength))
        notes.add(world.name, f"a sky of {node.sky_type.replace('_', ' and ').title()}",
                  "pvol's clear sky with the same sun and turbidity; its brightness differs")
        return table
    _check_sun(world, node, notes)
    haze = getattr(node, "aerosol_density", getattr(node, "dust_density", 1.0))
    if node.ozone_density > 1000 / 300:
        notes.add(world.name, "more ozone than 1000 Dobson units", "1000")
    air = node.air_density
    if abs(air - 1) > 1e-3 or getattr(node, "altitude", 0) > 0.5:
        notes.add(world.name, "air of another density or at an altitude", "air at sea level")
    azimuth = math.degrees(node.sun_rotation) - _turn(world, node, notes)
    table.update(
        elevation=min(max(math.degrees(node.sun_elevation), -90.0), 90.0),
        azimuth=_within_a_turn(azimuth),
        turbidity=min(1 + 0.5 * haze, 20.0),
        ozone=min(300.0 * node.ozone_density, 1000.0),
        irradiance=SKY_IRRADIANCE * max(0.0, strength),
        sun=bool(node.sun_disc),
    )
    return table


def _within_a_turn(degrees):
    return (degrees + 180) % 360 - 180


def _check_sun(world, node, notes):
    if not node.sun_disc:
        return
    if abs(node.sun_intensity - 1) > 1e-3:
        notes.add(world.name, "the intensity of the sky's sun", "1")
    if abs(math.degrees(node.sun_size) - 0.545) > 0.02:
        notes.add(world.name, "the size of the sky's sun", "0.53 degrees")
