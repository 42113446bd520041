// Where photons come from: the lights of a scene, its sky with the surfaces before it, and its
// media.
#pragma once

#include <vector>

#include "render/guide/coarse_cells.h"
#include "render/guide/directional_target.h"
#include "render/guide/photons.h"
#include "render/path/path_setup.h"

namespace pvol::detail {

/// A photon about to fly: its ray in the world and its power.
struct Photon {
  Ray ray;
  Rgb power{0.0f};
  std::size_t source = 0;  ///< number of its light; larger ones are sky, surfaces and media
};

/// The lights of the scene less its constant, to draw photons from in proportion to their power.
/// Some volume of the setup is not empty; it and the cells outlive this.
class PhotonSources {
 public:
  PhotonSources(const PathSetup& setup, const CoarseCells& cells);

  [[nodiscard]] double power() const { return up_to_.back(); }
  /// Towards the light that is strongest in the middle of each row of the cells.
  [[nodiscard]] LightAxes axes() const;

  /// A photon, whose luminance is 1 on average, a share of power(): in units of the world powers
  /// may be beyond what a float holds.
  [[nodiscard]] Photon sample(Rng& rng) const;

 private:
  void add_around();
  void add(double power) { up_to_.push_back((up_to_.empty() ? 0 : up_to_.back()) + power); }
  [[nodiscard]] bool has_fires() const;
  [[nodiscard]] Vec3f axis_in(std::size_t row) const;
  /// A direction of the sky, and a ray from there to the target.
  struct FromAround {
    LightSample sky;
    Ray ray;
  };
  [[nodiscard]] FromAround sample_around(Rng& rng) const;
  [[nodiscard]] Rgb seen_on(const SurfaceHit& surface, Rng& rng) const;
  [[nodiscard]] double component_power();
  void add_fires();
  [[nodiscard]] Photon from_light(const LightSource& source, Rng& rng) const;
  [[nodiscard]] Photon from_around(Rng& rng) const;
  [[nodiscard]] Photon from_media(Rng& rng) const;
  [[nodiscard]] Photon from_fires(Rng& rng) const;

  const PathSetup& s_;
  const CoarseCells& cells_;
  Target target_;
  Vec3f bright_sky_{0, 1, 0};       // unit, to where it is brightest
  double sky_irradiance_ = 0;       // what opposite sides have in common cancels out
  Rgb emitted_;                     // by media at collisions, on average
  std::vector<double> up_to_;       // powers: lights, the sky, media, fires
  std::vector<double> mass_up_to_;  // by row of the cells
};

}  // namespace pvol::detail
