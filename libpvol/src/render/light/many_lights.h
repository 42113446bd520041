// Lights of a scene for drawing some of many, by what each brings to a place, about.
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <type_traits>
#include <vector>

#include "pvol/render/lights.h"
#include "render/light/light_weights.h"

namespace pvol::detail {

/// Lights and groups of lights among which some are drawn: all of those near by, and groups of
/// those further away.
struct LightCut {
  std::vector<float> weights;         ///< by place in groups
  std::vector<std::uint32_t> groups;  ///< numbers of those that are looked into
};

/// Lights of a scene in trees: groups of neighbours, which have groups around them. Points and
/// balls, which shine evenly, are in one, spots and rectangles in another; suns are by themselves.
class ManyLights {
 public:
  explicit ManyLights(std::span<const Light> lights);

  [[nodiscard]] std::size_t suns() const { return suns_; }

  /// Calls ask(number of a light, 1 / expected number of times that it is asked), at most so many
  /// `times`, for lights drawn by what they bring to where they are weighed, times the importance
  /// of that: one of `importances` by number, of a group that of one of its lights, or null where
  /// all are 1 (THEORY.md, T5.19). Suns bring nothing along flights. `cut` is for its own use.
  template <class Where, class Ask>
  void draw(const Where& at, int times, const float* importances, LightCut& cut, Rng& rng,
            const Ask& ask) const;

 private:
  static constexpr std::size_t kGroup = LightGroups::kGroup;

  /// The directions into which a light shines, or all lights of a group.
  struct Cone {
    Vec3d axis;                    ///< of length 1
    double cosine = -1, sine = 0;  ///< of its half angle
    double size = 0;               ///< root of the area of a rectangle
  };
  struct Entry;

  std::vector<LightSource> lights_;
  LightGroups groups_;
  /// For each place in groups the number of its light or, where that is a group, of one light of
  /// it; and the number of the group, 0 of a light.
  std::vector<std::uint32_t> light_, group_;
  std::vector<Cone> cones_;           ///< likewise
  std::vector<std::uint32_t> roots_;  ///< groups that are always looked into: first those of suns
  std::size_t suns_ = 0;              ///< their number: they are in the first places
  std::size_t first_directed_ = 0;    ///< of the groups of spots and rectangles, which are last
  double unit_ = 1;                   ///< of powers

  std::uint32_t add_group();
  void set(std::size_t place, const Entry& e);
  void fill(std::uint32_t group, std::span<Entry> entries);

  /// What the lights of a group bring. Returns which are groups that are to be looked into.
  template <class Where>
  [[nodiscard]] std::uint32_t weigh(std::size_t group, const Where& at, float* to) const;
  [[nodiscard]] float weight_of_sun(std::size_t at, double cosine) const;
  void weigh_suns(std::size_t group, const AtPlace& at, float* to) const;
  void weigh_suns(std::size_t group, const OnPlane& at, float* to) const;
  void weigh_suns(std::size_t, const AlongFlight&, float*) const {}
  /// The share of a light's, or a group's, light in the direction of a place, about.
  [[nodiscard]] float towards(std::size_t at, Vec3d place) const;

