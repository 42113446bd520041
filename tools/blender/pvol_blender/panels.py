"""Panels of the render and view layer properties, and Blender's own that pvol has a use for."""

import bpy

from . import unmapped
from .preferences import wrapped


class _Panel:
    bl_space_type = "PROPERTIES"
    bl_region_type = "WINDOW"
    bl_context = "render"
    COMPAT_ENGINES = {"PVOL"}

    @classmethod
    def poll(cls, context):
        return context.engine in cls.COMPAT_ENGINES


class PVOL_PT_sampling(_Panel, bpy.types.Panel):
    bl_label = "Sampling"

    def draw(self, context):
        settings, layout = context.scene.pvol, self.layout
        layout.use_property_split = True
        layout.use_property_decorate = False
        layout.prop(settings, "end")
        layout.prop(settings, {"SAMPLES": "samples", "NOISE": "noise",
                               "TIME": "seconds"}[settings.end])
        layout.prop(settings, "denoise")
        column = layout.column()
        column.prop(settings, "viewport_samples")
        column.prop(settings, "viewport_denoise")
        column = layout.column()
        column.prop(settings, "seed")
        column.prop(settings, "animate_seed")
        column.prop(settings, "max_bounces")
        if settings.max_bounces:
            layout.label(text="Biased: paths are cut off", icon="INFO")


class PVOL_PT_motion_blur(_Panel, bpy.types.Panel):
    bl_label = "Motion Blur"
    bl_options = {"DEFAULT_CLOSED"}

    def draw_header(self, context):
        self.layout.prop(context.scene.render, "use_motion_blur", text="")

    def draw(self, context):
        render, layout = context.scene.render, self.layout
        layout.use_property_split = True
        layout.active = render.use_motion_blur
        for owner in (render, getattr(context.scene, "cycles", None)):
            if hasattr(owner, "motion_blur_position"):
                layout.prop(owner, "motion_blur_position")
                break
        layout.prop(render, "motion_blur_shutter")


class PVOL_PT_film(_Panel, bpy.types.Panel):
    bl_label = "Film"
    bl_options = {"DEFAULT_CLOSED"}

    def draw(self, context):
        render, layout = context.scene.render, self.layout
        layout.use_property_split = True
        layout.prop(render, "film_transparent", text="Transparent")
        layout.prop(render, "filter_size")


class PVOL_PT_threads(_Panel, bpy.types.Panel):
    bl_label = "Performance"
    bl_options = {"DEFAULT_CLOSED"}

    def draw(self, context):
        render, layout = context.scene.render, self.layout
        layout.use_property_split = True
        layout.prop(render, "threads_mode")
        row = layout.row()
        row.enabled = render.threads_mode == "FIXED"
        row.prop(render, "threads")


class PVOL_PT_unmapped(_Panel, bpy.types.Panel):
    bl_label = "Not Mapped"

    def draw(self, context):
        layout = self.layout
        layout.operator("pvol.list_unmapped", icon="VIEWZOOM")
        notes = unmapped.notes_of(context.scene)
        if notes is None:
            layout.label(text="The scene has not been checked", icon="QUESTION")
        elif not notes:
            layout.label(text="Everything is mapped", icon="CHECKMARK")
        for note in notes or ():
            box = layout.box().column(align=True)
            box.label(text=note.thing, icon="ERROR")
            width = max(30, int(context.region.width / 8))
            wrapped(box, f"{note.what[0].upper()}{note.what[1:]}.", width=width)
            wrapped(box, f"pvol uses {note.instead}.", width=width)


class PVOL_PT_passes(_Panel, bpy.types.Panel):
    bl_label = "Passes"
    bl_context = "view_layer"

    def draw(self, context):
        self.layout.column().prop(context.view_layer.pvol, "layers")


class PVOL_PT_light(_Panel, bpy.types.Panel):
    bl_label = "Light"
    bl_context = "data"

    @classmethod
    def poll(cls, context):
        return context.light is not None and super().poll(context)

    def draw(self, context):
        light, layout = context.light, self.layout
        layout.use_property_split = True
        layout.row().prop(light, "type", expand=True)
        layout.prop(light, "color")
        layout.prop(light, "energy")
        names = {"SUN": ["angle"], "POINT": ["shadow_soft_size"], "AREA": ["shape", "size"],
                 "SPOT": ["spot_size", "spot_blend"]}[light.type]
        if light.type == "AREA" and light.shape in ("RECTANGLE", "ELLIPSE"):
            names = [*names, "size_y"]
        for name in names:
            layout.prop(light, name)


class PVOL_PT_panorama(_Panel, bpy.types.Panel):
    bl_label = "Panorama"
    bl_context = "data"

    @classmethod
    def poll(cls, context):
        is_panorama = context.camera is not None and context.camera.type == "PANO"
        return is_panorama and super().poll(context)

    def draw(self, context):
        self.layout.label(text="All directions, equirectangular")


_classes = (PVOL_PT_sampling, PVOL_PT_motion_blur, PVOL_PT_film, PVOL_PT_threads, PVOL_PT_unmapped,
            PVOL_PT_passes, PVOL_PT_light, PVOL_PT_panorama)

# Panels of Blender that edit what pvol reads, by their names: other versions lack some of them.
_BLENDERS = (
    "EEVEE_WORLD_PT_surface", "EEVEE_MATERIAL_PT_context_material", "EEVEE_MATERIAL_PT_surface",
    "EEVEE_MATERIAL_PT_volume", "OBJECT_PT_visibility", "RENDER_PT_format", "RENDER_PT_frame_range",
    "RENDER_PT_output", "RENDER_PT_output_color_management", "RENDER_PT_encoding",
    "RENDER_PT_post_processing", "RENDER_PT_stamp", "RENDER_PT_stamp_note",
    "RENDER_PT_stamp_burn", "RENDER_PT_time_stretching", "RENDER_PT_color_management",
    "RENDER_PT_color_management_curves", "VIEWLAYER_PT_layer",
    "DATA_PT_context_light", "DATA_PT_context_camera", "DATA_PT_lens", "DATA_PT_camera",
    "DATA_PT_camera_dof", "DATA_PT_camera_dof_aperture", "DATA_PT_camera_display",
    "DATA_PT_context_volume", "DATA_PT_volume_file", "DATA_PT_volume_grids",
    "DATA_PT_volume_render", "DATA_PT_volume_viewport_display", "WORLD_PT_context_world",
    "MATERIAL_PT_preview", "VIEWLAYER_PT_layer_passes", "DATA_PT_context_mesh",
)


def _blenders():
    found = (getattr(bpy.types, name, None) for name in _BLENDERS)
    return [panel for panel in found if hasattr(panel, "COMPAT_ENGINES")]


def register():
    for c in _classes:
        bpy.utils.register_class(c)
    for panel in _blenders():
        panel.COMPAT_ENGINES.add("PVOL")


def unregister():
    for panel in _blenders():
        panel.COMPAT_ENGINES.discard("PVOL")
    for c in reversed(_classes):
        bpy.utils.unregister_class(c)
