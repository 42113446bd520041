#include "render/path/many_lights.h"

#include <algorithm>
#include <limits>
#include <utility>

namespace pvol::detail {
namespace {

/// A light that is as a point, seen from afar; null: another one.
const PointSource* as_point(const LightSource& light) {
  if (const auto* const point = std::get_if<PointSource>(&light)) return point;
  const auto* const ball = std::get_if<BallSource>(&light);
  return ball != nullptr ? &ball->centre() : nullptr;
}

constexpr double kMostWeight = 1e30;  // at a light
constexpr double kLeastSquare = std::numeric_limits<double>::min();

double weight_of(const LightSource& light, Vec3d place) {
  const auto irradiance = [&](const auto& l) { return l.irradiance_on({place, place}); };
  return std::min(double(luminance(std::visit(irradiance, light))), kMostWeight);
}

}  // namespace

ManyLights::ManyLights(std::vector<LightSource> lights) : lights_(std::move(lights)) {
  while (first_ < lights_.size() && as_point(lights_[first_]) == nullptr) ++first_;
  for (std::size_t i = first_; i < lights_.size(); ++i) {
    const PointSource* const point = as_point(lights_[i]);
    if (point == nullptr) break;
    x_.push_back(point->position.x), y_.push_back(point->position.y);
    z_.push_back(point->position.z);
    power_.push_back(double(luminance(point->intensity)));
  }
}

void ManyLights::weigh(Vec3d place, std::span<double> to) const {
  for (std::size_t i = 0; i < first_; ++i) to[i] = weight_of(lights_[i], place);
  const std::size_t points = power_.size();
  double* const of_points = to.data() + first_;
  for (std::size_t i = 0; i < points; ++i) {
    const double x = x_[i] - place.x, y = y_[i] - place.y, z = z_[i] - place.z;
    const double square = std::max(x * x + y * y + z * z, kLeastSquare);
    of_points[i] = std::min(power_[i] / square, kMostWeight);
  }
  for (std::size_t i = first_ + points; i < lights_.size(); ++i) {
    to[i] = weight_of(lights_[i], place);
  }
}

}  // namespace pvol::detail
