#include "pvol/render/sky_picture.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <span>
#include <utility>

#include "math/turn_up.h"

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

}  // namespace

SkyPicture::SkyPicture(ImageSky image, SkyPixels pixels)
    : image_(std::move(image)),
      smooth_(pixels == SkyPixels::smooth),
      rotation_(image_.rotation / 360),
      turned_(normalize(image_.up) != Vec3d(0, 1, 0)) {
  const int width = image_.width, height = image_.height;
  if (turned_) {
    const auto axis = [&](Vec3d v) { return Vec3f(turn_up(normalize(image_.up), v)); };
    x_ = axis({1, 0, 0}), y_ = axis({0, 1, 0}), z_ = axis({0, 0, 1});
  }
  for (int y = 0; y <= height; ++y) row_y_.push_back(std::cos(pi * y / height));
  std::vector<double> rows(std::size_t(height) + 1);
  pixel_cdf_.resize(std::size_t(height) * std::size_t(width + 1));
  for (int y = 0; y < height; ++y) {
    const std::span row(&pixel_cdf_[std::size_t(y) * std::size_t(width + 1)],
                        std::size_t(width) + 1);
    for (int x = 0; x < width; ++x) row[std::size_t(x)] = double(weight(x, y));
    const double solid_angle = row_y_[std::size_t(y)] - row_y_[std::size_t(y) + 1];
    rows[std::size_t(y)] = accumulate(row) * solid_angle;
  }
  const double sum = accumulate(rows);
  mean_luminance_ = float(sum / (2 * width));
  if (sum > 0) row_cdf_ = std::move(rows);  // a black picture is not sampled
}

Rgb SkyPicture::at(int x, int y) const {
  return image_.pixels[std::size_t(y) * std::size_t(image_.width) + std::size_t(x)] * image_.scale;
}

SkyPicture::Place SkyPicture::place_of(Vec3f d) const {
  if (turned_) d = {dot(d, x_), dot(d, y_), dot(d, z_)};
  double turns = std::atan2(double(d.z), double(d.x)) / (2 * pi) - rotation_;
  turns -= std::floor(turns);
  // Near the poles y is 1 to the last digit for a fraction of a degree; x and z still tell.
  const double theta = std::atan2(std::hypot(double(d.x), double(d.z)), double(d.y)) / pi;
  return {turns * image_.width, theta * image_.height};
}

SkyPicture::Pixel SkyPicture::pixel_at(Vec3f d) const {
  const Place p = place_of(d);
  return {std::min(int(p.x), image_.width - 1), std::min(int(p.y), image_.height - 1)};
}

Rgb SkyPicture::radiance(Vec3f d) const {
  if (smooth_) return mixed(place_of(d));
  const Pixel p = pixel_at(d);
  return at(p.x, p.y);
}

/// Bilinear within the half of the sky that the place is in.
Rgb SkyPicture::mixed(Place p) const {
  const int width = image_.width, half = image_.height / 2;
  const int first = p.y < half ? 0 : half;
  const double x = p.x - 0.5, y = std::clamp(p.y - 0.5, double(first), double(first + half - 1));
  const int left = int(std::floor(x)), upper = int(y);
  const float u = float(x - left), v = float(y - upper);
  const int x0 = (left + width) % width, x1 = (left + 1) % width;
  const int y1 = std::min(upper + 1, first + half - 1);
  const Rgb above = at(x0, upper) + (at(x1, upper) - at(x0, upper)) * u;
  const Rgb below = at(x0, y1) + (at(x1, y1) - at(x0, y1)) * u;
  return above + (below - above) * v;
}

/// Luminance by which a pixel is chosen.
float SkyPicture::weight(int x, int y) const {
  if (!smooth_) return luminance(at(x, y));
  const int width = image_.width, half = image_.height / 2, first = y < half ? 0 : half;
  float most = 0;
  for (int j = std::max(y - 1, first); j <= std::min(y + 1, first + half - 1); ++j) {
    for (const int i : {(x + width - 1) % width, x, (x + 1) % width}) {
      most = std::max(most, luminance(at(i, j)));
    }
  }
  return most;
}

float SkyPicture::pixel_pdf(Pixel p) const {
  const std::size_t y = std::size_t(p.y), x = std::size_t(p.x), width = std::size_t(image_.width);
  const double* row = &pixel_cdf_[y * (width + 1)];
  const double share = (row_cdf_[y + 1] - row_cdf_[y]) * (row[x + 1] - row[x]);
  const double solid_angle = 2 * pi / image_.width * (row_y_[y] - row_y_[y + 1]);
  return float(share / solid_angle);
}

LightSample SkyPicture::sample(Rng& rng) const {
  const Philox::Block bits = rng.block();
  const int y = find_bin(row_cdf_, to_uniform_double(bits.lo));
  const std::size_t width = std::size_t(image_.width);
  const std::span row(&pixel_cdf_[std::size_t(y) * (width + 1)], width + 1);
  const int x = find_bin(row, to_uniform_double(bits.hi));
  // Uniform in the pixel's solid angle: cos(theta) and azimuth are uniform.
  const double top = row_y_[std::size_t(y)], bottom = row_y_[std::size_t(y) + 1];
  const auto [along, around] = rng.uniform2();
  const double cosine = top + (bottom - top) * double(along);
  const double azimuth = 2 * pi * ((x + double(around)) / image_.width + rotation_);
  const double sine = std::sqrt(std::max(0.0, 1 - cosine * cosine));
  Vec3f d(Vec3d(sine * std::cos(azimuth), cosine, sine * std::sin(azimuth)));
  if (turned_) d = x_ * d.x + y_ * d.y + z_ * d.z;
  const Rgb light =
      smooth_ ? mixed({double(x) + double(around), std::acos(cosine) / pi * image_.height})
              : at(x, y);
  return {d, light, pixel_pdf({x, y})};
}

Vec3f SkyPicture::direction_at(double across, double down) const {
  const double azimuth = 2 * pi * (across + rotation_), sine = std::sin(pi * down);
  const Vec3f d(Vec3d(sine * std::cos(azimuth), std::cos(pi * down), sine * std::sin(azimuth)));
  return turned_ ? x_ * d.x + y_ * d.y + z_ * d.z : d;
}

}  // namespace pvol
