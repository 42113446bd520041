// Fireflies: pixels that a few rare samples made far brighter than all around them. Their light is
// right on average, but where it stands it is nothing but noise, and tilts the planes that the
// filter fits. It is taken away and spread over the surroundings. Based on: DeCoro et al.
// Density-based Outlier Rejection in Monte Carlo Rendering. 2010; we keep the light that they leave
// out (THEORY.md, T5.21).
#pragma once

#include <array>

#include "render/denoise/plane.h"

namespace pvol::detail {

/// A picture by its two halves, in planes by channel.
struct TwoHalves {
  std::array<Planes, 2> values;
  Planes variances;  ///< of the mean of both halves, of the pixel's own samples
};

/// What was found and spread.
struct Fireflies {
  std::size_t pixels = 0;
  Plane others;  ///< 0 for those pixels, 1 for all others
};

/// Takes the light of fireflies, channel by channel, down to what is around them, and spreads it in
/// proportion to the light that is there, within the same half: so widely that it raises that by
/// little. Where all around is black, it stays. `where` is 1 for pixels that may be changed, else
/// 0. Of each channel and half the sum of all pixels stays what it was but for rounding. Margins
/// are not filled.
[[nodiscard]] Fireflies spread_fireflies(TwoHalves& picture, const Plane& where);

/// The same for a channel of a part of that picture: of its fireflies, what is above the mean
/// around them is spread.
void spread_part(Plane& part, const Fireflies& fireflies, const Plane& where);

}  // namespace pvol::detail
