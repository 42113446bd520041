// What a thread keeps while it traces a batch of samples in lanes.
#pragma once

#include <array>
#include <vector>

#include "pvol/render/counts.h"
#include "render/engine/wavefront/exact_sum.h"
#include "render/engine/wavefront/path_fields.h"
#include "render/engine/wavefront/world_rays.h"
#include "render/path/film_layers.h"
#include "render/path/gather_light.h"
#include "volume/simd/flight_memory.h"

namespace pvol::detail {

/// Samples of a batch: each has a slot with its sums.
class Slots {
 public:
  /// `setup` outlives this.
  explicit Slots(const PathSetup& setup)
      : setup_(setup),
        result_(setup),
        colours_(1 + result_.layers.size() + result_.orders.size()) {}

  void start(std::size_t count) {
    sums_.assign(count * colours_ * 3, {});
    collided_.assign(count, {});
    alpha.assign(count, 0);
    counts.assign(count, {});
    if (setup_.first_collisions) first.assign(count, {});
  }

  /// Calls add(result) with an empty result, and adds what it then holds to the slot: light that
  /// was scattered so often.
  template <class Add>
  void add(std::uint32_t slot, std::uint32_t scatterings, const Add& add) {
    result_.reset();
    add(result_);
    ExactSum* sums = &sums_[slot * colours_ * 3];
    add_colour(sums, result_.radiance);
    for (const Rgb& part : result_.layers) add_colour(sums += 3, part);
    if (result_.orders.empty()) return;
    add_colour(sums + 3 * (1 + std::min<std::size_t>(scatterings, PathResult::kOrders - 1)),
               result_.radiance);
  }

  /// Adds the weight of a path that collided, where there is but one component: what that emits is
  /// added at the end.
  void add_collision(std::uint32_t slot, float weight) { collided_[slot].add(weight); }

  [[nodiscard]] const PathResult& result(std::size_t slot) {
    const ExactSum* sums = &sums_[slot * colours_ * 3];
    result_.radiance = colour(sums);
    for (Rgb& part : result_.layers) part = colour(sums += 3);
    for (Rgb& part : result_.orders) part = colour(sums += 3);
    if (const double weight = collided_[slot].value(); weight != 0) {
      const MediumComponent& component = setup_.volumes.front().components.front();
      add_emitted(setup_, everywhere(component), Rgb(float(weight)), result_);
    }
    result_.alpha = alpha[slot];
    result_.first_weight = 0;
    if (setup_.first_collisions && alpha[slot] > 0) {
      result_.first = first[slot], result_.first_weight = 1;
    }
    return result_;
  }

  std::vector<float> alpha;
  std::vector<Vec3d>
      first;  ///< place of the first collision in the world, where they are asked for
  std::vector<std::array<std::uint32_t, kPixelCounts.size()>> counts;  ///< where they are asked for

 private:
  const PathSetup& setup_;
  PathResult result_;
  std::size_t colours_;
  std::vector<ExactSum> sums_, collided_;

  static void add_colour(ExactSum* sums, Rgb c) {
    for (int k = 0; k < 3; ++k) sums[k].add(c[k]);
  }
  [[nodiscard]] static Rgb colour(const ExactSum* sums) {
    return {float(sums[0].value()), float(sums[1].value()), float(sums[2].value())};
  }
};

/// What rays do, each kind with queues of its own.
enum class RayKind : std::size_t { camera, path, shadow, to_fire };
inline constexpr std::size_t kRayKinds = 4;

struct WavefrontMemory : FlightMemory {
  Records camera{kPathFields}, paths{kPathFields}, shadows{kPathFields};  ///< that wait to fly
  Records to_fires{kPathFields};  ///< likewise, towards fires
  Records collisions{kPathFields}, straight{kPathFields}, turned{kPathFields};
  Records fire_ends{kPathFields};  ///< collisions of those towards fires
  Slots slots;
  Counts counts;

  // Through many volumes:
  WorldRays rays;
  std::vector<std::array<Records, kRayKinds>> queues;  ///< that wait to fly, by volume
  std::vector<Records> hits;                           ///< collisions of paths, by volume
  Records arrived{kPathFields};                        ///< tentative collisions that were real

  explicit WavefrontMemory(const PathSetup& setup) : FlightMemory(kPathFields), slots(setup) {
    if (!fly_in_the_world(setup)) return;
    constexpr std::size_t kFew = 64;
    for (std::size_t i = 0; i < setup.volumes.size(); ++i) {
      queues.push_back({Records(kPathFields, kFew), Records(kPathFields, kFew),
                        Records(kPathFields, kFew), Records(kPathFields, kFew)});
      hits.emplace_back(kPathFields, kFew);
    }
  }
};

/// Numbers of samples in a batch go into 16 bits of a record's id.
inline constexpr std::uint32_t kMostSlots = 1u << 16;
[[nodiscard]] inline std::uint32_t slot_of(std::uint32_t id) { return id & (kMostSlots - 1); }
/// Above them, collisions of a path, where they are counted.
[[nodiscard]] inline std::uint32_t number_of(std::uint32_t id) { return id >> 16; }
/// Of a shadow ray the number of its light, and how often its light will have been scattered, up to
/// 2, where that is counted.
inline constexpr std::uint32_t kMostWavefrontLights = (1u << 14) - 1;  // the sky comes last
[[nodiscard]] inline std::uint32_t light_of(std::uint32_t id) {
  return id >> 16 & kMostWavefrontLights;
}
[[nodiscard]] inline std::uint32_t scatterings_of(std::uint32_t id) { return id >> 30; }

}  // namespace pvol::detail
