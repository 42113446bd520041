"""Where things are one frame later, for motion blur."""

from . import placed


def later_places(depsgraph, camera):
    """Matrices by key of everything that `placed.things` yields, and of the camera: to be called
    in the next frame."""
    places = {thing.key: thing.matrix for thing in placed.things(depsgraph)}
    if camera is not None:
        places["camera"] = camera.evaluated_get(depsgraph).matrix_world.copy()
    return places


def shutter(scene):
    """Opening and closing of the shutter in frames from the frame's own time."""
    open_for = scene.render.motion_blur_shutter
    owner = scene.render if hasattr(scene.render, "motion_blur_position") else getattr(
        scene, "cycles", None)
    position = getattr(owner, "motion_blur_position", "CENTER")
    start = {"START": 0.0, "CENTER": -open_for / 2, "END": -open_for}[position]
    return [start, start + open_for]


def frames_per_second(scene):
    return scene.render.fps / scene.render.fps_base


def moved(now, later):
    """Whether two matrices are apart by more than the rounding of floats."""
    if later is None:
        return False
    size = max(1.0, max(abs(x) for row in now for x in row))
    return any(abs(a - b) > 1e-6 * size for r, s in zip(now, later) for a, b in zip(r, s))
