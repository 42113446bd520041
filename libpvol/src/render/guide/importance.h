// How much light a path may expect at a place and in a direction, coarsely: it decides where paths
// are ended, split and turned, never their expectation.
#pragma once

#include <algorithm>
#include <array>
#include <optional>
#include <vector>

#include "pvol/math/pages.h"
#include "render/guide/photons.h"

namespace pvol::detail {

/// Directions of flight have this many nodes, node i at half_sine(direction, axis) = i / (n - 1).
inline constexpr int kDirectionNodes = 16;

/// The in-scattered radiance per unit of extinction, averaged over coarse cells and around an axis
/// towards the light that is strongest there, in units of the contribution that a path of
/// throughput 1 should have (THEORY.md, T5.5). Never 0.
class Importance {
 public:
  struct alignas(64) Row {  // in a cache line
    std::array<float, kDirectionNodes> at;
    /// Of a direction of flight.
    [[nodiscard]] float of(float half_sine) const {
      const float x = half_sine * float(kDirectionNodes - 1);
      const int i = std::min(int(x), kDirectionNodes - 2);
      const auto k = std::size_t(i);
      return at[k] + (at[k + 1] - at[k]) * (x - float(i));
    }
    /// Whether paths should be turned towards the axis.
    [[nodiscard]] bool turns() const { return at.front() > 2 * at.back(); }
  };

  Importance(CoarseCells cells, LightAxes axes, HenyeyGreenstein lobe, PagedVector<Row> rows,
             std::vector<float> shadow_importance)
      : cells_(std::move(cells)),
        rows_(std::move(rows)),
        shadow_importance_(std::move(shadow_importance)),
        axes_(std::move(axes)),
        lobe_(lobe) {}

  /// Of a place of a traversal.
  template <class Place>
  [[nodiscard]] const Row& row(const Place& place) const {
    return rows_[cells_.row(place)];
  }
  /// Importance of a shadow ray from there, by light and then for the sky, in units of about the
  /// plain tracer's shadow unit: the more of them arrive, the more.
  [[nodiscard]] const float* shadow_importance(const Row& row) const {
    const auto lights = shadow_importance_.size() / rows_.size();
    return shadow_importance_.data() + std::size_t(&row - rows_.data()) * lights;
  }
  /// Of a direction of flight, to the axis of a row.
  [[nodiscard]] float half_sine(const Row& row, Vec3f direction) const {
    return detail::half_sine(direction, axes_.of(std::size_t(&row - rows_.data())));
  }
  [[nodiscard]] const LightAxes& axes() const { return axes_; }
  // The tables themselves, for kernels that read them in lanes.
  [[nodiscard]] const CoarseCells& cells() const { return cells_; }
  [[nodiscard]] const PagedVector<Row>& rows() const { return rows_; }
  [[nodiscard]] const float* shadow_importances() const { return shadow_importance_.data(); }

  /// About the axis: where paths that are turned should go.
  [[nodiscard]] const HenyeyGreenstein& lobe() const { return lobe_; }

 private:
  CoarseCells cells_;
  PagedVector<Row> rows_;
  std::vector<float> shadow_importance_;  // by row and light
  LightAxes axes_;
  HenyeyGreenstein lobe_;
};

/// Estimates it for the volumes of the setup, whose `constant` is that of guided paths; nothing
/// where no light but the constant falls on them or the camera does not see them.
/// Deterministic for any number of threads.
[[nodiscard]] std::optional<Importance> make_importance(const PathSetup& setup);

/// Makes the setup one of guided paths, where there is something to guide them by.
/// Nothing is guided once it says stop.
void guide_paths(const RenderPlan& plan, PathSetup& setup);

}  // namespace pvol::detail
