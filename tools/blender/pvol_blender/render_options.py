"""The options of a render: `[render]`, from the settings of scene and view layer."""

from . import passes


def of_scene(scene, view_layer, size):
    """For a final picture of `size` pixels."""
    settings = scene.pvol
    options = {
        "size": list(size),
        "seed": settings.seed + (scene.frame_current if settings.animate_seed else 0),
        "background": not scene.render.film_transparent,
        "filter_width": max(2 * scene.render.filter_size, 0.02),
        "aov": passes.aovs(view_layer.pvol.layers),
        **threads(scene),
        **end(settings),
    }
    if settings.max_bounces:
        options["max_bounces"] = settings.max_bounces
    if settings.denoise:
        options["denoise"] = True
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
    """The whole picture, in pixels."""
    scale = render.resolution_percentage / 100
    return max(1, int(render.resolution_x * scale)), max(1, int(render.resolution_y * scale))


def crop(render, size):
    """Of the border: x, y from the top, width and height."""
    width, height = size
    left, right = int(render.border_min_x * width), int(render.border_max_x * width)
    low, high = int(render.border_min_y * height), int(render.border_max_y * height)
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
    return options
