"""Pictures in a viewport. Blender applies the display's colour transform to what engines draw."""

import gpu
import numpy as np
from gpu_extras.presets import draw_texture_2d


class Image:
    """A picture on the graphics card."""

    def __init__(self, pixels):
        """`pixels` is (height, width, 4), linear, rows from below."""
        height, width = pixels.shape[:2]
        flat = np.ascontiguousarray(pixels, dtype=np.float32).ravel()
        buffer = gpu.types.Buffer("FLOAT", len(flat), flat)
        self._texture = gpu.types.GPUTexture((width, height), format="RGBA16F", data=buffer)

    def draw(self, width, height):
        """Over a whole region, however many pixels the picture has."""
        gpu.state.blend_set("ALPHA_PREMULT")
        draw_texture_2d(self._texture, (0, 0), width, height)
        gpu.state.blend_set("NONE")
