"""Pictures as Radiance .hdr files, for skies that Blender has in other formats or in memory."""

import numpy as np


def write(path, rgb):
    """`rgb` is (height, width, 3), linear, rows from the top. Without run lengths: any width."""
    largest = np.maximum(rgb.max(axis=2), 0)
    exponent = np.frexp(largest)[1]
    exponent += np.rint(np.ldexp(largest, 8 - exponent)) > 255  # would round to 256
    visible = largest > 1e-32
    scale = np.where(visible, np.ldexp(1.0, 8 - exponent), 0)
    pixels = np.zeros((*largest.shape, 4), dtype=np.uint8)
    pixels[..., :3] = np.clip(np.rint(rgb * scale[..., None]), 0, 255)
    pixels[..., 3] = np.where(visible, exponent + 128, 0)
    height, width = largest.shape
    header = f"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y {height} +X {width}\n"
    with open(path, "wb") as file:
        file.write(header.encode("ascii"))
        file.write(pixels.tobytes())


def linear(srgb):
    """What sRGB encodes."""
    return np.where(srgb <= 0.04045, srgb / 12.92, ((srgb + 0.055) / 1.055) ** 2.4)
