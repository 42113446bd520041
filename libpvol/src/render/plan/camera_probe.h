// What a few paths from the camera meet, before anything is rendered.
#pragma once

#include <functional>
#include <vector>

#include "pvol/render/counts.h"
#include "pvol/render/plan.h"

namespace pvol::detail {

struct PathSetup;

struct CameraProbe {
  int rays = 0;  ///< evenly over the part of the image that is rendered
  /// Optical depths along those that enter a volume's box, each right on average.
  std::vector<double> depths{};
  int paths = 0;    ///< followed along the first of the rays, in scattered order
  Counts counts{};  ///< of the paths
  int caught = 0;   ///< paths that went to and fro between surfaces until they were cut
  /// Of those among them that were cut, being longer than is worth following.
  Counts cut_counts{};
  double by_depth = 0;  ///< collisions of a path on average, by depths alone (THEORY.md, T6.1)

  /// Of a path on average. Where paths were cut, or hardly any collided, depths have a say.
  [[nodiscard]] double collisions() const;
  [[nodiscard]] double followed() const {
    return paths > 0 ? double(counts.collisions) / paths : 0;
  }
};

/// The plan as plain paths of the scalar tracers take it, with counts.
[[nodiscard]] RenderPlan plain_plan(const RenderPlan& plan);

/// Pixels of a probe, evenly over a picture.
[[nodiscard]] int count_pixels(const RenderPlan& plan);

/// Follows so many paths of a plan that plain_plan made, one through each pixel of a probe and
/// again, up to about a million steps, and adds what they meet to it; visit(radiance) after each.
void follow_paths(const RenderPlan& plain, const PathSetup& setup, int paths, CameraProbe& probe,
                  const std::function<void(Rgb)>& visit);

/// Needs the kernel of the plan. Its own work is bounded by about a million steps of
/// flights, and by one path beyond them. Deterministic.
[[nodiscard]] CameraProbe probe_camera(const RenderPlan& plan);

}  // namespace pvol::detail
