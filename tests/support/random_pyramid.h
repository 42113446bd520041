// Random sparse pyramids for tests: leaves and uniform cubes anywhere under a root of any size.
#pragma once

#include <algorithm>
#include <cmath>
#include <map>
#include <random>
#include <vector>

#include "pvol/bounds/pyramid.h"

namespace pvol::test {

struct PyramidSpec {
  std::size_t levels = 4;
  int leaves = 40;
  int uniform = 5;
  float scale = 1;
  Vec3l origin{0};
};

/// A valid pyramid with up to as many terminals as asked for; equal seeds give equal pyramids.
inline Pyramid random_pyramid(const PyramidSpec& spec, std::uint64_t seed) {
  std::mt19937_64 random(seed);
  Pyramid p;
  p.origin = spec.origin;
  p.scale = spec.scale;
  p.levels.resize(spec.levels);

  std::map<std::uint64_t, std::uint64_t> taken;  // ranges of leaf codes, end by start
  const auto claim = [&](std::size_t level, std::uint64_t code) {
    const std::uint64_t start = code << 3 * level, end = (code + 1) << 3 * level;
    const auto next = taken.lower_bound(start);
    if (next != taken.end() && next->first < end) return false;
    if (next != taken.begin() && std::prev(next)->second > start) return false;
    taken[start] = end;
    return true;
  };
  const auto value = [&] {
    const double e = std::uniform_real_distribution<double>(-40, 0)(random);
    return std::min(spec.scale, float(std::exp2(e) * double(spec.scale)));
  };
  const auto add = [&](std::size_t level) {
    const int bits = int(3 * (spec.levels - 1 - level));
    const std::uint64_t code = bits == 0 ? 0 : random() >> (64 - bits);
    if (!claim(level, code)) return;
    float lo = random() % 3 == 0 ? 0 : value(), hi = value();
    if (level > 0) lo = hi;  // uniform
    if (lo > hi) std::swap(lo, hi);
    if (hi == 0 || taken.size() == 1) lo = hi = spec.scale;
    p.levels[level].push_back({code, decode(encode_down(lo, spec.scale), spec.scale),
                               decode(encode_up(hi, spec.scale), spec.scale)});
  };
  for (int i = 0; i < spec.uniform && spec.levels > 1; ++i) add(1 + random() % (spec.levels - 1));
  for (int i = 0; i < spec.leaves; ++i) add(0);

  Vec3l lo(std::int64_t(1) << 40), hi(0);
  for (std::size_t level = 0; level < p.levels.size(); ++level) {
    std::sort(p.levels[level].begin(), p.levels[level].end(),
              [](const auto& a, const auto& b) { return a.code < b.code; });
    for (const PyramidNode& n : p.levels[level]) {
      const Vec3l at = Vec3l(morton_decode(n.code)) * (std::int64_t(kLeafEdge) << level);
      lo = min(lo, at);
      hi = max(hi, at + Vec3l(std::int64_t(kLeafEdge) << level));
    }
  }
  p.support_lo = p.origin + lo + Vec3l(std::int64_t(random() % 4));
  p.support_hi = p.origin + hi - Vec3l(std::int64_t(random() % 4));
  complete_levels(p);
  return p;
}

}  // namespace pvol::test
