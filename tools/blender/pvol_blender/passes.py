"""The layers of pvol as passes of Blender."""

from dataclasses import dataclass

from .translate.lights import group_of


@dataclass(frozen=True)
class Pass:
    layer: str  # of pvol
    name: str  # in Blender's compositor
    channels: str
    about: str

    @property
    def kind(self):
        """As Blender calls it."""
        return {"RGB": "COLOR", "XYZ": "VECTOR"}.get(self.channels, "VALUE")


# With one pass each. `depth`, `normal` and `position` have the names of Blender's own passes.
PASSES = (
    Pass("depth", "Depth", "Z", "Depth of first collisions along the camera's axis, mean"),
    Pass("nearest", "Nearest Depth", "Z", "Depth of the nearest first collision"),
    Pass("position", "Position", "XYZ", "Position of first collisions in the world"),
    Pass("normal", "Normal", "XYZ", "Direction in which extinction falls at first collisions"),
    Pass("albedo", "Albedo", "RGB", "Albedo at first collisions"),
    Pass("velocity", "Velocity", "XYZ", "How far what first collisions hit moves in a frame"),
    Pass("transmittance", "Transmittance", "Y", "Share of the background that is visible"),
    Pass("transmittance_rgb", "Transmittance RGB", "RGB",
         "The same by channel: coloured shadows on a catcher"),
    Pass("variance", "Variance", "RGB", "Variance of each pixel's mean colour"),
    Pass("samples", "Samples", "Y", "Number of camera samples"),
)
# With several passes each.
SETS = (
    ("lights", "Lights", "Light by source: one pass for each lamp or light group, the sky and "
                         "emission. Together they are the picture"),
    ("scattering", "Scattering", "Light by number of scatterings: unscattered, single, multiple"),
)
NOISY = Pass("noisy", "Noisy Image", "RGB", "The picture before it was filtered")
OF_THE_FILTER = {"noisy_variance", "half_1", "half_2"}
# pvol always has these.
FREE = {"transmittance", "variance", "samples"}


def aovs(chosen):
    """What pvol is asked for, of the chosen layers."""
    return sorted(set(chosen) - FREE)


def colour_pass(layer):
    """The pass of one of the layers of a set: `sun_1` is "Light sun_1"."""
    if layer in ("unscattered", "single", "multiple"):
        return Pass(layer, f"Scattering {layer}", "RGB", "")
    return Pass(layer, f"Light {layer}", "RGB", "")


def chosen_passes(chosen, scene, denoised):
    """The passes of a render, before it has been made."""
    passes = [p for p in PASSES if p.layer in chosen]
    if "lights" in chosen:
        groups = {group_of(o) for o in scene.objects if o.type == "LIGHT"}
        passes += [colour_pass(g) for g in sorted(groups | {"sky", "emission"})]
    if "scattering" in chosen:
        passes += [colour_pass(s) for s in ("unscattered", "single", "multiple")]
    if denoised:
        passes.append(NOISY)
    return passes
