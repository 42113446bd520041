// Emission that is gathered along flights: all that paths ask of it.
#pragma once

#include <memory>

#include "pvol/render/scene.h"
#include "render/light/emission/power_tree.h"
#include "render/scene/box_tree.h"

namespace pvol::detail {

/// Everything that emits along flights, made once for a plan.
struct EmissionSetup {
  std::vector<EmissionSource> sources;
  BoxTree tree{};             ///< of their boxes
  int points = 1;             ///< of a line, for each leaf on its way
  bool lit = false;           ///< whether scattered light of it is sampled besides
  EmissionLights lights{{}};  ///< of sources, where they are lit
};

/// Null where nothing emits along flights.
[[nodiscard]] std::shared_ptr<const EmissionSetup> prepare_emission(std::span<const Volume> volumes,
                                                                    const Scene& scene);

/// An estimate of what is emitted along a ray of the world up to a distance that may be infinite:
/// as it is, without the extinction in between. Up to the end of a free flight that is right on
/// average, for flights pass a place with the probability of its transmittance (THEORY.md, T5.11).
[[nodiscard]] Rgb emission_along(const EmissionSetup& setup, const Ray& ray, double distance,
                                 Rng& rng);

}  // namespace pvol::detail
