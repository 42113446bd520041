"""From what Blender evaluated to the dict of a scene that `pvol.render` takes.

Each kind of thing has a module with functions from Blender's data to plain dicts. What cannot be
mapped is noted, with what pvol uses instead.
"""

from dataclasses import dataclass, field
from typing import Any

from . import camera, lights, motion, placed, surfaces, world
from .notes import Notes
from .volumes import Volumes


@dataclass
class Translation:
    """One translation of a scene, and what it needs."""

    depsgraph: Any
    files: Any  # files.Files, or DryFiles, which write nothing
    module: Any = None  # pvol, for volumes in memory; without it nothing can be rendered
    later: dict = field(default_factory=dict)  # matrices one frame later, by key
    notes: Notes = field(default_factory=Notes)
    albedos: dict = field(default_factory=dict)  # by material

    @property
    def scene(self):
        return self.depsgraph.scene

    @property
    def view_layer(self):
        return self.depsgraph.view_layer

    @property
    def frame(self):
        return self.depsgraph.scene.frame_current

    @property
    def frames_per_second(self):
        return motion.frames_per_second(self.scene)

    @property
    def blurred(self):
        return bool(self.scene.render.use_motion_blur)

    def sections(self):
        """All sections of the scene but the camera."""
        volumes, lamps, meshes = Volumes(self), {}, []
        for thing in placed.things(self.depsgraph):
            if thing.object.type == "LIGHT":
                self._add_lamp(thing, lamps)
            elif not volumes.add(thing):
                meshes += surfaces.tables(thing, self)
        tables = {"world": {"up": "z"}, **lamps,
                  "environment": world.of_world(self.scene.world, self.files, self.notes)}
        if meshes:
            tables["mesh"] = meshes
        return {**tables, **_first_medium(volumes.tables())}

    def albedo(self, material, name):
        """Of a material, which is read and noted once, for the object that has it first."""
        key = material.name_full if material else ""
        if key not in self.albedos:
            self.albedos[key] = surfaces.albedo(material, self.notes, name)
        return self.albedos[key]

    def _add_lamp(self, thing, lamps):
        made = lights.of_object(thing.object, thing.matrix, self.notes)
        if made is not None:
            lamps.setdefault(made[0], []).append(made[1])

    def camera(self, thing):
        """The [camera] of a camera object, with the shutter of the scene."""
        evaluated = thing.evaluated_get(self.depsgraph)
        table = camera.of_object(evaluated, evaluated.matrix_world, self.scene, self.notes)
        if self.blurred:
            table["shutter"] = motion.shutter(self.scene)
            table["fps"] = self.frames_per_second
            if motion.moved(evaluated.matrix_world, self.later.get("camera")):
                table["to"] = {"matrix": camera.rows(camera.unmirrored(self.later["camera"]))}
        return table


def _first_medium(volumes):
    """The volumes, and the medium of the first as its own section, as scenes have it."""
    if not volumes:
        return {}
    first = dict(volumes[0])
    tables = {"volume": [first, *volumes[1:]]}
    if "medium" in first:
        tables["medium"] = first.pop("medium")
    return tables
