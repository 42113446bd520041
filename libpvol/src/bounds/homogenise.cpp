#include "pvol/bounds/homogenise.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>

#include "bounds/box_volume.h"

namespace pvol {
namespace {

double cells_of(std::size_t level) { return std::ldexp(1.0, 3 * (int(level) + 3)); }

/// The most that the density in a node can differ from `mean`.
double deviation(const PyramidNode& node, float mean) {
  return std::max(double(node.hi) - double(mean), double(mean) - double(node.lo));
}

/// Nodes of a level that are replaced, by what value, and which are under one that is.
struct Choice {
  NodeMarks constant, gone;
  std::vector<std::vector<float>> mean;
};

class Chooser {
 public:
  Chooser(const Pyramid& p, const PyramidContent& content, double extinction, double diagonal,
          double tolerance)
      : p_(p), content_(content), unit_(extinction * diagonal), tolerance_(tolerance) {
    const std::size_t n = p.levels.size();
    choice_.constant.resize(n), choice_.gone.resize(n), choice_.mean.resize(n);
    for (std::size_t level = 0; level < n; ++level) {
      const std::size_t nodes = p.levels[level].size();
      choice_.constant[level].resize(nodes);
      choice_.gone[level].resize(nodes);
      choice_.mean[level].resize(nodes);
    }
  }

  Choice run() {
    for (std::size_t level = p_.levels.size(); level-- > 0;) {
      for (std::size_t i = 0; i < p_.levels[level].size(); ++i) decide(level, i);
    }
    return std::move(choice_);
  }

 private:
  const Pyramid& p_;
  const PyramidContent& content_;
  double unit_, tolerance_;  // world length and extinction of a cell's diagonal
  Choice choice_;

  void decide(std::size_t level, std::size_t i) {
    const PyramidNode& node = p_.levels[level][i];
    // Walks end at the box of the support: the mass has to lie in it.
    const double mean = content_[level][i].mass / detail::volume_in_box(p_, level, node.code);
    choice_.mean[level][i] = std::clamp(float(mean), node.lo, node.hi);
    const bool gone = choice_.gone[level][i] != 0;
    const double error =
        deviation(node, choice_.mean[level][i]) * std::ldexp(unit_, int(level) + 3);
    // Nodes of one density are homogeneous already, and exact. A mean of 0 would be empty space.
    const bool constant =
        !gone && !content_[level][i].uniform && error <= tolerance_ && choice_.mean[level][i] > 0;
    choice_.constant[level][i] = char(constant);
    if (!gone && !constant) return;
    const NodeRange below = children(p_, level, i);
    for (std::size_t k = below.begin; k < below.end; ++k) choice_.gone[level - 1][k] = 1;
  }
};

/// An upper bound, over all rays, of the sum of deviations times lengths in the replaced nodes of
/// each node, bottom up (THEORY.md, T3.7).
double bound_depth_error(const Pyramid& p, const Choice& c, double unit) {
  struct Error {
    double most = 0;   // largest deviation
    double depth = 0;  // bound of the sum, in units of deviation times diagonals of cells
  };
  std::vector<Error> below, here;
  for (std::size_t level = 0; level < p.levels.size(); ++level) {
    here.assign(p.levels[level].size(), {});
    for (std::size_t i = 0; i < here.size(); ++i) {
      const PyramidNode& node = p.levels[level][i];
      const double diagonals = std::ldexp(1.0, int(level) + 3);
      if (c.constant[level][i]) {
        const double d = deviation(node, c.mean[level][i]);
        here[i] = {d, d * diagonals};
        continue;
      }
      // A line crosses the three middle planes, so that it meets four octants at most.
      const NodeRange range = level > 0 ? children(p, level, i) : NodeRange{};
      std::array<double, 8> depths{};
      for (std::size_t k = range.begin; k < range.end; ++k) {
        here[i].most = std::max(here[i].most, below[k].most);
        depths[k - range.begin] = below[k].depth;
      }
      std::sort(depths.begin(), depths.end(), std::greater<>());
      here[i].depth =
          std::min(here[i].most * diagonals, depths[0] + depths[1] + depths[2] + depths[3]);
    }
    below.swap(here);
  }
  return below.empty() ? 0 : below[0].depth * unit;
}

/// The pyramid without what lies below replaced nodes.
HomogenisedPyramid apply(const Pyramid& p, const Choice& c) {
  HomogenisedPyramid r;
  r.pyramid = p;
  r.constant.resize(p.levels.size());
  for (std::size_t level = 0; level < p.levels.size(); ++level) {
    r.pyramid.levels[level].clear();
    for (std::size_t i = 0; i < p.levels[level].size(); ++i) {
      if (c.gone[level][i]) continue;
      PyramidNode node = p.levels[level][i];
      const bool constant = c.constant[level][i] != 0;
      if (constant) node.lo = node.hi = c.mean[level][i];
      r.pyramid.levels[level].push_back(node);
      r.constant[level].push_back(char(constant));
    }
  }
  return r;
}

}  // namespace

HomogenisedPyramid homogenise(const Pyramid& pyramid, const PyramidContent& content,
                              double extinction, double diagonal, double tolerance) {
  const Choice choice = Chooser(pyramid, content, extinction, diagonal, tolerance).run();
  HomogenisedPyramid r = apply(pyramid, choice);
  double volume = 0;
  for (std::size_t level = 0; level < pyramid.levels.size(); ++level) {
    for (std::size_t i = 0; i < pyramid.levels[level].size(); ++i) {
      const bool constant = choice.constant[level][i] != 0;
      r.parts.nodes += constant;
      if (!content[level][i].leaf) continue;
      volume += cells_of(level);
      if (!constant && !choice.gone[level][i]) continue;
      r.parts.volume_share += cells_of(level);
      r.parts.mass_share += content[level][i].mass;
    }
  }
  if (pyramid.empty()) return r;
  r.parts.volume_share /= volume;
  r.parts.mass_share /= content.back()[0].mass;
  r.parts.depth_error = bound_depth_error(pyramid, choice, extinction * diagonal);
  return r;
}

}  // namespace pvol
