#include "pvol/render/sky_light.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <span>

namespace pvol {
namespace {

using std::numbers::pi;

/// Index i with cdf[i] <= u < cdf[i + 1]; cdf ascends from 0 to 1.
int find_bin(std::span<const double> cdf, double u) {
  const auto above = std::upper_bound(cdf.begin(), cdf.end() - 1, u);
  return std::max(0, int(above - cdf.begin()) - 1);
}

/// Turns weights into a cumulative distribution in place: n + 1 values; returns the sum.
double accumulate(std::span<double> cdf) {
  double sum = 0;
  for (double& v : cdf) {
    const double weight = v;
    v = sum;
    sum += weight;
  }
  for (double& v : cdf) v = sum > 0 ? v / sum : 0;
  cdf.back() = 1;
  return sum;
}

/// A vector turned by the shortest way that takes +y to `up`, unit; about x where that is -y.
Vec3d from_y(Vec3d up, Vec3d v) {
  if (up.y < -1 + 1e-12) return {v.x, -v.y, -v.z};
  const Vec3d axis(up.z, 0, -up.x);  // times the sine
  return v * up.y + cross(axis, v) + axis * (dot(axis, v) / (1 + up.y));
}

}  // namespace

SkyLight::SkyLight(const Environment& environment) : environment_(environment) {
  if (const auto* gradient = std::get_if<GradientSky>(&environment_)) {
    up_ = Vec3f(normalize(gradient->up));
  }
  const auto* picture = std::get_if<ImageSky>(&environment_);
  if (picture == nullptr) return;
  const int width = picture->width, height = picture->height;
  rotation_ = picture->rotation / 360;
  turned_ = normalize(picture->up) != Vec3d(0, 1, 0);
  if (turned_) {
    const auto axis = [&](Vec3d v) { return Vec3f(from_y(normalize(picture->up), v)); };
    x_ = axis({1, 0, 0}), y_ = axis({0, 1, 0}), z_ = axis({0, 0, 1});
  }
  for (int y = 0; y <= height; ++y) row_y_.push_back(std::cos(pi * y / height));
  std::vector<double> rows(std::size_t(height) + 1);
  pixel_cdf_.resize(std::size_t(height) * std::size_t(width + 1));
  for (int y = 0; y < height; ++y) {
    const std::span row(&pixel_cdf_[std::size_t(y) * std::size_t(width + 1)],
                        std::size_t(width) + 1);
    for (int x = 0; x < width; ++x) {
      const Rgb c = picture->pixels[std::size_t(y) * std::size_t(width) + std::size_t(x)];
      row[std::size_t(x)] = double(luminance(c * picture->scale));
    }
    const double solid_angle = row_y_[std::size_t(y)] - row_y_[std::size_t(y) + 1];
    rows[std::size_t(y)] = accumulate(row) * solid_angle;
  }
  const double sum = accumulate(rows);
  mean_luminance_ = float(sum / (2 * width));
  if (sum > 0) row_cdf_ = std::move(rows);  // a black picture is not sampled
}

SkyLight::Pixel SkyLight::pixel_at(Vec3f d) const {
  const auto& picture = std::get<ImageSky>(environment_);
  if (turned_) d = {dot(d, x_), dot(d, y_), dot(d, z_)};
  double turns = std::atan2(double(d.z), double(d.x)) / (2 * pi) - rotation_;
  turns -= std::floor(turns);
  // Near the poles y is 1 to the last digit for a fraction of a degree; x and z still tell.
  const double theta = std::atan2(std::hypot(double(d.x), double(d.z)), double(d.y)) / pi;
  return {std::min(int(turns * picture.width), picture.width - 1),
          std::min(int(theta * picture.height), picture.height - 1)};
}

Rgb SkyLight::radiance(Vec3f d) const {
  struct Visitor {
    const SkyLight& sky;
    Vec3f d;
    Rgb operator()(const ConstantSky& s) const { return s.radiance; }
    Rgb operator()(const GradientSky& s) const {
      const float height = dot(d, sky.up_);
      const Rgb end = height > 0 ? s.zenith : s.ground;
      return s.horizon + (end - s.horizon) * std::min(std::abs(height), 1.0f);
    }
    Rgb operator()(const ImageSky& s) const {
      const Pixel p = sky.pixel_at(d);
      return s.pixels[std::size_t(p.y) * std::size_t(s.width) + std::size_t(p.x)] * s.scale;
    }
  };
  return std::visit(Visitor{*this, d}, environment_);
}

float SkyLight::pixel_pdf(Pixel p) const {
  const auto& picture = std::get<ImageSky>(environment_);
  const std::size_t y = std::size_t(p.y), x = std::size_t(p.x), width = std::size_t(picture.width);
  const double* row = &pixel_cdf_[y * (width + 1)];
  const double share = (row_cdf_[y + 1] - row_cdf_[y]) * (row[x + 1] - row[x]);
  const double solid_angle = 2 * pi / picture.width * (row_y_[y] - row_y_[y + 1]);
  return float(share / solid_angle);
}

LightSample SkyLight::sample(Rng& rng) const {
  const auto& picture = std::get<ImageSky>(environment_);
  const Philox::Block bits = rng.block();
  const int y = find_bin(row_cdf_, to_uniform_double(bits.lo));
  const std::size_t width = std::size_t(picture.width);
  const std::span row(&pixel_cdf_[std::size_t(y) * (width + 1)], width + 1);
  const int x = find_bin(row, to_uniform_double(bits.hi));
  // Uniform in the pixel's solid angle: cos(theta) and azimuth are uniform.
  const double top = row_y_[std::size_t(y)], bottom = row_y_[std::size_t(y) + 1];
  const auto [along, around] = rng.uniform2();
  const double cosine = top + (bottom - top) * double(along);
  const double azimuth = 2 * pi * ((x + double(around)) / picture.width + rotation_);
  const double sine = std::sqrt(std::max(0.0, 1 - cosine * cosine));
  Vec3f d(Vec3d(sine * std::cos(azimuth), cosine, sine * std::sin(azimuth)));
  if (turned_) d = x_ * d.x + y_ * d.y + z_ * d.z;
  return {d, picture.pixels[std::size_t(y) * width + std::size_t(x)] * picture.scale,
          pixel_pdf({x, y})};
}

float SkyLight::pdf(Vec3f d) const { return sampled() ? pixel_pdf(pixel_at(d)) : 0.0f; }

}  // namespace pvol
