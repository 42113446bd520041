// What a thread keeps while it traces a batch of samples in lanes.
#pragma once

#include <algorithm>
#include <array>
#include <optional>
#include <vector>

#include "pvol/render/counts.h"
#include "render/engine/wavefront/exact_sum.h"
#include "render/engine/wavefront/path_fields.h"
#include "render/engine/wavefront/world_rays.h"
#include "render/path/camera_rays.h"
#include "render/path/film_layers.h"
#include "render/path/gather_light.h"
#include "render/path/lamps_along.h"
#include "render/path/open_light.h"
#include "volume/simd/entering_rays.h"
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
    if (setup_.pixel_importance || setup_.surfaces) importance.assign(count, 1);
    counts.assign(count, {});
    if (setup_.first_collisions) first.assign(count, {});
    if (setup_.moving) times.assign(count, 0);
    if (setup_.weighs) dimmed_.assign(count, {});
    if (!setup_.surfaces) return;
    seen.assign(count, {});
    if (setup_.surfaces->camera->catch_shadows()) caught_.assign(count, {});
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

  /// What lies behind the volume is seen through it, with a weight by channel.
  void dim(std::uint32_t slot, Rgb weight) {
    const float mean = mean_of(weight);
    alpha[slot] = 1 - mean;
    dimmed_[slot].tint = weight - Rgb(mean);
  }
  /// Of the flight to the first collision, where that has one.
  void note_first_weight(std::uint32_t slot, Rgb weight) {
    dimmed_[slot].first_weight = mean_of(weight);
  }

  /// A shadow catcher before the camera, seen with this weight: with the direction towards it, and
  /// the light that it would scatter if it were white and nothing were in the way.
  void see_catcher(std::uint32_t slot, Vec3f direction, Rgb open, Rgb weight) {
    alpha[slot] = 1;
    caught_[slot] = {.any = true, .seen = direction, .weight = weight, .open = open};
  }

  /// Calls add(result) with an empty result: what it then holds is light that reached the slot's
  /// shadow catcher unscattered.
  template <class Add>
  void add_caught(std::uint32_t slot, const Add& add) {
    result_.reset();
    add(result_);
    add_colour(caught_[slot].direct.data(), result_.radiance);
  }

  [[nodiscard]] const PathResult& result(std::size_t slot) {
    const ExactSum* sums = &sums_[slot * colours_ * 3];
    result_.radiance = colour(sums);
    for (Rgb& part : result_.layers) part = colour(sums += 3);
    for (Rgb& part : result_.orders) part = colour(sums += 3);
    if (const double weight = collided_[slot].value(); weight != 0) {
      add_emitted(setup_, setup_.volumes.front().mean, Rgb(float(weight)), result_);
    }
    result_.alpha = alpha[slot];
    if (setup_.moving) result_.time = times[slot];
    result_.first_weight = 0;
    if (setup_.first_collisions && alpha[slot] > 0) {
      result_.first = first[slot], result_.first_weight = 1;
    }
    if (setup_.weighs) {
      result_.tint = dimmed_[slot].tint;
      if (result_.first_weight > 0) result_.first_weight = dimmed_[slot].first_weight;
    }
    if (!seen.empty()) {
      const SeenSurface& met = seen[slot];
      result_.first_material = met.material, result_.first_normal = met.normal;
      result_.first_moves = met.moves;
    }
    if (!caught_.empty()) subtract_caught(caught_[slot]);
    return result_;
  }

  /// That of a slot's pixel.
  void note_pixel(std::uint32_t slot, int x, int y) {
    if (!setup_.pixel_importance) return;
    const RenderOptions& o = setup_.options;
    importance[slot] = setup_.pixel_importance->of((x + 0.5) / o.width, (y + 0.5) / o.height);
  }
  /// That of a slot whose camera ray has met a surface of this albedo, where that of pixels is not
  /// known: what is dark shows its noise as well as what is bright.
  void note_albedo(std::uint32_t slot, float albedo) {
    if (!setup_.pixel_importance) importance[slot] = 1 / std::clamp(albedo, kPathRoulette, 1.0f);
  }
  [[nodiscard]] float importance_of(std::uint32_t slot) const {
    return importance.empty() ? 1 : importance[slot];
  }

  std::vector<float> alpha;
  std::vector<float> importance;      ///< of pixels; none: all have 1
  std::vector<FirstCollision> first;  ///< where they are asked for
  std::vector<float> times;           ///< of samples, in frames, where anything moves
  struct SeenSurface {
    const Material* material = nullptr;  ///< null: the camera sees none
    Vec3d normal{};
    const MovingMap* moves = nullptr;
  };
  std::vector<SeenSurface> seen;                                       ///< where there are surfaces
  std::vector<std::array<std::uint32_t, kPixelCounts.size()>> counts;  ///< where they are asked for

 private:
  const PathSetup& setup_;
  PathResult result_;
  std::size_t colours_;
  std::vector<ExactSum> sums_, collided_;
  struct Caught {
    bool any = false;
    Vec3f seen{};
    Rgb weight{1.0f};
    Rgb open{0.0f};
    std::array<ExactSum, 3> direct{};
  };
  std::vector<Caught> caught_;
  struct Dimmed {
    Rgb tint{0.0f};
    float first_weight = 0;
  };
  std::vector<Dimmed> dimmed_;  // where flights have weights

  [[nodiscard]] static float mean_of(Rgb c) {
    return c.x + ((c.y - c.x) + (c.z - c.x)) / 3;  // of grey its value
  }

  /// Takes what arrived unscattered off what a shadow catcher covers; where nothing ever does,
  /// there is no shadow, and it covers nothing (THEORY.md, T5.18).
  void subtract_caught(const Caught& c) {
    result_.background = Rgb(0.0f);
    if (!setup_.weighs) result_.tint = Rgb(0.0f);
    if (!c.any) return;
    result_.first_weight = 0;
    Rgb shares = c.weight;
    float share = luminance(shares);
    if (const float open = luminance(c.open); open > 0) {
      const Rgb direct = colour(c.direct.data()) * c.weight;
      share = luminance(direct) / open;
      shares = Rgb(share);
      for (int k = 0; k < 3; ++k) {
        if (c.open[k] > 0) shares[k] = direct[k] / c.open[k];
      }
    }
    result_.alpha = 1 - share;
    result_.tint = shares - Rgb(share);
    if (!setup_.options.background) return;
    const Rgb before = result_.radiance;
    add_seen(setup_, c.seen, shares, result_);
    result_.background = result_.radiance - before;
    if (!result_.orders.empty()) result_.orders.front() += result_.background;
  }

  static void add_colour(ExactSum* sums, Rgb c) {
    for (int k = 0; k < 3; ++k) sums[k].add(c[k]);
  }
  [[nodiscard]] static Rgb colour(const ExactSum* sums) {
    return {float(sums[0].value()), float(sums[1].value()), float(sums[2].value())};
  }
};

