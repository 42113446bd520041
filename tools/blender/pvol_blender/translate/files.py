"""The files that a scene refers to: those of the artist, and those that a translation writes into a
folder of its own, which goes when the render is done."""

import os
import pathlib
import re
import tempfile
import zlib

import numpy as np

from . import ply, radiance

_PICTURES = {".exr", ".hdr"}  # that pvol reads
_VOLUMES = {".vdb"}


def on_disk(path, library=None):
    """An absolute path where Blender means one that may be relative to the .blend file."""
    import bpy

    return pathlib.Path(bpy.path.abspath(path, library=library)) if path else None


class Files:
    """Writes what pvol reads from files. Of equal things, by name and version, one is written."""

    def __init__(self):
        self._folder = tempfile.TemporaryDirectory(prefix="pvol_blender_")
        self._written = {}
        self._count = 0
        self._stale = {}  # may still be read

    def close(self):
        self._folder.cleanup()

    def forget(self, name):
        """A thing has changed: its files are written anew. Those before the last ones go."""
        for key in [k for k in self._written if k[0] == name]:
            self._let_go(key, key)

    def _let_go(self, key, place):
        """A file may still be read; the one that had its place before is not."""
        if (path := self._stale.pop(place, None)) is not None:
            path.unlink(missing_ok=True)
        self._stale[place] = self._written.pop(key)

    def _once(self, key, suffix, write):
        if key not in self._written:
            self._count += 1
            name = re.sub(r"\W", "_", str(key[0])) + f"_{self._count}{suffix}"
            path = pathlib.Path(self._folder.name) / name
            self._written[key] = path if write(path) is not False else None
        return self._written[key]

    def mesh(self, thing, part, vertices, triangles):
        """Triangles of an object's mesh, of which `part` is one material's. Instances that nodes
        make have the name of their instancer, and meshes of their own."""
        key = (thing.name_full, part, thing.data.as_pointer())
        return self._once(key, ".ply", lambda p: ply.write(p, vertices, triangles))

    def volume(self, volume, name, modified):
        """A volume's grids: its own file, or one with what modifiers made of it; None if there are
        no grids."""
        grids = volume.grids
        if not grids.load() or len(grids) == 0:
            return None
        loaded = on_disk(grids.frame_filepath or volume.filepath, volume.library)
        if loaded and not modified and loaded.suffix in _VOLUMES and loaded.is_file():
            return loaded
        key = (name, grids.frame, volume.as_pointer())
        return self._once(key, ".vdb", lambda p: bool(grids.save(os.fspath(p))))

    def picture(self, image):
        """A picture that pvol reads; None if there is no picture."""
        own = on_disk(image.filepath, image.library)
        if image.source == "FILE" and not image.packed_file and own and not image.is_dirty:
            if own.suffix.lower() in _PICTURES and own.is_file():
                return own
        pixels = _pixels(image)
        if pixels is None:
            return None
        # Painting in a picture changes it without an update of its own.
        key = (image.name_full, "picture", zlib.crc32(pixels))
        for old in [k for k in self._written if k[:2] == key[:2] and k != key]:
            self._let_go(old, key[:2])
        return self._once(key, ".hdr", lambda p: radiance.write(p, _linear(pixels, image)))


def _pixels(image):
    """(height, width, channels) from the top, or None if there are none."""
    width, height = image.size
    if width == 0 or height == 0:
        return None
    pixels = np.empty(width * height * image.channels, dtype=np.float32)
    image.pixels.foreach_get(pixels)
    return np.ascontiguousarray(pixels.reshape(height, width, image.channels)[::-1])


def _linear(pixels, image):
    rgb = pixels[..., :3] if image.channels >= 3 else np.repeat(pixels[..., :1], 3, axis=2)
    if not image.is_float and image.colorspace_settings.name == "sRGB":
        rgb = radiance.linear(rgb)
    return rgb


class DryFiles:
    """Writes nothing: for a list of what cannot be mapped."""

    def close(self):
        pass

    def mesh(self, thing, part, vertices, triangles):
        return pathlib.Path(f"{thing.name_full}_{part}.ply")

    def volume(self, volume, name, modified):
        own = on_disk(volume.grids.frame_filepath or volume.filepath, volume.library)
        has_grids = volume.grids.load() and len(volume.grids) > 0
        return (own or pathlib.Path(f"{name}.vdb")) if has_grids else None

    def picture(self, image):
        return pathlib.Path(image.name) if image.size[0] else None
