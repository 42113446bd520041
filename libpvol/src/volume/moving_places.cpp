#include "pvol/volume/moving_places.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include "math/digits.h"
#include "pvol/error.h"
#include "pvol/volume/emitter.h"
#include "pvol/volume/facts.h"
#include "volume/placement.h"

namespace pvol {
namespace {

std::array<Vec3d, 8> corners_of(const Affine& map, const Box& box) {
  std::array<Vec3d, 8> all;
  for (unsigned k = 0; k < 8; ++k) all[k] = map.point(corner(box, k));
  return all;
}

/// Frobenius': an upper bound of the factor on lengths.
double norm(const std::array<Vec3d, 3>& m) {
  return std::sqrt(dot(m[0], m[0]) + dot(m[1], m[1]) + dot(m[2], m[2]));
}

double turning(const MovingMap& map) {
  double sum = 0;
  for (const MovingTurn& turn : map.turns) sum += std::abs(turn.rate);
  return sum;
}

/// Bounds of a point's distance from the origin, speed and acceleration, in frames.
struct Course {
  double distance, speed, acceleration;
};

/// Of a point that moves as `c` does and is then mapped, from t0 to t1: by the product rule, with
/// turns of norm 1 whose derivatives have norms of at most w and w^2.
Course mapped(const MovingMap& map, const Course& c, double t0, double t1) {
  const auto linear_at = [&](double t) {
    std::array<Vec3d, 3> m = map.linear.m;
    for (std::size_t r = 0; r < 3; ++r) m[r] += map.linear_rate[r] * t;
    return norm(m);
  };
  const auto shift_at = [&](double t) { return length(map.shift + map.shift_rate * t); };
  const double w = turning(map), rate = norm(map.linear_rate);
  const double size = std::max(linear_at(t0), linear_at(t1));  // convex in time
  const double first = w * size + rate, second = w * w * size + 2 * w * rate;
  return {std::max(shift_at(t0), shift_at(t1)) + size * c.distance,
          length(map.shift_rate) + first * c.distance + size * c.speed,
          second * c.distance + 2 * first * c.speed + size * c.acceleration};
}

/// Those of a volume that hold something, which move together.
std::vector<const VolumeField*> fields_of(const Volume& v) {
  std::vector<const VolumeField*> all;
  if (!v.density.octree.empty()) all.push_back(&v.density);
  if (v.fire != nullptr && !v.fire->field.octree.empty()) all.push_back(&v.fire->field);
  return all;
}

/// Of the boxes of these, in the object's space.
std::vector<Vec3d> corners_of(const Volume& v) {
  std::vector<Vec3d> all;
  for (const VolumeField* f : fields_of(v)) {
    for (const Vec3d& p : corners_of(cells_to_object(*f, v), f->octree.support())) all.push_back(p);
  }
  return all;
}

/// Refuses places at which no paths could go through the volume.
void check_place(const Volume& v, const MovingPlace& place, const Shutter& shutter) {
  const double t0 = std::min(shutter.open, 0.0), t1 = std::max(shutter.close, 0.0);
  if (!stays_regular(place.object, t0, t1) || !stays_regular(place.instance, t0, t1)) {
    throw Error(
        "a moving placement becomes flat between the time of its files and the end of the shutter, "
        "because a scale passes through 0. Close the shutter earlier, or give scales that do not "
        "pass 0.");
  }
  constexpr int kTimes = 8;
  for (const VolumeField* f : fields_of(v)) {
    for (int i = 0; i <= kTimes; ++i) {
      const Affine to_world = place.at(t0 + (t1 - t0) * i / kTimes) * cells_to_object(*f, v);
      detail::check_placement(to_world, inverse(to_world),
                              transform(to_world, f->octree.support()));
    }
  }
}

void check_turns(const MovingPlace& place) {
  constexpr double kRounding = 1e-9;
  for (const MovingMap* map : {&place.object, &place.instance}) {
    for (const MovingTurn& turn : map->turns) {
      const double size = length(turn.axis);
      if (std::abs(size - 1) < kRounding) continue;
      throw Error("a moving placement turns about an axis of length " + detail::digits(size, 6) +
                  "; expected 1");
    }
  }
}

/// Refuses a place that is not the volume's own where it begins.
void check_start(const Volume& v, std::size_t number, const MovingPlace& place) {
  constexpr double kSame = 1e-6;  // of the volume's size
  const std::vector<Vec3d> corners = corners_of(v);
  const Affine own = inverse(to_first_place(v, number)) * v.object_to_world, start = place.at(0);
  const double size = length(own.point(corners.back()) - own.point(corners.front()));
  for (const Vec3d& p : corners) {
    if (length(start.point(p) - own.point(p)) <= kSame * size) continue;
    throw Error("moving instance " + std::to_string(number + 1) +
                " starts elsewhere than the volume; expected the placement for which it was made "
                "at time 0");
  }
}

/// The longest way of a corner, from time 0 to times of the shutter.
double longest_way(const Volume& v, const MovingPlace& place, const Shutter& shutter) {
  const std::vector<Vec3d> corners = corners_of(v);
  constexpr int kTimes = 16;
  double longest = 0;
  const Affine still = place.at(0);
  for (int i = 0; i <= kTimes; ++i) {
    const Affine map = place.at(shutter.at(double(i) / kTimes));
    for (const Vec3d& p : corners) {
      longest = std::max(longest, length(map.point(p) - still.point(p)));
    }
  }
  return longest;
}

}  // namespace

Affine cells_to_object(const VolumeField& field, const Volume& volume) {
  return inverse(volume.object_to_world) * inverse(field.world_to_cells);
}

Box swept_box(const MovingPlace& place, const Affine& to_object, const Box& box, double t0,
              double t1) {
  if (box.empty()) return {};
  const auto corners = corners_of(to_object, box);
  double far = 0;
  for (const Vec3d& p : corners) far = std::max(far, length(p));
  const Course c = mapped(place.instance, mapped(place.object, {far, 0, 0}, t0, t1), t0, t1);
  // Between two times a point is off the chord by at most (time)^2 / 8 of its acceleration.
  constexpr double kShare = 1e-3, kMostSteps = 1024, kRounding = 1e-13;
  const double bend = (t1 - t0) * (t1 - t0) / 8 * c.acceleration;
  const double size = length(transform(place.at(t0) * to_object, box).extent());
  const double steps = std::clamp(std::ceil(std::sqrt(bend / (kShare * size))), 1.0, kMostSteps);
  Box all;
  for (int i = 0; i <= int(steps); ++i) {
    all = join(all, transform(place.at(t0 + (t1 - t0) * i / steps) * to_object, box));
  }
  const Vec3d more(bend / (steps * steps) + kRounding * c.distance);
  return {all.lo - more, all.hi + more};
}

Volume move_places(Volume v, std::vector<MovingPlace> places, const Shutter& shutter) {
  if (places.size() != count_places(v)) {
    throw Error("there are " + std::to_string(places.size()) +
                " moving instances of a volume with " + std::to_string(count_places(v)) +
                "; expected as many");
  }
  if (!(std::isfinite(shutter.open) && std::isfinite(shutter.close) &&
        shutter.open <= shutter.close)) {
    throw Error("the shutter does not open before it closes, or its times are not finite");
  }
  for (const MovingPlace& place : places) check_turns(place);
  if (fields_of(v).empty()) return v;
  if (std::ranges::none_of(places, &MovingPlace::moves)) return v;
  auto moving = std::make_shared<MovingPlaces>();
  moving->shutter = shutter;
  for (std::size_t i = 0; i < places.size(); ++i) {
    const MovingPlace& place = places[i];
    if (!place.moves()) continue;
    check_start(v, i, place);
    detail::naming_place(i, v.further_places.size(), [&] { check_place(v, place, shutter); });
    const bool grows = place.object.linear_rate != MovingMap{}.linear_rate ||
                       place.instance.linear_rate != MovingMap{}.linear_rate;
    if (shutter.moves() && grows && v.density.homogeneous != nullptr) {
      throw Error(
          "a volume that grows while the shutter is open does not support homogenise; leave it "
          "off, or keep the scales constant");
    }
    moving->longest = std::max(moving->longest, longest_way(v, place, shutter));
  }
  moving->all = std::move(places);
  v.place_velocities = moving;
  if (shutter.moves()) v.moving_places = std::move(moving);
  return v;
}

}  // namespace pvol
