// Where the light of a scene goes: photons from its lights, its sky and its media, counted by
// coarse cell and direction.
#pragma once

#include <array>
#include <vector>

#include "pvol/math/pages.h"
#include "render/guide/coarse_cells.h"
#include "render/path/path_setup.h"

namespace pvol::detail {

/// Unit vectors towards the light that is strongest: one for all rows of the cells, where it is as
/// far away as suns and skies are, or one for each.
struct LightAxes {
  PagedVector<Vec3f> by_row;

  [[nodiscard]] Vec3f of(std::size_t row) const { return by_row[is_one() ? 0 : row]; }
  [[nodiscard]] bool is_one() const { return by_row.size() == 1; }
};

/// Directions are told apart by the sine u of half their angle to an axis, in [0, 1]: half the
/// distance of two unit vectors, and finest around the axis. Incident light has this many nodes,
/// node i at u = i / (n - 1).
inline constexpr int kLightNodes = 32;

/// Sine of half the angle between unit vectors.
[[nodiscard]] inline float half_sine(Vec3f a, Vec3f b) { return 0.5f * length(a - b); }

/// The light that arrives in each coarse cell, as estimated by photons, all of it taken to be
/// positive: the luminance of what lights, sky and emission have less or more than `constant`.
struct IncidentLight {
  LightAxes axes;
  double power = 0;  ///< of all photons; 0: there is nothing to guide towards
  /// Power that collides in a cell, by row of the cells and by node of the direction that it comes
  /// from.
  std::vector<std::array<float, kLightNodes>> collided;
  /// The part of it that came straight from each light, by row and light.
  std::vector<float> direct;
};

/// Random numbers of photon i are those of (kPhotonKey, 0, i).
inline constexpr std::uint64_t kPhotonKey = 0x70686f746f6e;
/// Photons that scatter more often have seen all of the cloud.
inline constexpr int kMostPhotonFlights = 1000;
/// Photons of less power go on with probability power / threshold.
inline constexpr float kPhotonRoulette = 0.25f;

/// Traces `photons` photons with the scene's tracker. Some volume is not empty.
/// Deterministic for any number of threads, but where the setup's `stop` ends it early.
[[nodiscard]] IncidentLight trace_photons(const PathSetup& setup, const CoarseCells& cells,
                                          int photons);

}  // namespace pvol::detail
