// What every holder of a pyramid needs: Morton codes, the 16-bit code of bounds, derived levels and
// the check of all invariants.
#include "pvol/bounds/pyramid.h"

#include <algorithm>
#include <bit>
#include <cassert>
#include <cmath>
#include <cstdio>
#include <iterator>
#include <string>

namespace pvol {
namespace {

bool by_code(const PyramidNode& a, const PyramidNode& b) { return a.code < b.code; }

/// The parents of a level's nodes, with the extremes of their children.
std::vector<PyramidNode> parents_of(const std::vector<PyramidNode>& children) {
  std::vector<PyramidNode> parents;
  for (std::size_t i = 0; i < children.size();) {
    PyramidNode parent{children[i].code >> 3, children[i].lo, children[i].hi};
    const std::size_t first = i;
    for (; i < children.size() && children[i].code >> 3 == parent.code; ++i) {
      parent.lo = std::min(parent.lo, children[i].lo);
      parent.hi = std::max(parent.hi, children[i].hi);
    }
    if (i - first < 8) parent.lo = 0;  // an absent child is a cube of zeros
    parents.push_back(parent);
  }
  return parents;
}

/// The bits of v, two zeros apart: each step halves the groups and opens gaps between them.
std::uint64_t spread(std::uint32_t v) {
  std::uint64_t x = v & 0x1fffffu;
  x = (x | x << 32) & 0x001f00000000ffffu;
  x = (x | x << 16) & 0x001f0000ff0000ffu;
  x = (x | x << 8) & 0x100f00f00f00f00fu;
  x = (x | x << 4) & 0x10c30c30c30c30c3u;
  return (x | x << 2) & 0x1249249249249249u;
}

std::uint32_t gather(std::uint64_t x) {
  x &= 0x1249249249249249u;
  x = (x | x >> 2) & 0x10c30c30c30c30c3u;
  x = (x | x >> 4) & 0x100f00f00f00f00fu;
  x = (x | x >> 8) & 0x001f0000ff0000ffu;
  x = (x | x >> 16) & 0x001f00000000ffffu;
  return std::uint32_t((x | x >> 32) & 0x1fffffu);
}

// The code counts in units of 2^-41 scale: e = code >> 11, m = code & 2047 stand for m units where
// e = 0 (steps of one unit) and for (2048 + m) << (e - 1) otherwise. The scale, 2^41 units, is e =
// 31, m = 0; codes above it are not used.
constexpr std::uint32_t kMantissaBits = 11;
constexpr std::uint32_t kHidden = 1u << kMantissaBits;
constexpr double kUnits = 0x1p41;  // of the scale

/// The code near v, up to rounding; v <= scale.
std::uint32_t estimate_code(float v, float scale) {
  const auto units = std::uint64_t(double(v) / double(scale) * kUnits);
  if (units < kHidden) return std::uint32_t(units);
  const auto e = std::uint32_t(std::bit_width(units)) - 1 - kMantissaBits;  // (2048 + m) 2^e
  return (e << kMantissaBits) + std::uint32_t(units >> e);
}

/// The number of codes for which `below` holds; it must hold for a lower part of the codes only.
/// Looks around the estimate first, then everywhere: where the scale is denormal, many codes decode
/// to the same number.
template <class Below>
std::uint32_t count_codes(std::uint32_t estimate, Below below) {
  const auto holds = [&](std::uint32_t code) { return below(std::uint16_t(code)); };
  std::uint32_t lo = 0, hi = kTopCode + 1u;
  const std::uint32_t near_lo = estimate < 2 ? 0 : estimate - 2, near_hi = estimate + 2;
  if (near_lo > 0 && holds(near_lo - 1)) lo = near_lo;
  if (near_hi < hi && !holds(near_hi)) hi = near_hi;
  while (lo < hi) {
    const std::uint32_t mid = (lo + hi) / 2;
    if (holds(mid)) {
      lo = mid + 1;
    } else {
      hi = mid;
    }
  }
  return lo;
}

std::string text(float v) {
  char s[32];
  std::snprintf(s, sizeof s, "%.9g", double(v));
  return s;
}

std::string place(std::size_t level, const PyramidNode& n) {
  return "level " + std::to_string(level) + ", node " + std::to_string(n.code) + ": ";
}

std::optional<std::string> check_empty(const Pyramid& p) {
  Pyramid empty;
  empty.look_up = p.look_up;
  if (p == empty) return std::nullopt;
  return "a pyramid without levels must have origin, scale and support 0";
}

std::optional<std::string> check_frame(const Pyramid& p) {
  if (p.root_log2() > kMaxRootLog2) {
    return std::to_string(p.levels.size()) + " levels; at most " +
           std::to_string(kMaxRootLog2 - 2) + " are possible";
  }
  if (!(p.scale > 0) || !std::isfinite(p.scale)) {
    return "scale " + text(p.scale) + "; expected a positive number";
  }
  if (p.look_up == LookUp::nearest)
    return "bounds for nearest interpolation alone; expected trilinear or tricubic";
  const std::int64_t edge = std::int64_t(1) << p.root_log2();
  // The first leaf's apron needs room.
  const std::int64_t least = kMinOrigin + (extent_of(p.look_up).below > 0 ? kLeafEdge : 0);
  for (int axis = 0; axis < 3; ++axis) {
    const std::int64_t origin = p.origin[axis], lo = p.support_lo[axis], hi = p.support_hi[axis];
    if (origin % kLeafEdge != 0 || origin < least || origin > kMaxOrigin) {
      return "origin " + std::to_string(origin) + " is no multiple of 8 among 32-bit integers";
    }
    if (lo < origin || hi <= lo || hi - origin > edge ||
        hi > kMaxOrigin - 2 * kLeafEdge) {  // the last leaf's apron needs room
      return "support [" + std::to_string(lo) + ", " + std::to_string(hi) +
             ") is not inside the root [" + std::to_string(origin) + ", " +
             std::to_string(origin + edge) + ")";
    }
  }
  return std::nullopt;
}

/// Values and order of one level.
std::optional<std::string> check_level(const Pyramid& p, std::size_t level) {
  const std::vector<PyramidNode>& nodes = p.levels[level];
  const std::uint64_t codes = std::uint64_t(1) << 3 * (p.levels.size() - 1 - level);
  for (std::size_t i = 0; i < nodes.size(); ++i) {
    const PyramidNode& n = nodes[i];
    if (n.code >= codes) return place(level, n) + "outside the root";
    if (i > 0 && nodes[i - 1].code >= n.code) return place(level, n) + "out of order";
    if (!(0 <= n.lo && n.lo <= n.hi && 0 < n.hi && n.hi <= p.scale)) {
      return place(level, n) + "bounds [" + text(n.lo) + ", " + text(n.hi) +
             "] are not in order between 0 and the scale " + text(p.scale);
    }
    for (const float v : {n.lo, n.hi}) {
      if (decode(encode_down(v, p.scale), p.scale) != v) {
        return place(level, n) + text(v) + " is not a value of the 16-bit code";
      }
    }
  }
  return std::nullopt;
}

/// Nodes against the level below: every child has its parent, parents have their extremes, and
/// nodes without children are uniform.
std::optional<std::string> check_parents(const Pyramid& p, std::size_t level) {
  const std::vector<PyramidNode> parents = parents_of(p.levels[level - 1]);
  auto parent = parents.begin();
  for (const PyramidNode& n : p.levels[level]) {
    if (parent != parents.end() && parent->code == n.code) {
      if (*parent != n) {
        return place(level, n) + "bounds [" + text(n.lo) + ", " + text(n.hi) +
               "] are not the children's [" + text(parent->lo) + ", " + text(parent->hi) + "]";
      }
      ++parent;
    } else if (encode_up(n.hi, p.scale) > encode_down(n.lo, p.scale) + 1) {
      return place(level, n) + "no children, but bounds [" + text(n.lo) + ", " + text(n.hi) +
             "] of more than one value";
    }
    if (parent != parents.end() && parent->code <= n.code) break;
  }
  if (parent == parents.end()) return std::nullopt;
  return place(level, *parent) + "missing, but its children exist";
}

/// The support must reach into the outermost cubes: a smaller one would cut density off.
std::optional<std::string> check_support(const Pyramid& p) {
  Vec3l lo(std::int64_t(1) << kMaxRootLog2), hi(0);
  for (std::size_t level = 0; level < p.levels.size(); ++level) {
    const std::int64_t edge = std::int64_t(kLeafEdge) << level;
    const auto& below = level == 0 ? std::vector<PyramidNode>{} : parents_of(p.levels[level - 1]);
    for (const PyramidNode& n : p.levels[level]) {
      if (std::binary_search(below.begin(), below.end(), n, by_code)) continue;
      const Vec3l at = Vec3l(morton_decode(n.code)) * edge;
      lo = min(lo, at);
      hi = max(hi, at + Vec3l(edge));
    }
  }
  for (int axis = 0; axis < 3; ++axis) {
    const std::int64_t first = p.support_lo[axis] - p.origin[axis] - lo[axis];
    const std::int64_t last = hi[axis] - (p.support_hi[axis] - p.origin[axis]);
    if (first < 0 || first >= kLeafEdge || last < 0 || last >= kLeafEdge) {
      return "support [" + std::to_string(p.support_lo[axis]) + ", " +
             std::to_string(p.support_hi[axis]) +
             ") does not end in the outermost cubes, which extend from " +
             std::to_string(p.origin[axis] + lo[axis]) + " to " +
             std::to_string(p.origin[axis] + hi[axis]);
    }
  }
  return std::nullopt;
}

}  // namespace

NodeRange children(const Pyramid& pyramid, std::size_t level, std::size_t i) {
  if (level == 0) return {};
  const auto& below = pyramid.levels[level - 1];
  const std::uint64_t first = pyramid.levels[level][i].code * 8;
  const auto begin =
      std::lower_bound(below.begin(), below.end(), PyramidNode{first, 0, 0}, by_code);
  auto end = begin;
  while (end != below.end() && end->code < first + 8) ++end;
  return {std::size_t(begin - below.begin()), std::size_t(end - below.begin())};
}

bool is_uniform(const Pyramid& pyramid, std::size_t level, std::size_t i) {
  return level > 0 && children(pyramid, level, i).empty();
}

std::optional<std::size_t> find(const std::vector<PyramidNode>& level, std::uint64_t code) {
  const auto at = std::lower_bound(level.begin(), level.end(), PyramidNode{code, 0, 0}, by_code);
  if (at == level.end() || at->code != code) return std::nullopt;
  return std::size_t(at - level.begin());
}

void complete_levels(Pyramid& pyramid) {
  for (std::size_t level = 1; level < pyramid.levels.size(); ++level) {
    const std::vector<PyramidNode> parents = parents_of(pyramid.levels[level - 1]);
    std::vector<PyramidNode>& nodes = pyramid.levels[level];
    std::vector<PyramidNode> all;
    all.reserve(parents.size() + nodes.size());
    // Of equal codes the parent is taken, so that completing twice changes nothing.
    std::set_union(parents.begin(), parents.end(), nodes.begin(), nodes.end(),
                   std::back_inserter(all), by_code);
    nodes = std::move(all);
  }
}

std::optional<std::string> validate(const Pyramid& p) {
  if (p.empty()) return check_empty(p);
  if (auto wrong = check_frame(p)) return wrong;
  for (std::size_t level = 0; level < p.levels.size(); ++level) {
    if (auto wrong = check_level(p, level)) return wrong;
  }
  for (std::size_t level = 1; level < p.levels.size(); ++level) {
    if (auto wrong = check_parents(p, level)) return wrong;
  }
  if (p.levels.back().empty()) return "the root is missing";
  if (p.levels.back()[0].hi != p.scale) {
    return "the root's majorant " + text(p.levels.back()[0].hi) + " is not the scale " +
           text(p.scale);
  }
  return check_support(p);
}

std::uint64_t morton_encode(Vec3<std::uint32_t> v) {
  assert((v.x | v.y | v.z) < 1u << 21);
  return spread(v.x) | spread(v.y) << 1 | spread(v.z) << 2;
}

Vec3<std::uint32_t> morton_decode(std::uint64_t code) {
  return {gather(code), gather(code >> 1), gather(code >> 2)};
}

float decode(std::uint16_t code, float scale) {
  const std::uint32_t e = code >> kMantissaBits, m = code & (kHidden - 1);
  const std::uint64_t units = e == 0 ? m : std::uint64_t(kHidden + m) << (e - 1);
  // 12 by 24 significant bits: the product is an exact double, and rounding it is monotonic.
  return float(double(units) * double(scale) * (1 / kUnits));
}

std::uint16_t encode_down(float v, float scale) {
  assert(0 <= v && v <= scale && std::isfinite(scale));
  return std::uint16_t(
      count_codes(estimate_code(v, scale), [&](std::uint16_t c) { return decode(c, scale) <= v; }) -
      1);
}

std::uint16_t encode_up(float v, float scale) {
  assert(0 <= v && v <= scale && std::isfinite(scale));
  return std::uint16_t(
      count_codes(estimate_code(v, scale), [&](std::uint16_t c) { return decode(c, scale) < v; }));
}

}  // namespace pvol
