#include "pvol/bounds/distribution.h"

#include <algorithm>
#include <cmath>

#include "bounds/box_volume.h"

namespace pvol {
namespace {

struct Weighted {
  double ratio = 0, volume = 0, mass = 0;
};

/// `cubes` ascend by ratio.
Distribution distribute(const std::vector<Weighted>& cubes, double Weighted::*weight) {
  Distribution d;
  double total = 0;
  for (const Weighted& c : cubes) total += c.*weight;
  double sum = 0;
  std::size_t next = 0;
  for (const Weighted& c : cubes) {
    const double share = c.*weight / total;
    sum += share;
    // The last cube ends every quantile, whatever the rounding of the sum.
    for (; next < kQuantileShares.size() && (sum >= kQuantileShares[next] || &c == &cubes.back());
         ++next) {
      d.quantiles[next] = c.ratio;
    }
    const double bin = 4 * std::log2(c.ratio) - Distribution::kFirst;
    if (!(bin >= 0)) {
      d.below += share;
    } else if (bin >= double(Distribution::kBins)) {
      d.above += share;
    } else {
      d.share[std::size_t(bin)] += share;
    }
  }
  return d;
}

TwoDistributions distribute(std::vector<Weighted>& cubes) {
  std::sort(cubes.begin(), cubes.end(),
            [](const Weighted& a, const Weighted& b) { return a.ratio < b.ratio; });
  return {distribute(cubes, &Weighted::volume), distribute(cubes, &Weighted::mass)};
}

DepthDistributions measure_depth(const Pyramid& p, const PyramidContent& content,
                                 std::size_t level) {
  std::vector<Weighted> hi, lo, gap;
  for (std::size_t l = level; l < p.levels.size(); ++l) {
    for (std::size_t i = 0; i < p.levels[l].size(); ++i) {
      const PyramidNode& n = p.levels[l][i];
      const NodeContent& c = content[l][i];
      if (l > level && !c.leaf) continue;
      const double volume = detail::volume_in_box(p, l, n.code), mean = c.mass / volume;
      if (!(mean > 0)) continue;  // density too small for double
      hi.push_back({double(n.hi) / mean, volume, c.mass});
      lo.push_back({double(n.lo) / mean, volume, c.mass});
      gap.push_back({(double(n.hi) - double(n.lo)) / mean, volume, c.mass});
    }
  }
  DepthDistributions d;
  d.depth = int(p.levels.size() - 1 - level);
  d.hi = distribute(hi), d.lo = distribute(lo), d.gap = distribute(gap);
  return d;
}

}  // namespace

double Distribution::edge(std::size_t i) { return std::exp2((kFirst + double(i)) / 4); }

std::vector<DepthDistributions> measure_distributions(const Pyramid& pyramid,
                                                      const PyramidContent& content) {
  std::vector<DepthDistributions> depths;
  for (std::size_t level = pyramid.levels.size(); level-- > 0;) {
    depths.push_back(measure_depth(pyramid, content, level));
  }
  return depths;
}

double empty_share_of_box(const Pyramid& p) {
  if (p.empty()) return 1;
  const Vec3d box(p.support_hi - p.support_lo);
  double held = 0;
  for (std::size_t level = 0; level < p.levels.size(); ++level) {
    for (std::size_t i = 0; i < p.levels[level].size(); ++i) {
      if (level == 0 || is_uniform(p, level, i)) {
        held += detail::volume_in_box(p, level, p.levels[level][i].code);
      }
    }
  }
  return std::max(0.0, 1 - held / (box.x * box.y * box.z));
}

}  // namespace pvol
