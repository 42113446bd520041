// The light that photons bring to the cells of a volume.
#pragma once

#include <algorithm>
#include <array>
#include <atomic>
#include <cstdint>
#include <vector>

#include "render/guide/photons.h"

namespace pvol::detail {

/// Sums of photons as whole numbers, so that the order in which threads add does not matter.
class LightCounts {
 public:
  LightCounts(const IncidentLight& light, std::size_t rows, std::size_t lights, int photons)
      : lights_(lights),
        axes_(light.axes),
        unit_(light.power / (double(photons) * kSteps)),
        counts_(rows * kLightNodes),
        direct_(rows * lights) {}

  void add(std::uint32_t row, Vec3f towards_light, float power) {
    const auto node =
        std::size_t(half_sine(towards_light, axes_.of(row)) * float(kLightNodes - 1) + 0.5f);
    add(counts_[row * std::size_t(kLightNodes) + std::min<std::size_t>(node, kLightNodes - 1)],
        power);
  }

  /// Of a photon that comes straight from its source.
  void add_direct(std::uint32_t row, std::size_t source, float power) {
    if (source < lights_) add(direct_[row * lights_ + source], power);
  }

  [[nodiscard]] std::vector<float> direct() const {
    std::vector<float> all;
    for (const std::uint64_t count : direct_) all.push_back(float(double(count) * unit_));
    return all;
  }

  [[nodiscard]] std::vector<std::array<float, kLightNodes>> sums() const {
    std::vector<std::array<float, kLightNodes>> all(counts_.size() / kLightNodes);
    for (std::size_t i = 0; i < counts_.size(); ++i) {
      all[i / kLightNodes][i % kLightNodes] = float(double(counts_[i]) * unit_);
    }
    return all;
  }

 private:
  static constexpr int kSteps = 1 << 16;                   // per photon of mean power
  static constexpr std::uint64_t kMostSteps = 1ull << 32;  // no photon counts more

  static void add(std::uint64_t& count, float power) {
    const double steps = std::min(double(power) * kSteps, double(kMostSteps));
    std::atomic_ref(count).fetch_add(std::uint64_t(steps), std::memory_order_relaxed);
  }

  std::size_t lights_;
  const LightAxes& axes_;
  double unit_;
  std::vector<std::uint64_t> counts_, direct_;
};

}  // namespace pvol::detail
