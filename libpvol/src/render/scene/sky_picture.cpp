#include "pvol/render/sky_picture.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "math/philox.h"
#include "math/turn_up.h"
#include "math/turns.h"
#include "pvol/math/circle.h"

namespace pvol {
namespace {

using std::numbers::pi;

}  // namespace

SkyPicture::SkyPicture(ImageSky image, SkyPixels pixels)
    : image_(std::move(image)),
      smooth_(pixels == SkyPixels::smooth),
      rotation_(float(image_.rotation / 360 - std::floor(image_.rotation / 360))),
      turned_(normalize(image_.up) != Vec3d(0, 1, 0)) {
  const int width = image_.width, height = image_.height;
  if (turned_) {
    const auto axis = [&](Vec3d v) { return Vec3f(turn_up(normalize(image_.up), v)); };
    x_ = axis({1, 0, 0}), y_ = axis({0, 1, 0}), z_ = axis({0, 0, 1});
  }
  if (image_.scale != Rgb(1.0f)) {
    for (Rgb& p : image_.pixels.edit()) p = p * image_.scale;
  }
  pixels_ = image_.pixels.begin();
  std::vector<double> shares(image_.pixels.size());
  double sum = 0;
  for (int y = 0; y < height; ++y) {
    // 1 - cos of the angles of the row's edges to the nearer pole.
    const bool upper = y < upper_rows();
    const auto at_edge = [&](int edge) {
      const double half_sine = std::sin(pi / 2 * (upper ? edge : height - edge) / height);
      return 2 * half_sine * half_sine;
    };
    const double from = at_edge(y), extent = at_edge(y + 1) - from;
    rows_.push_back({float(from), float(extent)});
    const double solid_angle = std::abs(extent);
    for (int x = 0; x < width; ++x) {
      const float luminance = weight(x, y);
      sum += shares[index(x, y)] = double(luminance) * solid_angle;
      largest_luminance_ = std::max(largest_luminance_, luminance);
      if (smooth_) weights_.push_back(luminance);
    }
  }
  mean_luminance_ = float(sum / (2 * width));
  if (!(sum > 0)) return;  // a black picture is not sampled
  pdf_per_luminance_ = width / (2 * pi * sum);
  for (double& s : shares) s *= double(shares.size()) / sum;
  bins_ = make_bins(shares);
}

/// Of shares with the mean 1: bins of less than that are filled up by those of more (Vose 1991).
std::vector<SkyPicture::Bin> SkyPicture::make_bins(std::vector<double> shares) {
  constexpr double kFull = 0x1p32;
  constexpr std::uint32_t kAll = ~0u;
  std::vector<Bin> bins(shares.size());
  std::vector<std::uint32_t> small, large;
  for (std::uint32_t i = 0; i < shares.size(); ++i) (shares[i] < 1 ? small : large).push_back(i);
  while (!small.empty() && !large.empty()) {
    const std::uint32_t little = small.back(), much = large.back();
    small.pop_back();
    bins[little] = {std::uint32_t(shares[little] * kFull), much};
    shares[much] -= 1 - shares[little];
    if (shares[much] >= 1) continue;
    large.pop_back();
    small.push_back(much);
  }
  // What rounding has left of either is full.
  for (const auto& left : {small, large}) {
    for (const std::uint32_t i : left) bins[i] = {kAll, i};
  }
  return bins;
}

SkyPicture::Place SkyPicture::place_of(Vec3f d) const {
  if (turned_) d = {dot(d, x_), dot(d, y_), dot(d, z_)};
  float turns = turns_of(d.z, d.x) - rotation_;
  turns -= std::floor(turns);
  // Near the poles y is 1 to the last digit for a fraction of a degree; x and z still tell.
  const float down = 2 * turns_of(std::sqrt(d.x * d.x + d.z * d.z), d.y);
  return {turns * float(image_.width), down * float(image_.height)};
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
  const int first = p.y < float(half) ? 0 : half, last = first + half - 1;
  const float x = p.x - 0.5f, y = std::clamp(p.y - 0.5f, float(first), float(last));
  const int left = int(std::floor(x)), upper = int(y);
  const float u = x - float(left), v = y - float(upper);
  const int x0 = left < 0 ? left + width : std::min(left, width - 1);
  const int x1 = left + 1 >= width ? left + 1 - width : left + 1;
  const int y1 = std::min(upper + 1, last);
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
  const float chosen = smooth_ ? weights_[index(p.x, p.y)] : luminance(at(p.x, p.y));
  return float(double(chosen) * pdf_per_luminance_);
}

LightSample SkyPicture::sample(Rng& rng) const {
  const Philox::Block bits = rng.block();
  const auto bin = std::uint32_t((bits.lo >> 32) * bins_.size() >> 32);
  const bool own = std::uint32_t(bits.hi >> 32) <= bins_[bin].own;
  const std::uint32_t pixel = own ? bin : bins_[bin].other, width = std::uint32_t(image_.width);
  const int y = int(pixel / width), x = int(pixel % width);
  // Uniform in the pixel's solid angle: cos(theta) and azimuth are uniform.
  const Row row = rows_[std::size_t(y)];
  const auto [along, around] = rng.uniform2();
  const float v = row.from + row.extent * along, cosine = y < upper_rows() ? 1 - v : v - 1;
  const float sine = std::sqrt(v * (2 - v));
  const double turns = (x + double(around)) / image_.width + double(rotation_);
  const CirclePoint azimuth = point_at_turns(float(turns < 1 ? turns : turns - 1));
  Vec3f d(sine * azimuth.cosine, cosine, sine * azimuth.sine);
  if (turned_) d = x_ * d.x + y_ * d.y + z_ * d.z;
  if (!smooth_) return {d, at(x, y), pixel_pdf({x, y})};
  const float down = 2 * turns_of(sine, cosine);
  return {d, mixed({float(x) + around, down * float(image_.height)}), pixel_pdf({x, y})};
}

SkyPicture::Tables SkyPicture::tables() const {
  const auto row = [&](int axis) { return Vec3f(x_[axis], y_[axis], z_[axis]); };
  return {.width = image_.width,
          .height = image_.height,
          .upper_rows = upper_rows(),
          .rotation = rotation_,
          .x = row(0),
          .y = row(1),
          .z = row(2),
          .pixels = pixels_,
          .weights = smooth_ ? weights_.data() : nullptr,
          .pdf_per_luminance = float(pdf_per_luminance_),
          .bins = bins_,
          .rows = rows_.data()};
}

Vec3f SkyPicture::direction_at(double across, double down) const {
  const double azimuth = 2 * pi * (across + double(rotation_)), sine = std::sin(pi * down);
  const Vec3f d(Vec3d(sine * std::cos(azimuth), std::cos(pi * down), sine * std::sin(azimuth)));
  return turned_ ? x_ * d.x + y_ * d.y + z_ * d.z : d;
}

}  // namespace pvol
