// What pictures must agree with: paths by the definitions of transport, without bounds of leaves,
// shells, lanes, guides or any other thing that makes pvol fast. It shares with the library
// vectors, maps, boxes, random numbers and the phase functions of components, which have tests of
// their own.
#pragma once

#include <cstdint>

#include "pvol/render/film.h"
#include "support/reference_scene.h"

namespace pvol::test {

/// The picture of a scene, channel by channel as of a grey one of that channel: its options of
/// size, bounces, background and look-up count, those of estimators do not.
///
/// Extinction, albedo and emission are functions of place, time and channel, summed over volumes at
/// all their places. Flights take tentative collisions of one majorant through a box around all
/// volumes; emission is gathered at each; shadow rays multiply what tentative collisions let
/// through. Lights and suns are met by shadow rays alone, but for those that the camera sees; skies
/// by paths alone. Pixels are their means over a square.
///
/// For scenes with perspective cameras without a lens, surfaces that are planes, balls and meshes (among
/// them holdouts, and shadow catchers that are planes, which all lights shine on from above their
/// horizon), and skies that are constant, gradients or pictures.
[[nodiscard]] Film reference_film(const ReferenceScene& scene, std::uint32_t samples,
                                  std::uint64_t seed);

}  // namespace pvol::test
