// Light of round things on planes.
#pragma once

namespace pvol::detail {

/// Irradiance of a plane over that of one which faces the middle of a disc in the sky of even
/// radiance: `angle` is that between the plane's normal and the disc's middle, `radius` the disc's,
/// in radians, below pi / 2. Above the horizon as a whole the disc counts by the cosine.
[[nodiscard]] double disc_on_plane(double angle, double radius);

}  // namespace pvol::detail
