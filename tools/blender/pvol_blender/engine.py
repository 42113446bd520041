"""The render engine "pvol"."""

import traceback

import bpy

from . import final, passes, preferences, pvol_module, unmapped, viewport


class Engine(bpy.types.RenderEngine):
    bl_idname = "PVOL"
    bl_label = "pvol"
    bl_use_preview = False
    bl_use_postprocess = True
    bl_use_eevee_viewport = True
    bl_use_shading_nodes_custom = False
    bl_use_gpu_context = False

    view = None  # of an engine that draws a viewport

    def render(self, depsgraph):
        module = self._module()
        if module is None:
            return
        try:
            notes = final.render(self, depsgraph, module)
        except Exception as error:  # whatever it is, the artist is told
            if not isinstance(error, (module.Error, ValueError, OSError, MemoryError)):
                traceback.print_exc()
            self._fail(str(error) or type(error).__name__)
            return
        unmapped.remember(depsgraph.scene.name, notes)
        if notes:
            self.report({"INFO"}, f"{len(notes)} things of the scene are rendered otherwise: see "
                        "Render Properties > Not Mapped")

    def update_render_passes(self, scene=None, renderlayer=None):
        self.register_pass(scene, renderlayer, "Combined", 4, "RGBA", "COLOR")
        layers = renderlayer.pvol.layers
        for found in passes.chosen_passes(layers, scene, scene.pvol.denoise):
            self.register_pass(scene, renderlayer, found.name, len(found.channels),
                               found.channels, found.kind)

    def view_update(self, context, depsgraph):
        if self.view is None:
            self.view = viewport.View(self)
        self.view.update(context, depsgraph)

    def view_draw(self, context, depsgraph):
        if self.view is not None:
            self.view.draw(context, depsgraph)

    def __del__(self):
        view = object.__getattribute__(self, "view")  # Blender's part is gone already
        if view is not None:
            view.close()

    def _module(self):
        try:
            return preferences.load()
        except pvol_module.Missing as missing:
            self._fail(str(missing))
            return None

    def _fail(self, message):
        self.report({"ERROR"}, message)
        self.error_set(message)


def register():
    bpy.utils.register_class(Engine)


def unregister():
    bpy.utils.unregister_class(Engine)
