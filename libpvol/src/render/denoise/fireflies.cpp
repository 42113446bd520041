#include "render/denoise/fireflies.h"

#include <algorithm>
#include <array>
#include <functional>
#include <vector>

#include "pvol/math/parallel.h"
#include "render/denoise/summed_area.h"

namespace pvol::detail {
namespace {

/// Pixels to each side that a pixel is compared with.
constexpr int kRadius = 2;

/// How many of their values, two for each pixel, may be other fireflies.
constexpr std::size_t kOthers = 2;

/// How many times brighter than the next one a firefly is.
constexpr float kBrighter = 2;

/// Standard errors of a pixel's mean below which few samples made it.
constexpr float kConfirmed = 3;

/// Light above what is around it, in one half and channel.
struct Excess {
  int x = 0, y = 0;
  float light = 0;
};

/// Values of a channel around a pixel in both halves, without its own.
std::vector<float> values_around(const TwoHalves& p, std::size_t channel, int x, int y) {
  std::vector<float> all;
  const Plane& any = p.values[0][channel];
  for (int j = std::max(0, y - kRadius); j <= std::min(any.height() - 1, y + kRadius); ++j) {
    for (int i = std::max(0, x - kRadius); i <= std::min(any.width() - 1, x + kRadius); ++i) {
      if (i == x && j == y) continue;
      for (const Planes& half : p.values) all.push_back(half[channel].row(j)[i]);
    }
  }
  return all;
}

/// Whether few of the pixel's samples made its mean.
bool is_unconfirmed(const TwoHalves& p, std::size_t channel, int x, int y) {
  const float mean = 0.5f * (p.values[0][channel].row(y)[x] + p.values[1][channel].row(y)[x]);
  return mean > 0 && mean * mean < kConfirmed * kConfirmed * p.variances[channel].row(y)[x];
}

/// What fireflies of a half have in excess, by rows; the planes stay as they are.
std::vector<Excess> find(const TwoHalves& p, std::size_t half, std::size_t channel,
                         const Plane& where) {
  const Plane& plane = p.values[half][channel];
  std::vector<std::vector<Excess>> rows(std::size_t(plane.height()));
  parallel_for(0, rows.size(), [&](std::size_t row) {
    const int y = int(row);
    for (int x = 0; x < plane.width(); ++x) {
      if (!(where.row(y)[x] > 0) || !is_unconfirmed(p, channel, x, y)) continue;
      std::vector<float> around = values_around(p, channel, x, y);
      if (around.size() <= kOthers) continue;
      const auto next = around.begin() + kOthers;
      std::nth_element(around.begin(), next, around.end(), std::greater<>());
      const float value = plane.row(y)[x], level = *next;
      // In the dark nothing tells how bright it should be.
      if (level > 0 && value > kBrighter * level) rows[row].push_back({x, y, value - level});
    }
  });
  std::vector<Excess> all;
  for (const auto& r : rows) all.insert(all.end(), r.begin(), r.end());
  return all;
}

/// The square of so many pixels to each side, as far as it lies in a picture.
Rectangle square(const Plane& p, int x, int y, int radius) {
  return {std::max(0, x - radius), std::max(0, y - radius), std::min(p.width(), x + radius + 1),
          std::min(p.height(), y + radius + 1)};
}

/// Spreads light, as gains of the level, in equal parts over squares around a place, so that it
/// fades outward. The largest has so much light of its own that little is added to it. Returns
/// false where there is no other light in the picture.
bool spread(const Excess& e, const Plane& level, const RectangleSums& sums, AddedRectangles& gain) {
  constexpr int kLeastRadius = 8;
  constexpr double kLittle = 0.02;
  constexpr double kRounding = 1e-10;  // of sums over all pixels
  constexpr std::array<double, 3> kRadii{1, 0.75, 0.5};
  const int whole = std::max(level.width(), level.height());
  int radius = kLeastRadius;
  const auto has_little = [&] {
    return kLittle * sums.over(square(level, e.x, e.y, radius)) < double(e.light);
  };
  while (radius < whole && has_little()) radius += radius / 2;
  const double least = kRounding * sums.over(square(level, 0, 0, whole));
  std::vector<Rectangle> areas;  // each within the one before, and lit
  for (const double r : kRadii) {
    const Rectangle area = square(level, e.x, e.y, int(r * radius));
    if (sums.over(area) > least) areas.push_back(area);
  }
  for (const Rectangle& area : areas) {
    gain.add(area, double(e.light) / (double(areas.size()) * sums.over(area)));
  }
  return !areas.empty();
}

/// The mean light around each pixel, of those that may be changed; 0 elsewhere.
Plane level_of(const Plane& light, const Plane& where) {
  Plane positive(light.width(), light.height(), 0);
  for (int y = 0; y < light.height(); ++y) {
    for (int x = 0; x < light.width(); ++x) positive.row(y)[x] = std::max(0.0f, light.row(y)[x]);
  }
  Plane level = box_mean(positive, where, kRadius);
  for (int y = 0; y < light.height(); ++y) {
    for (int x = 0; x < light.width(); ++x) level.row(y)[x] *= where.row(y)[x];
  }
  return level;
}

Plane mean_of(const Plane& a, const Plane& b) {
  Plane mean(a.width(), a.height(), 0);
  for (int y = 0; y < a.height(); ++y) {
    for (int x = 0; x < a.width(); ++x) mean.row(y)[x] = 0.5f * (a.row(y)[x] + b.row(y)[x]);
  }
  return mean;
}

/// Spreads over a plane what was cut from it, in proportion to a level.
void spread_all(const std::vector<Excess>& cut, const Plane& level, Plane& plane) {
  const RectangleSums sums(level);
  AddedRectangles gain(level.width(), level.height());
  for (const Excess& e : cut) {
    if (!spread(e, level, sums, gain)) plane.row(e.y)[e.x] += e.light;
  }
  gain.finish();
  parallel_for(0, std::size_t(level.height()), [&](std::size_t row) {
    const int y = int(row);
    for (int x = 0; x < level.width(); ++x) {
      plane.row(y)[x] += float(double(level.row(y)[x]) * gain.at(x, y));
    }
  });
}

}  // namespace

Fireflies spread_fireflies(TwoHalves& p, const Plane& where) {
  const int width = where.width(), height = where.height();
  const std::size_t channels = p.variances.size();
  Fireflies f{0, {width, height, 0}};
  for (int y = 0; y < height; ++y) std::fill_n(f.others.row(y), width, 1.0f);
  for (std::size_t c = 0; c < channels; ++c) {
    const std::array<std::vector<Excess>, 2> found{find(p, 0, c, where), find(p, 1, c, where)};
    for (const std::size_t half : {0u, 1u}) {
      for (const Excess& e : found[half]) {
        p.values[half][c].row(e.y)[e.x] -= e.light;
        f.others.row(e.y)[e.x] = 0;
      }
    }
    if (found[0].empty() && found[1].empty()) continue;
    const Plane level = level_of(mean_of(p.values[0][c], p.values[1][c]), where);
    for (const std::size_t half : {0u, 1u}) {
      spread_all(found[half], level, p.values[half][c]);
    }
  }
  for (int y = 0; y < height; ++y) {
    const float* r = f.others.row(y);
    f.pixels += std::size_t(std::count(r, r + width, 0.0f));
  }
  return f;
}

void spread_part(Plane& part, const Fireflies& fireflies, const Plane& where) {
  if (fireflies.pixels == 0) return;
  const Plane around = box_mean(part, fireflies.others, kRadius);
  std::vector<Excess> cut;
  for (int y = 0; y < part.height(); ++y) {
    for (int x = 0; x < part.width(); ++x) {
      const float light = part.row(y)[x] - around.row(y)[x];
      if (fireflies.others.row(y)[x] > 0 || !(light > 0)) continue;
      cut.push_back({x, y, light});
      part.row(y)[x] -= light;
    }
  }
  spread_all(cut, level_of(part, where), part);
}

}  // namespace pvol::detail
