#include "render/light/many_lights.h"

#include <cmath>
#include <numbers>
#include <utility>

#include "render/light/lamp.h"
#include "render/scene/boxes.h"

namespace pvol::detail {

/// A light in a place.
struct ManyLights::Entry {
  std::uint32_t light;
  Vec3d place;
  double power;
  Vec3d axis;             ///< unit
  double half_angle = 0;  ///< around it, into which it shines
  double size = 0;

  Entry(std::uint32_t number, const Lamp& lamp, const Light& l)
      : light(number), place(lamp.position), power(lamp.power) {
    if (const auto* const spot = std::get_if<SpotLight>(&l)) {
      axis = normalize(spot->direction);
      half_angle = spot->angle / 2 * std::numbers::pi / 180;
    } else if (const auto* const area = std::get_if<AreaLight>(&l)) {
      axis = normalize(area->direction);
      half_angle = std::numbers::pi / 2;
      size = std::sqrt(area->size[0] * area->size[1]);
    }
  }
  [[nodiscard]] bool shines_evenly() const { return half_angle == 0; }
};

ManyLights::ManyLights(std::span<const Light> lights) : lights_(make_light_sources(lights)) {
  std::vector<Entry> even, directed;
  double most = 0;
  for (std::size_t i = 0; i < lights.size(); ++i) {
    const Entry e(std::uint32_t(i), lamp_of(lights_[i]), lights[i]);
    most = std::max(most, e.power);
    if (std::holds_alternative<Sun>(lights[i])) {
      if (suns_ % kGroup == 0) roots_.push_back(add_group());
      light_[suns_++] = e.light;
    } else if (e.power > 0) {  // a lamp that is black is never drawn
      (e.shines_evenly() ? even : directed).push_back(e);
    }
  }
  if (most > 0) unit_ = most;
  for (std::vector<Entry>* all : {&even, &directed}) {
    if (all == &directed) first_directed_ = groups_.count_groups();
    // A lamp, however faint, is drawn at times.
    for (Entry& e : *all) e.power = std::max(e.power / most, 1e-20);
    if (all->empty()) continue;
    roots_.push_back(add_group());
    fill(roots_.back(), *all);
  }
}

std::uint32_t ManyLights::add_group() {
  const std::size_t number = groups_.count_groups();
  groups_.add_group();
  light_.resize(groups_.power.size());
  group_.resize(groups_.power.size());
  cones_.resize(groups_.power.size());
  return std::uint32_t(number);
}

void ManyLights::set(std::size_t place, const Entry& e) {
  for (int axis = 0; axis < 3; ++axis) groups_.place[std::size_t(axis)][place] = e.place[axis];
  groups_.power[place] = float(e.power);
  light_[place] = e.light;
  cones_[place] = {e.axis, std::cos(e.half_angle), std::sin(e.half_angle), e.size};
}

namespace {

/// Parts of neighbours, at most so many: the largest is halved across its longest side until there
/// are enough. What fits into one of them stays together, unless all does.
template <class Entry>
[[nodiscard]] std::vector<std::span<Entry>> divide(std::span<Entry> entries, std::size_t most) {
  const std::size_t enough = entries.size() <= most ? 1 : most;
  std::vector<std::span<Entry>> parts{entries};
  while (parts.size() < most) {
    const auto largest = std::ranges::max_element(parts, {}, &std::span<Entry>::size);
    const std::span<Entry> part = *largest;
    if (part.size() <= enough) break;
    Box box;
    for (const Entry& e : part) box = extend(box, e.place);
    const int axis = longest_axis(box);
    const auto middle = part.begin() + std::ptrdiff_t(part.size() / 2);
    std::nth_element(part.begin(), middle, part.end(), [&](const Entry& a, const Entry& b) {
      return std::pair(a.place[axis], a.light) < std::pair(b.place[axis], b.light);
    });
    *largest = {part.begin(), middle};
    parts.emplace_back(middle, part.end());
  }
  return parts;
}

/// All as one; the size is left to be that of the first.
template <class Entry>
[[nodiscard]] Entry joined(std::span<const Entry> entries) {
  Entry all = entries.front();
  all.power = 0, all.place = all.axis = Vec3d(0.0);
  for (const Entry& e : entries) {
    all.power += e.power;
    all.place = all.place + e.place * e.power;
    all.axis = all.axis + e.axis;
  }
  all.place = all.place / all.power;
  if (all.half_angle == 0) return all;  // they shine evenly
  const double sum = length(all.axis);
  all.axis = sum > 0 ? all.axis / sum : entries.front().axis;
  for (const Entry& e : entries) {
    constexpr double kWider = 1e-7;  // than what is rounded off
    const double apart = std::atan2(length(cross(e.axis, all.axis)), dot(e.axis, all.axis));
    all.half_angle =
        std::max(all.half_angle, std::min(apart + e.half_angle + kWider, std::numbers::pi));
  }
  return all;
}

}  // namespace

void ManyLights::fill(std::uint32_t group, std::span<Entry> entries) {
  const std::vector<std::span<Entry>> parts = divide(entries, kGroup);
  for (std::size_t k = 0; k < parts.size(); ++k) {
    const std::span<Entry> part = parts[k];
    const std::size_t place = group * kGroup + k;
    if (part.size() == 1) {
      set(place, part.front());
      continue;
    }
    const Entry all = joined<Entry>(part);
    set(place, all);
    constexpr double kWider = 1 + 1e-6;  // than what floats round off
    double radius = 0;
    for (const Entry& e : part) radius = std::max(radius, length(e.place - all.place));
    groups_.radius[place] = float(radius * kWider);
    const std::uint32_t inner = add_group();
    group_[place] = inner;
    fill(inner, part);
  }
}

float ManyLights::weight_of_sun(std::size_t at, double cosine) const {
  const Rgb irradiance = std::get<SunLight>(lights_[light_[at]]).irradiance;
  const double weight = double(luminance(irradiance)) / unit_ * cosine;
  if (!(weight > 0)) return 0;
  return float(std::clamp(weight, double(LightGroups::kLeast), double(LightGroups::kMost)));
}

void ManyLights::weigh_suns(std::size_t group, const AtPlace&, float* to) const {
  for (std::size_t i = kGroup * group; i < std::min(suns_, kGroup * (group + 1)); ++i) {
    to[i % kGroup] = weight_of_sun(i, 1);
  }
}

void ManyLights::weigh_suns(std::size_t group, const OnPlane& at, float* to) const {
  constexpr double kLeastCosine = 0.02;  // of a disc that the plane may cut
  for (std::size_t i = kGroup * group; i < std::min(suns_, kGroup * (group + 1)); ++i) {
    const auto& sun = std::get<SunLight>(lights_[light_[i]]);
    const double cosine = dot(Vec3d(sun.direction), at.normal);
    const double rim = std::sqrt(2 * double(sun.one_minus_cos_radius)) + 1e-6;
    to[i % kGroup] = cosine < -rim ? 0 : weight_of_sun(i, std::max(cosine, kLeastCosine));
  }
}

float ManyLights::towards(std::size_t at, Vec3d place) const {
  const Cone& cone = cones_[at];
  const Vec3d from(groups_.place[0][at], groups_.place[1][at], groups_.place[2][at]);
  const Vec3d way = place - from;
  const double distance = length(way);
  if (!(distance > 0)) return 1;
  const double cosine = dot(way, cone.axis) / distance;
  if (group_[at] == 0) {
    const auto* const spot = std::get_if<SpotSource>(&lights_[light_[at]]);
    if (spot != nullptr) return float(spot->share(way / distance));
    if (!(cosine > 0)) return 0;
    // Near its plane a rectangle is not as faint as its middle's cosine says, and near its middle
    // not as bright as a point.
    const double seen = cone.size / distance;
    return float(std::max(cosine, 0.5 * std::min(1.0, seen)) *
                 std::min(1.0, std::numbers::pi / (seen * seen)));
  }
  // The cone of the group is wider by the angle that the group fills as seen from there.
  const double sine_of_group = std::min(1.0, double(groups_.radius[at]) / distance);
  const double cosine_of_group = std::sqrt(1 - sine_of_group * sine_of_group);
  const double wider_cosine = cone.cosine * cosine_of_group - cone.sine * sine_of_group;
  const double wider_sine = cone.sine * cosine_of_group + cone.cosine * sine_of_group;
  return wider_sine <= 0 || cosine >= wider_cosine ? 1 : 0;
}

}  // namespace pvol::detail
