#include "render/light/open_sky.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace pvol::detail {

OpenSky::OpenSky(const SkyLight& sky) {
  constexpr int kAcross = 128, kDown = 64;
  patches_.resize(std::size_t(kAcross) * kDown);
  sky.visit_patches([&](Vec3d direction, Rgb radiance, double solid_angle) {
    const double turns = std::atan2(direction.z, direction.x) / (2 * std::numbers::pi) + 0.5;
    const double down = std::acos(std::clamp(direction.y, -1.0, 1.0)) / std::numbers::pi;
    const int x = std::min(int(turns * kAcross), kAcross - 1);
    const int y = std::min(int(down * kDown), kDown - 1);
    auto& patch = patches_[std::size_t(y) * kAcross + std::size_t(x)];
    for (int c = 0; c < 3; ++c) {
      patch[std::size_t(c)] += direction * (double(radiance[c]) * solid_angle);
    }
  });
}

Rgb OpenSky::irradiance(Vec3d normal) const {
  Vec3d sum;
  for (const auto& patch : patches_) {
    for (int c = 0; c < 3; ++c) sum[c] += std::max(0.0, dot(normal, patch[std::size_t(c)]));
  }
  return Rgb(sum);
}

}  // namespace pvol::detail
