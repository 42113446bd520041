"""pvol as a render engine of Blender: clouds, smoke and fire without bias.

`translate` turns what Blender evaluated into the dict that `pvol.render` takes; `engine` renders
it, `viewport` refines it while the artist works, and `panels` has the settings.
"""

bl_info = {
    "name": "pvol",
    "author": "pvol",
    "version": (0, 2, 0),
    "blender": (3, 4, 0),
    "location": "Properties > Render > Render Engine",
    "description": "Path-traces clouds, smoke and fire without bias",
    "category": "Render",
}

from . import engine, panels, preferences, settings, unmapped

_parts = (preferences, settings, engine, unmapped, panels)


def register():
    for part in _parts:
        part.register()


def unregister():
    for part in reversed(_parts):
        part.unregister()
