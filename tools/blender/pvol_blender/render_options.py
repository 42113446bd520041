"""The options of a render: `[render]`, from the settings of scene and view layer."""

import numpy as np

from . import passes


def of_scene(scene, view_layer, size):
    """For a final picture of `size` pixels."""
    settings = scene.pvol
    options = {
        "size": list(size),
        "seed": (settings.seed + (scene.frame_current if settings.animate_seed else 0)) % 2**32,
        "background": not scene.render.film_transparent,
        "filter_width": min(max(2 * scene.render.filter_size, 0.02), 100.0),
        "aov": passes.aovs(view_layer.pvol.layers),
        **threads(scene),
        **end(settings),
    }
    if settings.max_bounces:
        options["max_bounces"] = settings.max_bounces
    if settings.denoise:
        options["denoise"] = True
        if "spp" in options:
            options["spp"] = max(options["spp"], 2)  # the filter compares two halves
    if scene.render.use_border:
        options["crop"] = crop(scene.render, size)
    return options


def end(settings):
    """When a render is done."""
    return {"SAMPLES": {"spp": settings.samples}, "NOISE": {"noise": settings.noise},
            "TIME": {"time": settings.seconds}}[settings.end]


def threads(scene):
    fixed = scene.render.threads_mode == "FIXED"
    return {"threads": scene.render.threads} if fixed else {}


def size(render):
    """The whole picture, in pixels: rounded down, as Blender does."""
    percentage = render.resolution_percentage
    return (max(1, render.resolution_x * percentage // 100),
            max(1, render.resolution_y * percentage // 100))


def crop(render, size):
    """Of the border: x, y from the top, width and height, by numbers of single precision, as
    Blender has them."""
    def pixel(share, edge):
        return int(np.float32(share) * np.float32(edge))

    width, height = size
    left, right = pixel(render.border_min_x, width), pixel(render.border_max_x, width)
    low, high = pixel(render.border_min_y, height), pixel(render.border_max_y, height)
    return [left, height - high, max(1, right - left), max(1, high - low)]


def viewport(scene, size):
    """For a picture that refines in a viewport."""
    options = {
        "size": list(size),
        "seed": scene.pvol.seed,
        "spp": scene.pvol.viewport_samples,
        "background": not scene.render.film_transparent,
        **threads(scene),
    }
    if scene.pvol.max_bounces:
        options["max_bounces"] = scene.pvol.max_bounces
    if scene.pvol.viewport_denoise:
        options["denoise"] = True
        options["spp"] = max(options["spp"], 2)
    return options
