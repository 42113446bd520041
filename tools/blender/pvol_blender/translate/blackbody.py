"""The colour of a black body, for constants in node trees; fires have pvol's own."""


def _chromaticity(kelvin):
    """CIE 1931 x and y: the cubic splines of Kim and others (2002), within 1e-3."""
    t = 1000 / min(max(kelvin, 1667), 25000)
    if kelvin < 4000:
        x = ((-0.2661239 * t - 0.2343589) * t + 0.8776956) * t + 0.179910
    else:
        x = ((-3.0258469 * t + 2.1070379) * t + 0.2226347) * t + 0.240390
    if kelvin < 2222:
        y = ((-1.1063814 * x - 1.34811020) * x + 2.18555832) * x - 0.20219683
    elif kelvin < 4000:
        y = ((-0.9549476 * x - 1.37418593) * x + 2.09137015) * x - 0.16748867
    else:
        y = ((3.0817580 * x - 5.87338670) * x + 3.75112997) * x - 0.37001483
    return x, y


def blackbody_color(kelvin):
    """Linear Rec.709 of luminance 1; what falls outside the gamut is cut off at 0."""
    x, y = _chromaticity(kelvin)
    big_x, big_z = x / y, (1 - x - y) / y
    rgb = (
        3.2404542 * big_x - 1.5371385 - 0.4985314 * big_z,
        -0.9692660 * big_x + 1.8760108 + 0.0415560 * big_z,
        0.0556434 * big_x - 0.2040259 + 1.0572252 * big_z,
    )
    return tuple(max(0.0, c) for c in rgb)
