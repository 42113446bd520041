"""Volume materials: extinction, albedo, anisotropy and emission as the nodes have them."""

import math
from dataclasses import dataclass, field, replace
from typing import Any

from . import fire, nodes
from .fields import Field, of_socket


@dataclass
class Matter:
    """What fills a volume, without its place."""

    density: Field = field(default_factory=lambda: Field(factor=0))  # its factor is in the medium
    medium: dict[str, Any] = field(default_factory=dict)
    fires: list[dict[str, Any]] = field(default_factory=list)
    color_grid: str = ""

    @property
    def grid(self):
        """The grid of the density; "none" where nothing but a fire is there."""
        return self.density.grid if self.medium["extinction"] > 0 else "none"


@dataclass
class Term:
    """A closure that scatters and absorbs."""

    density: Field
    scatter: list[float]
    absorb: list[float]
    g: float = 0.0
    color_grid: str = ""


def of_material(material, grids, notes, name):
    """The matter of a volume material; None if there is none. `grids` has the names of the volume's
    grids in its file by those in materials: an attribute that is not among them counts as Cycles
    counts it. `name` is that of the object, for notes."""
    if material is None or not material.use_nodes or material.node_tree is None:
        return None
    root = nodes.output(material.node_tree, "OUTPUT_MATERIAL", "Volume")
    if root is None:
        return None
    terms, fires = [], []
    name = f"{name}, material {material.name}"
    _collect(root, Reader(name, grids, notes), terms, fires)
    matter = _merge(terms, name, notes)
    matter.fires = fires
    return matter


@dataclass
class Reader:
    """What reading a node takes besides it."""

    name: str
    grids: dict
    notes: Any

    def known(self, grid):
        """The name in the file of an attribute, if the volume has it."""
        return self.grids.get(grid, "")

    def of(self, socket):
        """The field that feeds a socket, if the volume has it; else None."""
        found = of_socket(socket)
        if found is None or found.grid is None:
            return found
        return replace(found, grid=self.grids[found.grid]) if found.grid in self.grids else None

    def field(self, node, socket):
        """The field of an input. A grid that the volume lacks is 0, as in Cycles; where nodes
        cannot be mapped, the number that the socket shows stands for them."""
        found = self.of(node.inputs[socket])
        if found is not None:
            return found
        missing = of_socket(node.inputs[socket])
        what = f"the grid {missing.grid}, which the volume lacks," if missing else "nodes"
        number = missing.at(0.0) if missing else nodes.value(node, socket)
        self.notes.add(self.name, f"{what} at {socket} of {node.bl_label}", f"the number {number:g}")
        return Field(factor=number)

    def color(self, node, socket):
        """A constant, and the grid that multiplies it."""
        color, plain = nodes.color(node, socket)
        if plain:
            return color, ""
        found = self.of(node.inputs[socket])
        if found is not None and found.grid and found == Field(grid=found.grid):
            return [1.0, 1.0, 1.0], found.grid
        self.notes.add(self.name, f"nodes at {socket} of {node.bl_label}",
                       "the colour of the socket")
        return color, ""

    def number(self, node, socket):
        number, plain = nodes.number(node, socket)
        if not plain:
            self.notes.add(self.name, f"nodes at {socket} of {node.bl_label}",
                           f"the number {number:g}")
        return number


def _collect(node, reader, terms, fires):
    """Takes a tree of shaders apart."""
    kinds = {"PRINCIPLED_VOLUME": _principled, "VOLUME_SCATTER": _scatter,
             "VOLUME_ABSORPTION": _absorption}
    if node.type == "ADD_SHADER":
        for socket in node.inputs:
            if (fed := nodes.source(socket)) is not None:
                _collect(fed[0], reader, terms, fires)
    elif node.type == "EMISSION":
        fires += fire.emission(node, "Color", "Strength", reader)
    elif node.type in kinds:
        terms.append(kinds[node.type](node, reader))
        if node.type == "PRINCIPLED_VOLUME":
            fires += fire.principled(node, reader, terms[-1].density)
    else:
        reader.notes.add(reader.name, f"a {node.bl_label} node in a volume", "nothing of it")


