"""Light that volumes emit, as fires of pvol: radiance per world unit."""

import math

from . import nodes
from .blackbody import blackbody_color
from .fields import STEP, Field, ramp_points

# Radiance per unit of length and K^4 of a black body of Blender's: Stefan and Boltzmann's constant
# over pi, in millionths.
_STEFAN_BOLTZMANN = 5.670373e-8 * 1e-6 / math.pi


def _fire(strength, density, intensity, color):
    """A fire as strong as a field, or even wherever there is density."""
    if strength.grid is None:
        table = {"field": density.grid or "", "ramp": STEP}
        return {**table, "intensity": intensity * strength.factor, "color": color}
    factor, table = strength.split()
    return {"field": strength.grid, **table, "intensity": intensity * factor, "color": color}


def principled(node, reader, density):
    """The fires of a Principled Volume: at most one of its emission and one of its black body."""
    fires = emission(node, "Emission Color", "Emission Strength", reader, density)
    blackbody = reader.field(node, "Blackbody Intensity")
    if blackbody.grid is not None or blackbody.factor > 1e-3:
        fires += _black_body(node, reader, blackbody, density)
    return fires


def emission(node, color_socket, strength_socket, reader, density=Field(grid=None)):
    strength = reader.field(node, strength_socket)
    if strength.grid is None and strength.factor <= 0:
        return []
    color, colors = _color(node, color_socket, reader)
    return [{**_fire(strength, density, 1.0, color), **colors}]


def _color(node, socket, reader):
    """A constant, or the keys of colours along a grid."""
    fed = nodes.source(node.inputs[socket])
    if fed is not None and fed[0].type == "VALTORGB":
        along = reader.of(fed[0].inputs["Fac"])
        if along is not None and along.grid and along.is_plain:
            scale = along.scale * along.factor
            points = [[p / scale, *c] for p, c in ramp_points(fed[0].color_ramp)]
            return [1.0] * 3, {"color_by": along.grid, "colors": points}
    if fed is not None and fed[0].type == "BLACKBODY":
        along = reader.of(fed[0].inputs["Temperature"])
        if along is not None and along.grid and along.is_plain:
            return [1.0] * 3, {"color_by": along.grid, "kelvin": along.scale * along.factor}
    color, grid = reader.color(node, socket)
    if grid:
        reader.notes.add(reader.name, f"an emission coloured by the grid {grid}", "white")
    return color, {}


def _black_body(node, reader, strength, density):
    kelvin = max(reader.number(node, "Temperature"), 0.0)
    tint, _ = reader.color(node, "Blackbody Tint")
    heat = reader.known(nodes.value(node, "Temperature Attribute", ""))
    intensity = _STEFAN_BOLTZMANN * kelvin**4
    if intensity <= 0:
        return []
    if not heat:  # as hot everywhere
        color = [t * c for t, c in zip(tint, blackbody_color(kelvin))]
        return [_fire(strength, density, intensity, color)]
    colors = {"color_by": heat, "kelvin": kelvin}
    if strength.grid is None:
        table = {"field": heat, "power": 4.0, "intensity": intensity * strength.factor}
        return [{**table, "color": tint, **colors}]
    return [{**_fire(strength, density, intensity, tint), **colors, "kelvin_of_intensity": kelvin}]
