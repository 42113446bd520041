// pbrt's equal-area pictures of the sky. Clarberg. Fast equal-area mapping of the (hemi)sphere
// using SIMD. Journal of Graphics Tools 2008.
#include <algorithm>
#include <cmath>
#include <numbers>

#include "pbrt/pbrt_world.h"

namespace pvol::formats::detail {
namespace {

constexpr int kLargestWidth = 1 << 14;
/// Look-ups of a pixel along each side; of large pictures few, which take seconds as it is.
int per_side(const ImageSky& out) { return out.height > 2048 ? 2 : 4; }

/// Of a direction of length 1, in the square [0, 1]^2. Its inner diamond is the half of +z, and its
/// corners are -z; x runs right and y down the picture.
std::array<double, 2> to_square(Vec3d d) {
  const double x = std::abs(d.x), y = std::abs(d.y), z = std::abs(d.z);
  const double r = std::sqrt(std::max(0.0, 1 - z));
  const double turn = x == 0 && y == 0 ? 0 : std::atan2(y, x) * (2 / std::numbers::pi);
  double v = turn * r, u = r - v;
  if (d.z < 0) {
    const double folded = 1 - v;
    v = 1 - u, u = folded;
  }
  return {(std::copysign(u, d.x) + 1) / 2, (std::copysign(v, d.y) + 1) / 2};
}

Rgb look_up(const PbrtSkyPicture& sky, const Affine& to_light, Vec3d direction) {
  const ImageSky& image = sky.picture;
  const auto [u, v] = to_square(normalize(to_light.vector(direction)));
  const int x = std::clamp(int(u * image.width), 0, image.width - 1);
  const int y = std::clamp(int(v * image.height), 0, image.height - 1);
  return image.pixels[std::size_t(y) * std::size_t(image.width) + std::size_t(x)] * sky.factor;
}

/// The mean of a pixel, by places even in its solid angle. Sum: over the pictures.
Rgb pixel(const std::vector<PbrtSkyPicture>& skies, const std::vector<Affine>& to_light,
          const ImageSky& out, int x, int y) {
  const double pi = std::numbers::pi;
  const double upper = std::cos(pi * y / out.height), lower = std::cos(pi * (y + 1) / out.height);
  const int side = per_side(out);
  Vec3d sum;
  for (int i = 0; i < side * side; ++i) {
    const double azimuth = 2 * pi * (x + (i % side + 0.5) / side) / out.width;
    const double height = upper + (lower - upper) * (double(i / side) + 0.5) / side;
    const double level = std::sqrt(std::max(0.0, 1 - height * height));
    const Vec3d d{level * std::cos(azimuth), height, level * std::sin(azimuth)};
    for (std::size_t s = 0; s < skies.size(); ++s) sum += Vec3d(look_up(skies[s], to_light[s], d));
  }
  return Rgb(sum / double(side * side));
}

}  // namespace

ImageSky to_latlong(const std::vector<PbrtSkyPicture>& pictures, Rgb radiance) {
  ImageSky out;
  std::vector<Affine> to_light;
  for (const PbrtSkyPicture& p : pictures) {
    out.height = std::max(out.height, p.picture.height);  // pixels of about the same solid angle
    to_light.push_back(inverse(p.place));
  }
  out.height = std::min(out.height, kLargestWidth / 2);
  out.width = 2 * out.height;
  std::vector<Rgb>& pixels = out.pixels.edit();
  pixels.reserve(std::size_t(out.width) * std::size_t(out.height));
  for (int y = 0; y < out.height; ++y) {
    for (int x = 0; x < out.width; ++x) {
      pixels.push_back(radiance + pixel(pictures, to_light, out, x, y));
    }
  }
  return out;
}

}  // namespace pvol::formats::detail
