"""A final picture: renders a frame and writes its passes into Blender's result."""

import warnings

import numpy as np

from . import passes, render_options
from .translate import Translation, motion
from .translate.files import Files

_SPECK = "speck"  # the volume of a scene without volumes


def render(engine, depsgraph, module):
    """Returns the notes of the translation."""
    scene = depsgraph.scene
    size = render_options.size(scene.render)
    camera = _camera(engine, scene)
    later = _later(engine, depsgraph, camera)
    files = Files()
    try:
        translation = Translation(depsgraph, files, module, later)
        engine.update_stats("", "Translating the scene")
        sections = with_volume(translation.sections(), module)
        sections["camera"] = translation.camera(camera)
        options = render_options.of_scene(scene, depsgraph.view_layer, size)
        picture = _render(engine, module, sections, options, depsgraph.view_layer)
        _write(engine, picture, depsgraph.view_layer, options)
        return translation.notes
    finally:
        files.close()


def _camera(engine, scene):
    camera = engine.camera_override or scene.camera
    if camera is None:
        raise ValueError("The scene has no camera: add one and make it active (Ctrl-Numpad 0).")
    return camera


def _later(engine, depsgraph, camera):
    """Where all things are a frame later, if motion is blurred."""
    scene = depsgraph.scene
    if not scene.render.use_motion_blur:
        return {}
    frame, subframe = scene.frame_current, scene.frame_subframe
    engine.frame_set(frame + 1, subframe)
    later = motion.later_places(depsgraph, camera)
    engine.frame_set(frame, subframe)
    return later


def has_volumes(sections):
    return not getattr(sections["volume"][0], "name", "") == _SPECK


def with_volume(sections, module):
    """The scene, with a speck of nothing if it has no volume: pvol wants one."""
    if "volume" in sections:
        return sections
    speck = module.Volume(np.ones((1, 1, 1), dtype=np.float32), voxel_size=1e-3, extinction=1e-9,
                          name=_SPECK)
    return {**sections, "volume": [speck]}


def _render(engine, module, sections, options, view_layer):
    """The picture, or what there is of it when the artist ends the render."""
    def on_pass(picture, fraction):
        if fraction is not None:
            engine.update_progress(fraction)
        samples = picture.samples.mean()
        engine.update_stats("", f"{samples:.0f} samples" + _noise(picture))
        _show(engine, picture, view_layer, options)
        return not engine.test_break()

    engine.update_stats("", "Loading volumes")
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        picture = module.render(sections, force=True, on_pass=on_pass, **options)
    if has_volumes(sections):
        for warning in caught:
            engine.report({"WARNING"}, str(warning.message))
    return picture


def _noise(picture):
    return "" if picture.noise is None else f", noise {100 * picture.noise:.2f} %"


def rgba(picture, options):
    """Rows from below, as Blender has them; opaque where the sky is visible."""
    alpha = np.ones_like(picture.alpha) if options["background"] else picture.alpha
    return np.dstack([picture.rgb, alpha])[::-1]


def _fill(render_pass, pixels):
    """Pixels (height, width) or (height, width, channels) into a pass."""
    rows = np.ascontiguousarray(pixels, dtype=np.float32).reshape(-1, render_pass.channels)
    try:
        render_pass.rect.foreach_set(rows)
    except TypeError:  # versions that count numbers, not pixels
        render_pass.rect.foreach_set(rows.ravel())


def _fits(picture, options):
    width, height = options["crop"][2:] if "crop" in options else options["size"]
    return picture.alpha.shape == (height, width)


def _show(engine, picture, view_layer, options):
    """A picture that is not finished, in the render window."""
    if not _fits(picture, options):
        return
    height, width = picture.alpha.shape
    result = engine.begin_result(0, 0, width, height, layer=view_layer.name)
    _fill(result.layers[0].passes["Combined"], rgba(picture, options))
    engine.end_result(result, cancel=False, do_merge_results=False)


def _write(engine, picture, view_layer, options):
    layers = list(_layers(picture, view_layer.pvol.layers))
    for found, _ in layers:
        engine.add_pass(found.name, len(found.channels), found.channels, layer=view_layer.name)
    height, width = picture.alpha.shape
    result = engine.begin_result(0, 0, width, height, layer=view_layer.name)
    to = result.layers[0].passes
    _fill(to["Combined"], rgba(picture, options))
    for found, values in layers:
        _fill(to[found.name], values[::-1])
    engine.end_result(result)


def _layers(picture, chosen):
    """Passes and their pixels."""
    single = {p.layer: p for p in passes.PASSES}
    for layer in picture.layers:
        if layer == passes.NOISY.layer:
            yield passes.NOISY, picture.aov(layer)
        elif layer in single:
            if layer in chosen:
                yield single[layer], picture.aov(layer)
        elif layer not in passes.OF_THE_FILTER:
            yield passes.colour_pass(layer), picture.aov(layer)
