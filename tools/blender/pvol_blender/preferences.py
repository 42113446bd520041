"""The preferences of the add-on: where the Python module is."""

import bpy

from . import pvol_module


class Preferences(bpy.types.AddonPreferences):
    bl_idname = __package__

    module_folder: bpy.props.StringProperty(
        name="Folder of the module",
        description="The folder that contains the package pvol (build/release/python, or "
                    "lib/python3/dist-packages of an installation). Empty: the add-on's own, or "
                    "Python's path",
        subtype="DIR_PATH",
    )

    def draw(self, context):
        self.layout.prop(self, "module_folder")
        try:
            module = load()
        except pvol_module.Missing as missing:
            wrapped(self.layout, str(missing), icon="ERROR")
        else:
            text = f"pvol {module.__version__}, {module.__file__}"
            self.layout.label(text=text, icon="CHECKMARK")


def wrapped(layout, text, icon="NONE", width=70):
    """A label of several lines, which Blender's own labels do not have."""
    column = layout.column(align=True)
    line = ""
    for word in text.split() + [None]:
        if word is not None and len(line) + len(word) < width:
            line = f"{line} {word}".strip()
            continue
        if line:
            column.label(text=line, icon=icon)
            icon = "NONE" if icon == "NONE" else "BLANK1"
        line = word or ""


def load():
    """The module pvol; raises pvol_module.Missing."""
    addon = bpy.context.preferences.addons.get(__package__)
    chosen = addon.preferences.module_folder if addon and addon.preferences else ""
    return pvol_module.load(bpy.path.abspath(chosen) if chosen else "")


def register():
    bpy.utils.register_class(Preferences)


def unregister():
    bpy.utils.unregister_class(Preferences)
