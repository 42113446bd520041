"""Numbers that vary through a volume: chains of nodes that begin at a grid, as maps of its values.

pvol maps a value v to ramp(clamp(scale v + offset) ^ power). Nodes whose steps come in this order
can be mapped; a factor may follow, which goes into the extinction or the intensity."""

from dataclasses import dataclass, replace

import numpy as np

from . import nodes

_LEAST, _MOST = -1e30, 1e30
_INFO = {"Density": "density", "Flame": "flame", "Temperature": "temperature", "Color": "color"}
STEP = [[0, 0], [1e-4, 1]]  # a ramp that is 1 wherever there is anything


@dataclass(frozen=True)
class Field:
    grid: str | None = None  # None: a constant, the factor
    factor: float = 1.0  # last of all
    scale: float = 1.0
    offset: float = 0.0
    clamp: tuple | None = None
    power: float = 1.0
    ramp: tuple = ()
    smooth: bool = False

    @property
    def is_plain(self):
        """Whether it is the grid's value, but for a factor."""
        return self.offset == 0 and self.clamp is None and self.power == 1 and not self.ramp

    @property
    def _affine(self):
        return self.clamp is None and self.power == 1 and not self.ramp

    def times(self, k):
        if self.grid is None or not self._affine:
            return replace(self, factor=self.factor * k)
        return replace(self, scale=self.scale * k, offset=self.offset * k)

    def plus(self, k):
        if self.grid is None:
            return replace(self, factor=self.factor + k)
        return replace(self, offset=self.offset + k) if self._affine else None

    def clamped(self, lo, hi):
        if self.grid is None:
            return replace(self, factor=min(max(self.factor, lo), hi))
        if self.factor != 1 or self.power != 1 or self.ramp:
            return None
        old_lo, old_hi = self.clamp or (_LEAST, _MOST)
        return replace(self, clamp=(min(max(old_lo, lo), hi), max(min(old_hi, hi), lo)))

    def to_the(self, power):
        if self.grid is None:
            return replace(self, factor=max(self.factor, 0.0) ** power)
        if self.factor != 1 or self.ramp or power <= 0:
            return None
        return replace(self, power=self.power * power)

    def ramped(self, points, smooth):
        if self.grid is None or self.factor != 1 or self.ramp:
            return None
        return replace(self, ramp=tuple(map(tuple, points)), smooth=smooth)

    def at(self, value):
        """What a value of the grid becomes."""
        v = self.scale * value + self.offset
        if self.clamp:
            v = min(max(v, self.clamp[0]), self.clamp[1])
        if self.power != 1:
            v = max(v, 0.0) ** self.power
        if self.ramp:
            v = float(np.interp(v, *zip(*self.ramp)))
        return self.factor * v

    def split(self):
        """The factor, and the keys of the map behind it."""
        if self.is_plain:
            return self.factor * self.scale, {}
        table = {"scale": self.scale, "offset": self.offset, "power": self.power,
                 "clamp": list(self.clamp) if self.clamp else None,
                 "ramp": [list(p) for p in self.ramp] or None, "smooth": self.smooth or None}
        plain = {"scale": 1.0, "offset": 0.0, "power": 1.0}
        return self.factor, {k: v for k, v in table.items()
                             if v is not None and v != plain.get(k)}


def of_socket(socket):
    """The field that feeds an input of a node; None where the nodes cannot be mapped."""
    fed = nodes.source(socket)
    if fed is None:
        constant = socket.default_value
        if hasattr(constant, "__len__"):
            constant = sum(list(constant)[:3]) / 3
        return Field(factor=constant)
    node, output = fed
    kinds = {"VALUE": _value, "ATTRIBUTE": _attribute, "VOLUME_INFO": _volume_info, "MATH": _math,
             "VALTORGB": _color_ramp, "MAP_RANGE": _map_range, "CLAMP": _clamp}
    return kinds[node.type](node, output) if node.type in kinds else None


def _value(node, output):
    return Field(factor=output.default_value)


def _attribute(node, output):
    if output.name == "Alpha" or node.attribute_type != "GEOMETRY" or not node.attribute_name:
        return None
    return Field(grid=node.attribute_name)


def _volume_info(node, output):
    return Field(grid=_INFO[output.name])


def _math(node, output):
    a, b = of_socket(node.inputs[0]), of_socket(node.inputs[1])
    if a is None or b is None:
        return None
    swapped = a.grid is None and b.grid is not None
    if swapped and node.operation not in ("MULTIPLY", "ADD", "MAXIMUM", "MINIMUM", "SUBTRACT"):
        return None
    if swapped:
        a, b = b, a
    if b.grid is not None:
        return None
    result = _operation(a, node.operation, b.factor, swapped)
    return result.clamped(0, 1) if result is not None and node.use_clamp else result


def _operation(a, operation, k, swapped):
    if operation == "MULTIPLY":
        return a.times(k)
    if operation == "DIVIDE":
        return a.times(1 / k) if k else None
    if operation == "ADD":
        return a.plus(k)
    if operation == "SUBTRACT":
        return a.times(-1).plus(k) if swapped and a._affine else a.plus(-k)
    if operation == "POWER":
        return a.to_the(k)
    if operation == "MAXIMUM":
        return a.clamped(k, _MOST)
    if operation == "MINIMUM":
        return a.clamped(_LEAST, k)
    return None


def _clamp(node, output):
    inner = of_socket(node.inputs["Value"])
    lo, hi = (nodes.value(node, name) for name in ("Min", "Max"))
    linked = node.inputs["Min"].is_linked or node.inputs["Max"].is_linked
    return None if inner is None or linked else inner.clamped(min(lo, hi), max(lo, hi))


def _map_range(node, output):
    inner = of_socket(node.inputs["Value"])
    names = ("From Min", "From Max", "To Min", "To Max")
    if inner is None or node.interpolation_type != "LINEAR" or getattr(
            node, "data_type", "FLOAT") != "FLOAT" or any(node.inputs[n].is_linked for n in names):
        return None
    low, high, to_low, to_high = (nodes.value(node, n) for n in names)
    if low == high or not inner._affine:
        return None
    slope = (to_high - to_low) / (high - low)
    result = inner.times(slope).plus(to_low - slope * low)
    if node.clamp:
        result = result.clamped(min(to_low, to_high), max(to_low, to_high))
    return result


def _color_ramp(node, output):
    inner = of_socket(node.inputs["Fac"])
    if inner is None or output.name == "Alpha":
        return None
    points = [[p, _grey(c)] for p, c in ramp_points(node.color_ramp)]
    return inner.ramped(points, node.color_ramp.interpolation in ("EASE", "B_SPLINE", "CARDINAL"))


def _grey(c):
    return 0.2126 * c[0] + 0.7152 * c[1] + 0.0722 * c[2]


def ramp_points(ramp):
    """Position and colour of the points between which pvol interpolates."""
    elements = [(e.position, list(e.color)[:3]) for e in ramp.elements]
    if ramp.interpolation != "CONSTANT":
        return _ascending(elements)
    points = [elements[0]]
    for (_, before), (position, color) in zip(elements, elements[1:]):
        points += [(position - 1e-4, before), (position, color)]
    return _ascending(points)


def _ascending(points):
    """The points a little apart where several are at one place, or would be in another order."""
    apart = [points[0]]
    for position, color in points[1:]:
        apart.append((max(position, apart[-1][0] + 1e-6), color))
    return apart