/// A shadow ray from a flight to a lamp, in the world.
struct LampRay {
  Vec3d from;
  Vec3f direction;
  double distance;
  Rgb weight;
  std::uint32_t id;
};

/// Rays of the camera that are about to start, in the order of their samples' slots.
struct CameraRays {
  using Numbers = std::array<std::uint32_t, EnteringRays::kMost>;

  EnteringRays rays;
  std::array<PixelSample, EnteringRays::kMost> sample;
  Numbers number;                               ///< those of the samples
  std::array<Numbers, 3> seeds;                 ///< of points for their pixels
  std::array<float, EnteringRays::kMost> u, v;  ///< these points
  EnteringRays::Row x, y;                       ///< places on the picture, in pixels
  std::size_t next = 0;                         ///< the first ray that has not started
  std::uint32_t slots = 0;                      ///< that samples have taken

  void clear() { rays.n = 0, next = 0, slots = 0; }
  [[nodiscard]] bool any() const { return next < rays.n; }
};

/// By channel, of each path of a register.
using PathColors = std::array<std::array<float, kMostLanes>, 3>;

/// A light that a surface asks, with volumes in the way, perhaps.
struct LightThroughVolumes {
  std::size_t number;
  Vec3f direction;
  double distance;
  Rgb weight, own;  ///< of a shadow ray's weight, and the light's radiance
};

struct WavefrontMemory : FlightMemory {
  CameraRays starting;
  Records camera{kPathFields}, paths{kPathFields}, shadows{kPathFields};  ///< that wait to fly
  Records to_fires{kPathFields};  ///< likewise, towards fires
  Records collisions{kPathFields}, straight{kPathFields}, turned{kPathFields};
  Records fire_ends{kPathFields};  ///< collisions of those towards fires
  Slots slots;
  PixelRows rows;
  ExactSums sums;  // of the pixel that samples are added to
  Counts counts;
  LightCut light_cut;                                     ///< for drawing some of many
  std::vector<std::optional<CollidingFlight>> colliding;  ///< of a register, for lamps
  PathColors colors{};                                    ///< of one, where albedos vary
  PathColors fire{};                                      ///< what one brings at collisions of one

  // Through many volumes:
  WorldRays rays;
  std::vector<std::vector<Records>> queues;        ///< that wait to fly, by volume and kind
  std::vector<Records> hits;                       ///< collisions of paths, by volume
  Records arrived{kPathFields};                    ///< tentative collisions that were real
  std::vector<std::uint32_t> others;               ///< of those, what is not within an instance
  Records sent{kPathFields};                       ///< the record of a ray that is about to be sent
  Records met{kPathFields}, meeting{kPathFields};  ///< paths that have met a surface
  /// A shadow ray that is to be sent, with random numbers of its own.
  struct ToLamp {
    LampRay ray;
    float time;
    Rng rng;
  };
  std::vector<ToLamp> to_lamps;
  std::vector<LightThroughVolumes> through_volumes;  ///< of a path on a surface
  std::vector<float> brought;                        ///< by these
  OpenLight open_light;                              ///< on shadow catchers

  explicit WavefrontMemory(const PathSetup& setup) : FlightMemory(kPathFields), slots(setup) {
    if (!fly_in_the_world(setup)) return;
    constexpr std::size_t kFew = 64;
    queues.resize(setup.volumes.size());
    for (auto& kinds : queues) {
      for (std::size_t k = 0; k < kRayKinds; ++k) kinds.emplace_back(kPathFields, kFew);
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
static_assert(kMostLights == (1u << 14) - 1);  // the sky comes last
[[nodiscard]] inline std::uint32_t light_of(std::uint32_t id) {
  return id >> 16 & std::uint32_t(kMostLights);
}
[[nodiscard]] inline std::uint32_t scatterings_of(std::uint32_t id) { return id >> 30; }

}  // namespace pvol::detail
