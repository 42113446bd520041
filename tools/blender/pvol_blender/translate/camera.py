"""Cameras: Blender's, and the view of a viewport."""

import math


def rows(matrix):
    """A 4x4 matrix as 16 numbers, row by row."""
    return [float(x) for row in matrix for x in row]


def unmirrored(matrix):
    """The place of a camera, whose picture is no mirror image."""
    matrix = matrix.copy()
    if matrix.to_3x3().determinant() < 0:
        matrix.col[0].negate()
    return matrix


def of_object(camera, matrix, scene, notes):
    """The [camera] of a camera object that stands at `matrix`."""
    data = camera.data
    if matrix.to_3x3().determinant() < 0:
        notes.add(camera.name, "a camera that mirrors what it sees", "one that does not")
    matrix = unmirrored(matrix)
    table = {"matrix": rows(matrix)}
    if data.type == "PANO":
        _check_panorama(camera, notes)
        table["projection"] = "latlong"
        return table
    fit = {"AUTO": "auto", "HORIZONTAL": "horizontal", "VERTICAL": "vertical"}[data.sensor_fit]
    table["sensor_fit"] = fit
    table["shift"] = [data.shift_x, data.shift_y]
    if data.type == "ORTHO":
        table.update(projection="orthographic", ortho_scale=data.ortho_scale)
    else:
        table["focal_length"] = data.lens
        table["sensor"] = data.sensor_height if fit == "vertical" else data.sensor_width
    _check_pixels(scene, notes)
    if data.dof.use_dof:
        table.update(_lens(camera, matrix, notes))
    return table


def _check_pixels(scene, notes):
    if scene.render.pixel_aspect_x != scene.render.pixel_aspect_y:
        notes.add(scene.name, "pixels that are not square", "square pixels")


def _check_panorama(camera, notes):
    """pvol has one kind of panorama, of all directions."""
    owner = camera.data if hasattr(camera.data, "panorama_type") else getattr(
        camera.data, "cycles", None)
    kind = getattr(owner, "panorama_type", "EQUIRECTANGULAR")
    if kind != "EQUIRECTANGULAR":
        notes.add(camera.name, f"a panorama of type {kind.lower()}", "equirectangular")
        return
    whole = {"longitude_min": -math.pi, "longitude_max": math.pi,
             "latitude_min": -math.pi / 2, "latitude_max": math.pi / 2}
    if any(abs(getattr(owner, name, limit) - limit) > 1e-4 for name, limit in whole.items()):
        notes.add(camera.name, "a panorama of some directions", "all directions")


def _lens(camera, matrix, notes):
    """Depth of field."""
    dof = camera.data.dof
    if camera.data.type == "ORTHO":
        notes.add(camera.name, "depth of field of an orthographic camera", "everything is sharp")
        return {}
    if dof.aperture_blades > 0 or abs(dof.aperture_ratio - 1) > 1e-6:
        notes.add(camera.name, "an aperture with blades or a ratio", "a round aperture")
    distance = dof.focus_distance
    if dof.focus_object is not None:
        view = -matrix.to_3x3().col[2].normalized()
        to_focus = dof.focus_object.matrix_world.translation - matrix.translation
        distance = abs(view.dot(to_focus))
    return {"f_stop": max(dof.aperture_fstop, 1e-5), "focus_distance": max(distance, 1e-5)}


def of_view(view_matrix, window_matrix):
    """The [camera] that sees what a viewport shows, by its projection: camera views, their zoom
    and their shift are in it."""
    p = window_matrix
    table = {"matrix": rows(view_matrix.inverted()), "sensor_fit": "horizontal"}
    across = p[0][0] / p[1][1]  # height over width of the view
    if p[3][3] == 0:  # perspective
        table.update(focal_length=18 * p[0][0], sensor=36.0,
                     shift=[p[0][2] / 2, p[1][2] / 2 * across])
    else:
        table.update(projection="orthographic", ortho_scale=2 / p[0][0],
                     shift=[-p[0][3] / 2, -p[1][3] / 2 * across])
        # A viewport's rays begin far behind what it looks at.
        table["matrix"] = rows(view_matrix.inverted() @ _back(p))
    return table


def _back(projection):
    """The move along the view from the middle of an orthographic view to its near side."""
    from mathutils import Matrix, Vector

    near = -(1 + projection[2][3]) / projection[2][2]  # z where the depth is -1
    return Matrix.Translation(Vector((0, 0, near)))
