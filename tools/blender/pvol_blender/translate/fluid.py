"""Smoke and fire that Blender simulates: the .vdb files in the cache of a fluid domain."""

import pathlib

from .files import on_disk

# Of the cache, by the names that materials have for them. Blender derives the temperature from the
# flame, and so do we.
GRIDS = {"density": "density", "flame": "flame", "temperature": "flame", "heat": "heat"}


def domain_of(thing):
    """The settings of a gas domain, or None."""
    for modifier in thing.modifiers:
        if modifier.type == "FLUID" and modifier.fluid_type == "DOMAIN" and modifier.show_render:
            if modifier.domain_settings.domain_type == "GAS":
                return modifier.domain_settings
    return None


def cache_file(thing, frame, notes):
    """The file of a frame, with noise if it has been baked; None if there is none."""
    domain = domain_of(thing)
    if getattr(domain, "cache_frame_offset", 0):
        notes.add(thing.name, "a frame offset of the domain's cache", "the scene's own frame")
    folder = on_disk(domain.cache_directory) or pathlib.Path()
    names = [folder / "data" / f"fluid_data_{frame:04}.vdb"]
    if domain.use_noise:
        names.insert(0, folder / "noise" / f"fluid_noise_{frame:04}.vdb")
    for path in names:
        if path.is_file():
            return path
    if domain.cache_frame_start <= frame <= domain.cache_frame_end:
        notes.add(thing.name, f"a fluid domain without {names[-1]}",
                  "nothing: set the format of its cache to OpenVDB and bake it")
    return None


def file_to_object(thing, path, module, notes):
    """What takes a file of the cache to the space of its domain: the file has the voxels of the
    domain, from its corner on, in a unit of its own."""
    from mathutils import Matrix, Vector

    domain = domain_of(thing)
    if domain.use_adaptive_domain:
        notes.add(thing.name, "an adaptive domain, whose corner the cache does not tell",
                  "the corner of the whole domain: switch Adaptive Domain off")
    if module is None:  # nothing is rendered
        return Matrix.Identity(4)
    voxel = float(module.load(path, "density", extinction=1).index_to_world[0][0])
    finer = domain.noise_scale if path.parent.name == "noise" else 1
    cell = Vector(domain.cell_size) / finer
    corner = Vector(domain.start_point) + cell / 2
    return Matrix.Translation(corner) @ Matrix.Diagonal((*(cell / voxel), 1))