  template <class Where>
  void find_cut(const Where& at, LightCut& cut) const;
  /// Of the lights in a place of a group, one: its number, with `factor` over its probability. None
  /// where it is seen that no light of a group arrives.
  template <class Where>
  [[nodiscard]] std::optional<std::uint32_t> draw_of(std::size_t place, const Where& at,
                                                     float& factor, Rng& rng) const;
};

/// The sum, in four parts that a processor adds at once.
[[nodiscard]] inline double sum_of(std::span<const float> values) {
  std::array<double, 4> parts{};
  for (std::size_t i = 0; i < values.size(); ++i) parts[i % 4] += double(values[i]);
  return (parts[0] + parts[1]) + (parts[2] + parts[3]);
}

/// ask(i, 1 / expected number of times that it is asked) for numbers that are drawn by weights: one
/// from each of so many equal parts of their sum.
template <class Ask>
inline void draw_some(std::span<const float> weights, int parts, Rng& rng, const Ask& ask) {
  constexpr std::size_t kBlock = LightGroups::kGroup;  // weights are passed block by block
  const auto block = [&](std::size_t first) {
    return weights.subspan(first, std::min(kBlock, weights.size() - first));
  };
  double sum = 0;
  for (std::size_t i = 0; i < weights.size(); i += kBlock) sum += sum_of(block(i));
  if (!(sum > 0)) return;
  const double part = sum / parts;
  double next = double(rng.uniform()) * part, below = 0;
  int asked = 0;
  for (std::size_t first = 0; first < weights.size() && asked < parts; first += kBlock) {
    double up_to = below;
    below += sum_of(block(first));
    for (std::size_t i = first; i < first + block(first).size() && next < below; ++i) {
      up_to += double(weights[i]);
      for (; asked < parts && weights[i] > 0 && next < up_to; ++asked) {
        ask(i, float(part / double(weights[i])));
        next = (asked + 1 + double(rng.uniform())) * part;
      }
    }
  }
}

template <class Where>
std::uint32_t ManyLights::weigh(std::size_t group, const Where& at, float* to) const {
  const std::uint32_t near = light_kernel().weigh(groups_, group, at, to);
  if (group * kGroup < suns_) weigh_suns(group, at, to);
  if constexpr (!std::is_same_v<Where, AlongFlight>) {
    for (std::size_t k = 0; group >= first_directed_ && k < kGroup; ++k) {
      if (!(to[k] > 0)) continue;
      const float share = towards(kGroup * group + k, at.place);
      to[k] = share > 0 ? std::max(to[k] * share, LightGroups::kLeast) : 0;
    }
  }
  return near;
}

template <class Where>
void ManyLights::find_cut(const Where& at, LightCut& cut) const {
  cut.groups.assign(roots_.begin(), roots_.end());
  for (std::size_t n = 0; n < cut.groups.size(); ++n) {
    const std::size_t group = cut.groups[n];
    cut.weights.resize(kGroup * (n + 1));
    float* const weights = &cut.weights[kGroup * n];
    for (std::uint32_t near = weigh(group, at, weights); near != 0; near &= near - 1) {
      const auto k = std::size_t(std::countr_zero(near));
      weights[k] = 0;
      cut.groups.push_back(group_[kGroup * group + k]);
    }
  }
  cut.weights.resize(kGroup * cut.groups.size());
}

template <class Where>
std::optional<std::uint32_t> ManyLights::draw_of(std::size_t place, const Where& at, float& factor,
                                                 Rng& rng) const {
  while (group_[place] != 0) {
    const std::size_t group = group_[place];
    float weights[kGroup];
    (void)weigh(group, at, weights);
    bool drawn = false;
    draw_some(weights, 1, rng, [&](std::size_t k, float times) {
      place = kGroup * group + k;
      factor *= times;
      drawn = true;
    });
    if (!drawn) return std::nullopt;
  }
  return light_[place];
}

template <class Where, class Ask>
void ManyLights::draw(const Where& at, int times, const float* importances, LightCut& cut, Rng& rng,
                      const Ask& ask) const {
  find_cut(at, cut);
  for (std::size_t n = 0; importances != nullptr && n < cut.groups.size(); ++n) {
    light_kernel().multiply(importances, &light_[kGroup * cut.groups[n]], &cut.weights[kGroup * n]);
  }
  const auto place_of = [&](std::size_t k) { return kGroup * cut.groups[k / kGroup] + k % kGroup; };
  draw_some(cut.weights, times, rng, [&](std::size_t k, float factor) {
    if (const auto light = draw_of(place_of(k), at, factor, rng)) ask(std::size_t(*light), factor);
  });
}

}  // namespace pvol::detail
