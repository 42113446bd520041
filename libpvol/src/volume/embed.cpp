// The calls that are complete in themselves, compiled once.
#include "pvol/embed.h"

#include <cmath>
#include <memory>
#include <type_traits>

#include "density/check_grid.h"
#include "pvol/bounds/pyramid.h"
#include "pvol/bounds/recipe_bounds.h"
#include "pvol/density/recipe.h"
#include "pvol/trackers.h"
#include "pvol/volume/counted_rays.h"
#include "pvol/volume/make_volume.h"
#include "volume/any_source.h"
#include "volume/cell_look_up.h"
#include "volume/check_estimator.h"
#include "volume/flights.h"

namespace pvol {
namespace {

[[nodiscard]] detail::Flights flights_of(const VolumeField& f) {
  return detail::find_flights(detail::kind_of(f));
}

[[noreturn]] void refuse_closed_form() {
  throw Error(
      "the optical depth has a closed form for nearest and trilinear interpolation alone, where "
      "the density has no map and does not move; choose another estimator or tracker for this "
      "volume");
}

}  // namespace

void detail::check_estimator(const Volume& volume, Transmittance estimator) {
  if (estimator == Transmittance::automatic) {
    throw Error(
        "sample_transmittance does not accept the automatic estimator; call choose_transmittance "
        "once and pass its result");
  }
  const VolumeField& f = volume.density;
  const bool closed = has_closed_form(f.look_up) && f.map == nullptr && f.motion == nullptr;
  if (estimator == Transmittance::regular && !closed) refuse_closed_form();
}

Volume make_volume(const VoxelGrid& grid, const Medium& medium, const VolumeOptions& options) {
  detail::check_cubes(grid);
  detail::check_disjoint(grid);
  return make_volume(grid, build_pyramid(grid, options.look_up), medium, options);
}

Volume make_volume(const Recipe& recipe, const Medium& medium, const VolumeOptions& options) {
  return make_volume(std::make_shared<const Recipe>(recipe), build_pyramid(recipe), medium,
                     options);
}

Flight sample_flight(const Volume& volume, const Ray& ray, double t_max, Rng& rng) {
  Tally unused;
  return sample_flight(volume, ray, t_max, rng, Tracker::decomposition, unused);
}

Flight sample_flight(const Volume& volume, const Ray& ray, double t_max, Rng& rng, Tracker tracker,
                     Tally& tally) {
  if (tracker == Tracker::regular) detail::check_estimator(volume, Transmittance::regular);
  auto walk = enter(volume, ray, t_max);
  if (!walk) return {};
  detail::FlightMonitor monitor{tally};
  Flight flight =
      flights_of(volume.density).fly(tracker, volume.density, walk->local(), rng, monitor);
  tally = monitor;
  if (flight.collided) flight.t = walk->world(flight.t);
  return flight;
}

float sample_transmittance(const Volume& volume, const Ray& ray, double t_max, Rng& rng,
                           Transmittance estimator) {
  Tally unused;
  return sample_transmittance(volume, ray, t_max, rng, estimator, unused);
}

float sample_transmittance(const Volume& volume, const Ray& ray, double t_max, Rng& rng,
                           Transmittance estimator, Tally& tally) {
  detail::check_estimator(volume, estimator);
  auto walk = enter(volume, ray, t_max);
  if (!walk) return 1;
  const Tracker tracker =
      estimator == Transmittance::analog ? Tracker::decomposition : Tracker::delta;
  detail::FlightMonitor monitor{tally};
  const float passed =
      flights_of(volume.density)
          .transmittance(estimator, tracker, volume.density, walk->local(), rng, monitor);
  tally = monitor;
  return passed;
}

double exact_optical_depth(const Volume& volume, const Ray& ray, double t_max, Tally& tally) {
  detail::check_estimator(volume, Transmittance::regular);
  auto walk = enter(volume, ray, t_max);
  if (!walk) return 0;
  return visit_field(volume, [&](const auto& field) -> double {
    if constexpr (CellField<std::remove_cvref_t<decltype(field)>>) {
      return optical_depth(*walk, field, tally);
    }
    refuse_closed_form();
  });
}

double exact_transmittance(const Volume& volume, const Ray& ray, double t_max) {
  Tally unused;
  return std::exp(-exact_optical_depth(volume, ray, t_max, unused));
}

namespace {

float density_in_cells(const Volume& volume, Vec3d cells, float time = 0) {
  const Octree& tree = volume.density.octree;
  if (tree.empty() || !tree.support().contains(cells)) return 0;
  const LatticePoint p = lattice_point(tree, cells);
  const LeafHandle leaf = detail::leaf_at(volume.density, p.cell);
  return detail::density_at_time(volume.density, leaf, p, time);
}

}  // namespace

float detail::extinction_in_cells(const Volume& volume, Vec3d cells, float time) {
  return volume.density.scale * density_in_cells(volume, cells, time);
}

float density_at(const Volume& volume, Vec3d world) {
  return density_in_cells(volume, volume.density.world_to_cells.point(world));
}

float extinction_at(const Volume& volume, Vec3d world) {
  return volume.density.scale * density_at(volume, world);
}

}  // namespace pvol
