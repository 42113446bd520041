// Emission of fires and along flights: all that paths ask of it.
#pragma once

#include <memory>

#include "pvol/render/scene.h"
#include "render/light/emission/emission_lights.h"
#include "render/scene/box_tree.h"

namespace pvol::detail {

/// What is integrated along lines: emission, or optical depths.
struct LineSources {
  std::vector<EmissionSource> sources;
  BoxTree tree;  ///< of their boxes

  explicit LineSources(std::vector<EmissionSource> all);
};

/// Everything that emits along flights, made once for a plan.
struct EmissionSetup {
  LineSources lines;  ///< with light that flights gather on their way
  /// Of the fire of each volume, where collisions bring light of it; else null.
  std::vector<std::shared_ptr<const FireAtCollisions>> at_collisions{};
  bool lit = false;           ///< whether anything scatters its light
  EmissionLights lights{{}};  ///< of all that emits, where it is lit
  /// Whether scatterings in volumes, and those on surfaces, sample it as a light besides.
  bool sampled_in_volumes = false, sampled_on_surfaces = false;
};

/// What a pilot notes of light of fires that is scattered in volumes (plan/fire_lights.h).
struct FirePilot {
  /// Sums of the squares that a path has on average of luminance by a scattering, where fires are
  /// sampled as lights and where they are not (THEORY.md, T5.12).
  double sampled = 0, unsampled = 0;
  std::uint64_t flights = 0, pdfs = 0;  ///< of samples of lights; densities of directions
};

/// Notes what a scattered ray brought, whose weight against samples of lights is `share`.
inline void note_hit(FirePilot& pilot, float brought, float share) {
  const double square = double(brought) * double(brought) * double(share);
  pilot.unsampled += square;
  pilot.sampled += square * double(share);
  ++pilot.pdfs;
}

/// The same of the sample of a light: what it brought times its weight, which is its share over the
/// probability with which it was taken.
inline void note_sample(FirePilot& pilot, float brought, float weight) {
  const double square = double(brought) * double(brought);
  pilot.unsampled += square / double(weight);
  pilot.sampled += square;
  ++pilot.flights, ++pilot.pdfs;
}

/// Null where no fire burns and nothing else emits along flights. Samples all as lights, wherever
/// they are scattered.
[[nodiscard]] std::shared_ptr<const EmissionSetup> prepare_emission(std::span<const Volume> volumes,
                                                                    const Scene& scene);

}  // namespace pvol::detail
