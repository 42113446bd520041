"""Volume objects, fluid domains and boxes of fog as the volumes of a scene."""

import math
import os
import pathlib
from dataclasses import dataclass

from mathutils import Matrix, Vector

from . import box, camera, fluid, medium, motion
from .fields import STEP


def density_scale(thing):
    """What a volume's density and emission are multiplied by. In object space, Blender's default,
    an object of twice the size has half of them, so that it stays as opaque and as bright."""
    if thing.object.type != "VOLUME" or thing.object.data.render.space != "OBJECT":
        return 1.0
    m = thing.matrix.to_3x3()
    stretched = sum((m.col[i] for i in range(1, 3)), m.col[0].copy()) / math.sqrt(3)
    return 1 / max(stretched.length, 1e-12)


@dataclass
class Group:
    """Things that share grids and matter."""

    path: pathlib.Path
    matter: medium.Matter
    scale: float  # of the density
    things: list
    grids: tuple  # names in the file
    inner: dict  # what takes each of them to the space of the object


class Volumes:
    """Gathers volumes one by one; those that share grids and matter become one with instances."""

    def __init__(self, translation):
        self.translation = translation
        self._groups = {}
        self._boxes = []

    def add(self, thing):
        """Whether the thing is a volume; it may also be one with nothing in it."""
        if thing.object.type == "VOLUME":
            self._add_volume(thing)
        elif fluid.domain_of(thing.object) is not None:
            self._add_fluid(thing)
        else:
            return self._add_box(thing)
        return True

    def tables(self):
        """The list of [[volume]] tables; the first one's medium is in it, too."""
        tables = list(self._boxes)
        for group in self._groups.values():
            tables += self._tables_of(group)
        return tables

    def _add_volume(self, thing):
        modified = len(thing.object.modifiers) > 0
        path = self.translation.files.volume(thing.object.data, thing.object.name_full, modified)
        if path is None:
            self.translation.notes.add(thing.name, "a volume without grids (is its file there?)",
                                       "nothing")
            return
        grids = thing.object.data.grids
        halves = {grid.name: half_voxel(grid) for grid in grids}
        self._add_grids(thing, path, {name: name for name in halves}, halves)

    def _add_fluid(self, thing):
        translation = self.translation
        path = fluid.cache_file(thing.object, translation.frame, translation.notes)
        if path is None:
            return
        inner = fluid.file_to_object(thing.object, path, translation.module, translation.notes)
        self._add_grids(thing, path, fluid.GRIDS, {name: inner for name in fluid.GRIDS.values()})

    def _add_grids(self, thing, path, grids, inner):
        """A thing with a file; `grids` are names in the file by names in materials, `inner` what
        takes each grid to the space of the object."""
        notes = self.translation.notes
        if not _placeable(thing, notes):
            return
        slot = thing.object.material_slots[0].material if thing.object.material_slots else None
        scale = density_scale(thing)
        key = (os.fspath(path), slot.name_full if slot else "", round(scale, 9))
        if key in self._groups:
            self._groups[key].things.append(thing)
            return
        matter = (medium.of_material(slot, grids, notes, thing.name) if slot
                  else default_matter(grids))
        if matter is None:
            notes.add(thing.name, "a material without a volume shader", "nothing")
            return
        self._groups[key] = Group(path, matter, scale, [thing], tuple(grids.values()), inner)

    def _tables_of(self, group):
        """One volume, and one more for each further fire."""
        matter = group.matter
        base = dict(matter.medium)
        base["extinction"] *= group.scale
        base["albedo_field"] = {"grid": matter.color_grid or "none"}
        if base["extinction"] <= 0:
            base = {}
        elif matter.density.grid is None:
            base["density"] = {"ramp": STEP}  # as dense everywhere: wherever a grid has anything
        media = [(matter.density.grid or group.grids[0], base)] if base else []
        for i, table in enumerate(matter.fires):
            table = {**table, "field": table["field"] or group.grids[0],
                     "intensity": table["intensity"] * group.scale}
            if i == 0 and media:
                media[0][1]["fire"] = table
            else:
                media.append(("none", {"fire": table}))
        tables = []
        for grid, table in media:
            self._add_velocity(group.things[0], table, group.grids)
            inner = group.inner[grid if grid != "none" else table["fire"]["field"]]
            places = [self._place(thing, inner) for thing in group.things]
            tables.append({"file": os.fspath(group.path), "grid": grid, **placed(table, places)})
        return tables

    def _place(self, thing, inner):
        """Where a thing is and, if it moves, where it is one frame later."""
        place = {"matrix": camera.rows(thing.matrix @ inner)}
        later = self.translation.later.get(thing.key)
        if motion.moved(thing.matrix, later):
            place["to"] = {"matrix": camera.rows(later @ inner)}
        return place

    def _add_velocity(self, thing, table, grids):
        """Where a shutter is open and the volume has velocities."""
        data = thing.object.data
        if not self.translation.blurred or thing.object.type != "VOLUME":
            return
        name = data.velocity_grid
        if not any(g == name or g.lower().startswith((name + ".").lower()) for g in grids):
            return
        scale = data.velocity_scale
        if data.velocity_unit == "FRAME":
            scale *= self.translation.frames_per_second
        table["motion"] = {"field": name, "scale": scale}

    def _add_box(self, thing):
        """A mesh with a volume material, if it has one."""
        if thing.object.type != "MESH" or not thing.object.material_slots:
            return False
        material = thing.object.material_slots[0].material
        matter = medium.of_material(material, {}, self.translation.notes, thing.name)
        if matter is None:
            return False
        notes = self.translation.notes
        if _placeable(thing, notes):
            table = box.of_mesh(thing, matter, self.translation.module, notes)
            self._boxes += [table] if table else []
        return not box.has_surface(material)


def half_voxel(grid):
    """What moves a grid by half a voxel: Blender's voxels begin where OpenVDB and pvol have their
    middles."""
    return Matrix.Translation(grid.matrix_object.to_3x3() @ Vector((0.5, 0.5, 0.5)))


def placed(medium_table, places):
    """A medium at one place, or at several by instances."""
    if len(places) > 1:
        return {"medium": medium_table, "instance": places}
    place = dict(places[0])
    return {"medium": {**medium_table, "matrix": place.pop("matrix")}, **place}


def default_matter(grids):
    """Of a volume without a material: Blender's default, grey smoke of the grid density."""
    grid = grids.get("density") or next(iter(grids.values()))
    grey = {"extinction": 1.0, "albedo": [0.5] * 3, "g": 0.0}
    return medium.Matter(medium.Field(grid=grid), grey)


def _placeable(thing, notes):
    if abs(thing.matrix.to_3x3().determinant()) > 1e-30:
        return True
    notes.add(thing.name, "an object that is scaled to nothing", "nothing")
    return False
