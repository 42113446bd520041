"""What artists set of a render: of the scene and, for passes, of the view layer."""

import bpy
from bpy.props import (BoolProperty, EnumProperty, FloatProperty, IntProperty, PointerProperty)

from . import passes


class SceneSettings(bpy.types.PropertyGroup):
    end: EnumProperty(
        name="Render Until",
        items=(
            ("SAMPLES", "Samples", "Each pixel gets the same number of samples"),
            ("NOISE", "Noise", "Until the noise is small enough; noisy pixels get more samples"),
            ("TIME", "Time", "For some seconds; noisy pixels get more samples"),
        ),
        default="SAMPLES",
    )
    samples: IntProperty(name="Samples", description="Samples per pixel; four times as many halve "
                         "the noise", default=64, min=1, soft_max=4096)
    noise: FloatProperty(name="Noise", description="Standard error of the pixels over their own "
                         "brightness", default=0.03, min=0.0001, max=1, precision=4)
    seconds: FloatProperty(name="Seconds", description="Time for rendering, without loading",
                           default=60, min=0.1, soft_max=3600)
    seed: IntProperty(name="Seed", description="Of the random numbers", default=1, min=0)
    animate_seed: BoolProperty(name="New Seed in Each Frame", default=True,
                               description="Add the frame's number to the seed, so that noise does "
                                           "not stand still in a sequence")
    denoise: BoolProperty(name="Denoise", default=False,
                          description="Filter the picture: biased, least visible where there is "
                                      "much noise. The pass Noisy Image keeps what was rendered")
    max_bounces: IntProperty(name="Most Scatterings", default=0, min=0, max=65000,
                             description="End paths after so many scatterings: biased, thick "
                                         "clouds turn darker. 0: no limit")
    viewport_denoise: BoolProperty(name="Denoise Viewport", default=False,
                                   description="Filter the picture in the viewport")
    viewport_samples: IntProperty(name="Viewport Samples", default=256, min=1, soft_max=4096,
                                  description="Samples per pixel at which the viewport stops")


def _layer_items():
    single = [(p.layer, p.name, p.about) for p in passes.PASSES]
    return [(*item, 1 << i) for i, item in enumerate([*single, *passes.SETS])]


class LayerSettings(bpy.types.PropertyGroup):
    layers: EnumProperty(
        name="Passes",
        description="Passes to render beside the picture",
        items=_layer_items(),
        options={"ENUM_FLAG"},
        default=set(),
        update=lambda self, context: context.view_layer.update_render_passes(),
    )


_classes = (SceneSettings, LayerSettings)


def register():
    for c in _classes:
        bpy.utils.register_class(c)
    bpy.types.Scene.pvol = PointerProperty(type=SceneSettings)
    bpy.types.ViewLayer.pvol = PointerProperty(type=LayerSettings)


def unregister():
    del bpy.types.ViewLayer.pvol
    del bpy.types.Scene.pvol
    for c in reversed(_classes):
        bpy.utils.unregister_class(c)