def _unit(x):
    return min(max(x, 0.0), 1.0)


def _principled(node, reader):
    color, color_grid = reader.color(node, "Color")
    color_grid = reader.known(nodes.value(node, "Color Attribute", "")) or color_grid
    color = [_unit(c) for c in color]
    shadow, plain = nodes.color(node, "Absorption Color")
    if not plain:
        reader.notes.add(reader.name, "nodes at Absorption Color", "the colour of the socket")
    absorb = [(1 - c) * (1 - _unit(math.sqrt(max(a, 0)))) for c, a in zip(color, shadow)]
    return Term(_principled_density(node, reader), color, absorb,
                reader.number(node, "Anisotropy"), color_grid)


def _principled_density(node, reader):
    """The product of a socket and an attribute."""
    density = reader.field(node, "Density")
    grid = reader.known(nodes.value(node, "Density Attribute", ""))
    if not grid:
        return density
    if density.grid is None:
        return Field(grid=grid, factor=max(density.factor, 0.0))
    if density.grid == grid and density.is_plain:
        return Field(grid=grid, factor=density.factor * density.scale, power=2)
    reader.notes.add(reader.name, f"nodes at Density times the attribute {grid}",
                     "the nodes alone: leave Density Attribute empty")
    return density


def _scatter(node, reader):
    color, color_grid = reader.color(node, "Color")
    if getattr(node, "phase", "HENYEY_GREENSTEIN") != "HENYEY_GREENSTEIN":
        reader.notes.add(reader.name, f"the phase function {node.phase.title()}",
                         "Henyey-Greenstein's with the node's anisotropy")
    g = reader.number(node, "Anisotropy") if "Anisotropy" in node.inputs else 0.0
    return Term(reader.field(node, "Density"), [max(c, 0.0) for c in color], [0.0] * 3, g,
                color_grid)


def _absorption(node, reader):
    color, _ = reader.color(node, "Color")
    return Term(reader.field(node, "Density"), [0.0] * 3, [1 - _unit(c) for c in color])


def _merge(terms, name, notes):
    """Terms as one medium, which they are if their densities differ by a factor."""
    terms = [t for t in terms if t.density.split()[0] > 0 and any(t.scatter + t.absorb)]
    if not terms:
        return Matter(medium={"extinction": 0.0})
    first = terms[0]
    alike = [t for t in terms if (t.density.grid, t.density.split()[1]) == (
        first.density.grid, first.density.split()[1])]
    if len(alike) < len(terms):
        notes.add(name, "shaders whose densities differ by more than a factor",
                  "the first and those like it")
    scatter = [sum(t.density.split()[0] * t.scatter[i] for t in alike) for i in range(3)]
    absorb = [sum(t.density.split()[0] * t.absorb[i] for t in alike) for i in range(3)]
    medium = coefficients(scatter, absorb)
    medium["g"] = _mean_cosine(alike, name, notes)
    if first.density.split()[1]:
        medium["density"] = first.density.split()[1]
    return Matter(first.density, medium, color_grid=first.color_grid)


def coefficients(scatter, absorb):
    """Extinction and albedo of coefficients by channel."""
    sums = [s + a for s, a in zip(scatter, absorb)]
    extinction = max(sums)
    medium = {"extinction": extinction,
              "albedo": [_unit(s / e) if e > 0 else 0.0 for s, e in zip(scatter, sums)]}
    if min(sums) < extinction * (1 - 1e-6):
        medium["extinction_color"] = [e / extinction for e in sums]
    return medium


def _mean_cosine(terms, name, notes):
    weights = [t.density.split()[0] * sum(t.scatter) for t in terms]
    if sum(weights) <= 0:
        return 0.0
    g = sum(w * t.g for w, t in zip(weights, terms)) / sum(weights)
    if any(w > 0 and abs(t.g - g) > 1e-4 for w, t in zip(weights, terms)):
        notes.add(name, "several anisotropies", f"their mean, {g:.3g}")
    return min(max(g, -0.9999), 0.9999)
