// What a few paths from the camera meet, before anything is rendered.
#pragma once

#include <functional>
#include <vector>

#include "pvol/render/counts.h"
#include "pvol/render/film.h"
#include "pvol/render/plan.h"

namespace pvol::detail {

struct PathSetup;

struct CameraProbe {
  int rays = 0;  ///< evenly over the part of the image that is rendered
  /// Optical depths along those that enter a volume's box, each right on average.
  std::vector<double> depths{};
  int paths = 0;        ///< followed through a small picture
  Counts counts{};      ///< of the paths
  bool cut = false;     ///< whether any was, by collisions: it was longer than is worth following
  double by_depth = 0;  ///< collisions of a path on average, by depths alone (THEORY.md, T6.1)

  /// Whether most paths go to and fro between surfaces until they are cut.
  [[nodiscard]] bool caught() const;
  /// Of a path on average. Where paths were cut, or hardly any collided, depths have a say.
  [[nodiscard]] double collisions() const;
  [[nodiscard]] double followed() const {
    return paths > 0 ? double(counts.collisions) / paths : 0;
  }
};

/// Rays along each edge of a small picture.
inline constexpr int kRaysAlong = 24;

/// Optical depth of a ray up to a distance, or to a surface that the camera sees, by one look-up in
/// each segment: right on average; nothing where it meets no volume's box.
[[nodiscard]] std::optional<double> sample_depth(const PathSetup& setup, const Ray& ray,
                                                 double limit, Rng& rng);

/// Collisions and hits of surfaces after which a path is cut.
inline constexpr std::uint32_t kMostProbed = 256;

/// The plan as paths without a guide take it, with counts.
[[nodiscard]] RenderPlan plain_plan(const RenderPlan& plan);

/// The same of the whole picture, for choices that all parts of it share.
[[nodiscard]] RenderPlan plain_plan_of_whole(const RenderPlan& plan);

/// Follows so many paths of a setup for a plan that plain_plan made, and those that complete a
/// small picture, up to about a million steps; adds what they meet to the probe; visit(film, pixel)
/// after each. Each has a pixel of its own, which all pass in turn. Fewer where enough() is true
/// after one of the small pictures.
void follow_paths(
    const PathSetup& setup, int paths, CameraProbe& probe,
    const std::function<void(const Film&, std::size_t pixel)>& visit,
    const std::function<bool()>& enough = [] { return false; });

/// Needs the kernel of the plan. Its own work is bounded by about a million steps of flights, and
/// by some paths beyond them. Deterministic.
[[nodiscard]] CameraProbe probe_camera(const RenderPlan& plan);

}  // namespace pvol::detail
