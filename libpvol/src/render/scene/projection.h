// The rays of a camera.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <optional>

#include "pvol/math/box.h"
#include "pvol/math/circle.h"
#include "pvol/render/camera.h"

namespace pvol::detail {

/// A camera with its constants, for pictures of a size.
class Projection {
 public:
  Projection(const Camera& camera, int width, int height)
      : origin_(camera.position), kind_(camera.kind) {
    const double aspect = double(width) / height;
    forward_ = normalize(camera.target - camera.position);
    const Vec3d x = normalize(cross(forward_, camera.up)), y = cross(forward_, x);
    if (kind_ == CameraKind::latlong) {
      right_ = x, down_ = y;
      turns_ = {1.0 / width, 0.5 / height};
      return;
    }
    const double pixel = 2 * half_height(camera, aspect) / height;
    const auto [shift_x, shift_y] = shift_of(camera, aspect);
    right_ = x * pixel;
    down_ = y * pixel;
    corner_ = forward_ - right_ * (width / 2.0) - down_ * (height / 2.0);
    if (shift_x != 0 || shift_y != 0) corner_ += x * shift_x - y * shift_y;
    radius_ = lens_radius(camera, aspect);
    lens_x_ = x * radius_, lens_y_ = y * radius_;
    const double distance = length(camera.target - camera.position);
    focus_ = camera.focus_distance.value_or(distance);
  }

  /// Whether rays begin anywhere on a lens, so that `ray` takes a place on it.
  [[nodiscard]] bool has_lens() const { return radius_ > 0; }

  /// Whether all rays begin at one place, towards(x, y).
  [[nodiscard]] bool is_pinhole() const { return kind_ == CameraKind::perspective && !has_lens(); }
  [[nodiscard]] Vec3d origin() const { return origin_; }
  [[nodiscard]] Vec3d towards(double x, double y) const { return corner_ + right_ * x + down_ * y; }

  /// Through the point (x, y) of the picture, in pixels, and the middle of the lens.
  [[nodiscard]] Ray ray(double x, double y) const {
    switch (kind_) {
      case CameraKind::orthographic:
        return {origin_ + (corner_ - forward_) + right_ * x + down_ * y, forward_};
      case CameraKind::latlong:
        return {origin_, along(x * turns_[0] - 0.5, 0.25 - y * turns_[1])};
      case CameraKind::perspective:
        break;
    }
    return {origin_, normalize(towards(x, y))};
  }

  /// The same through a point of the lens, uniform over it where u and v are over [0, 1).
  [[nodiscard]] Ray ray(double x, double y, float u, float v) const {
    // Where all rays through (x, y) meet.
    const Vec3d sharp = towards(x, y) * focus_;
    const CirclePoint rim = point_at_turns(v);
    const double r = std::sqrt(double(u));
    const Vec3d on_lens = lens_x_ * (r * double(rim.cosine)) + lens_y_ * (r * double(rim.sine));
    return {origin_ + on_lens, normalize(sharp - on_lens)};
  }

  /// Distance of a place along the view; in latlong pictures, which show all directions, from the
  /// camera.
  [[nodiscard]] double depth(Vec3d place) const {
    const Vec3d to = place - origin_;
    return kind_ == CameraKind::latlong ? length(to) : dot(to, forward_);
  }

  /// From the least to the largest depth of places in a box, which lies in the world by a map.
  [[nodiscard]] Span depths(const Affine& to_world, const Box& box) const {
    Span all{std::numeric_limits<double>::infinity(), -std::numeric_limits<double>::infinity()};
    for (int corner = 0; corner < 8; ++corner) {
      const Vec3d at((corner & 1) != 0 ? box.hi.x : box.lo.x,
                     (corner & 2) != 0 ? box.hi.y : box.lo.y,
                     (corner & 4) != 0 ? box.hi.z : box.lo.z);
      const double of_corner = depth(to_world.point(at));
      all = {std::min(all.t0, of_corner), std::max(all.t1, of_corner)};
    }
    if (kind_ == CameraKind::latlong) {  // the nearest place is no corner
      const Box around = transform(to_world, box);
      all.t0 = depth(min(max(origin_, around.lo), around.hi));
    }
    return all;
  }

  /// The place at this depth that (x, y) shows.
  [[nodiscard]] Vec3d place(double x, double y, double depth) const {
    const Ray r = ray(x, y);
    if (kind_ == CameraKind::latlong) return r.o + r.d * depth;
    const double from = kind_ == CameraKind::orthographic ? dot(r.o - origin_, forward_) : 0;
    return r.o + r.d * ((depth - from) / dot(r.d, forward_));
  }

  /// Where a place is seen through the middle of the lens, in pixels; nothing of one behind.
  [[nodiscard]] std::optional<std::array<double, 2>> seen(Vec3d place) const {
    const Vec3d to = place - origin_;
    if (kind_ == CameraKind::latlong) return seen_around(to);
    const double far = dot(to, forward_);
    if (!(far > 0)) return std::nullopt;
    const Vec3d on_plane =
        (kind_ == CameraKind::orthographic ? to - forward_ * (far - 1) : to / far) - corner_;
    return std::array{dot(on_plane, right_) / dot(right_, right_),
                      dot(on_plane, down_) / dot(down_, down_)};
  }

 private:
  /// Direction at turns of longitude to the right of the view, and of latitude above it.
  [[nodiscard]] Vec3d along(double longitude, double latitude) const {
    constexpr double kTurn = 2 * std::numbers::pi;
    const double level = std::cos(kTurn * latitude);
    return normalize(forward_ * (level * std::cos(kTurn * longitude)) +
                     right_ * (level * std::sin(kTurn * longitude)) -
                     down_ * std::sin(kTurn * latitude));
  }

  /// In a latlong picture, which shows everything but the camera itself.
  [[nodiscard]] std::optional<std::array<double, 2>> seen_around(Vec3d to) const {
    constexpr double kTurn = 2 * std::numbers::pi;
    const double distance = length(to);
    if (!(distance > 0)) return std::nullopt;
    const double longitude = std::atan2(dot(to, right_), dot(to, forward_)) / kTurn;
    const double latitude = -std::asin(std::clamp(dot(to, down_) / distance, -1.0, 1.0)) / kTurn;
    return std::array{(longitude + 0.5) / turns_[0], (0.25 - latitude) / turns_[1]};
  }

  Vec3d origin_, forward_;
  CameraKind kind_;
  Vec3d corner_, right_, down_;  // the point at image (0, 0) and steps of one pixel, at distance 1
  double radius_ = 0, focus_ = 0;
  Vec3d lens_x_, lens_y_;
  std::array<double, 2> turns_{};  // a pixel of a latlong picture
};

}  // namespace pvol::detail
