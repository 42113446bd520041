"""Lists what of a scene pvol cannot render as it is: after each render, and when asked."""

import bpy

from .translate import Translation
from .translate.files import DryFiles

_notes = {}  # by scene; None is "never looked"


def remember(scene_name, notes):
    _notes[scene_name] = list(notes)


def notes_of(scene):
    return _notes.get(scene.name)


def look(depsgraph):
    """Translates without rendering or writing anything."""
    translation = Translation(depsgraph, DryFiles())
    translation.sections()
    if depsgraph.scene.camera is not None:
        translation.camera(depsgraph.scene.camera)
    return translation.notes


class ListUnmapped(bpy.types.Operator):
    bl_idname = "pvol.list_unmapped"
    bl_label = "Check the Scene"
    bl_description = "List what of this scene pvol renders otherwise than Cycles, and how"

    def execute(self, context):
        notes = look(context.evaluated_depsgraph_get())
        remember(context.scene.name, notes)
        for note in notes:
            print(f"pvol: {note}")
        return {"FINISHED"}


def register():
    bpy.utils.register_class(ListUnmapped)


def unregister():
    bpy.utils.unregister_class(ListUnmapped)
    _notes.clear()
