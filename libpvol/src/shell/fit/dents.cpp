#include "shell/fit/dents.h"

#include <algorithm>

#include "pvol/math/parallel.h"
#include "pvol/shell/certificate.h"
#include "shell/fit/enclosing_ellipsoid.h"
#include "shell/fit/monomials.h"
#include "shell/fit/sampling.h"

namespace pvol::detail {
namespace {

constexpr std::size_t kMostBoundary = std::size_t(1) << 18;
constexpr std::size_t kMostTargets = std::size_t(1) << 15;

// The evaluator's error grows with the coefficients of a whole shell; `fit_shell` checks the sum.
constexpr double kMargin = 4;

// Seeds of a search, and how many of them get more than a glance.
constexpr int kFarBalls = 14, kOtherBalls = 6, kPlanes = 8;
constexpr std::size_t kLongLooks = 6;
constexpr std::size_t kPlaneTargets = 8192;  // cells that planes are chosen by

SearchEffort glance(int effort) {
  SearchEffort e;
  e.iterations = 60 * effort;
  e.rounds = 2;
  e.boundary = e.targets = 3072;
  e.width_begin = 0.5;
  e.width_end = 0.08;
  e.rate_begin = 0.1;
  e.rate_end = 0.02;
  return e;
}

SearchEffort long_look(int effort) {
  SearchEffort e;
  e.iterations = 1000 * effort;
  e.rounds = 6;
  e.boundary = 6144;
  e.targets = 8192;
  e.width_begin = 0.12;
  e.width_end = 0.01;
  e.rate_begin = 0.02;
  e.rate_end = 0.002;
  return e;
}

/// A ball.
Seed ball(Vec3d centre, double radius) {
  return {ellipsoid(centre, Vec3d(radius)), centre, radius};
}

/// A search that goes on from a quadric, in the frame of what it removes.
Seed around(const Quadric& q, const Points& targets, double least) {
  Cluster removed;
  for (std::size_t i = 0; i < targets.size(); ++i) {
    const Vec3d p(targets[i]);
    if (value(q, p) > 0) removed.add(p);
  }
  if (removed.count == 0) return {q, {}, 1};
  return {q, removed.centre(), removed.radius(least)};
}

}  // namespace

Dents::Dents(const Support& support, int effort)
    : support_(support), effort_(effort), lattice_(make_lattice(support)) {
  lattice_.boundary = thinned(lattice_.boundary, kMostBoundary, 0);
  covers_.assign(lattice_.empty.size(), 0);
}

std::vector<std::uint8_t> Dents::inside(const Quadric& q) const {
  std::vector<float> values(lattice_.empty.size());
  evaluate(monomials(q), lattice_.empty, values.data());
  std::vector<std::uint8_t> result(values.size());
  for (std::size_t i = 0; i < values.size(); ++i) result[i] = values[i] > 0;
  return result;
}

bool Dents::add() {
  std::vector<std::uint32_t> cells;
  for (std::size_t i = 0; i < covers_.size(); ++i) {
    if (covers_[i] == 0) cells.push_back(std::uint32_t(i));
  }
  if (cells.empty()) return false;
  std::vector<Seed> seeds;
  if (quadrics_.empty()) {
    seeds.push_back({-enclosing_ellipsoid(lattice_.boundary), {}, 1});
  } else {
    seeds = make_seeds(cells);
  }
  const Found found = best(cells, seeds);
  if (found.removed == 0) return false;
  quadrics_.push_back(found.quadric);
  count(found.quadric, 1);
  return true;
}

bool Dents::refit(std::size_t j) {
  Quadric& q = quadrics_[j];
  const std::vector<std::uint8_t> before = inside(q);
  std::vector<std::uint32_t> cells;
  Cluster removed;
  for (std::size_t i = 0; i < covers_.size(); ++i) {
    if (covers_[i] != before[i]) continue;
    cells.push_back(std::uint32_t(i));
    if (before[i]) removed.add(Vec3d(lattice_.empty[i]));
  }
  if (cells.empty()) return false;
  std::vector<Seed> seeds;
  if (j == 0) {
    seeds.push_back({q, {}, 1});
  } else {
    seeds = make_seeds(cells);
    if (removed.count > 0) {
      seeds.push_back({q, removed.centre(), removed.radius(lattice_.edge)});
    }
  }
  const Found found = best(cells, seeds);
  if (found.removed <= removed.count) return false;
  count(q, -1);
  q = found.quadric;
  count(q, 1);
  return true;
}

void Dents::keep(std::size_t count_kept) {
  while (quadrics_.size() > count_kept) {
    count(quadrics_.back(), -1);
    quadrics_.pop_back();
  }
}

void Dents::count(const Quadric& q, int change) {
  const std::vector<std::uint8_t> covered = inside(q);
  for (std::size_t i = 0; i < covered.size(); ++i) {
    covers_[i] = std::uint8_t(covers_[i] + change * covered[i]);
  }
}

std::vector<Seed> Dents::make_seeds(const std::vector<std::uint32_t>& cells) const {
  const std::size_t balls = std::size_t(kFarBalls * effort_);
  const std::size_t others = std::size_t(kOtherBalls * effort_);
  std::vector<Seed> seeds;

  // Balls at the cells farthest from the support, none with its centre in another.
  std::vector<std::uint32_t> order;
  for (const std::uint32_t i : spread(cells.size(), kMostTargets, 1)) order.push_back(cells[i]);
  for (const std::uint32_t i : spread(order.size(), others, 2)) {
    seeds.push_back(ball(Vec3d(lattice_.empty[order[i]]), double(lattice_.gap[order[i]])));
  }
  std::sort(order.begin(), order.end(), [&](std::uint32_t a, std::uint32_t b) {
    return lattice_.gap[a] != lattice_.gap[b] ? lattice_.gap[a] > lattice_.gap[b] : a < b;
  });
  std::vector<Seed> far;
  for (const std::uint32_t i : order) {
    if (far.size() == balls) break;
    const Vec3d p(lattice_.empty[i]);
    const bool covered = std::any_of(
        far.begin(), far.end(), [&](const Seed& s) { return length(p - s.centre) < s.radius; });
    if (!covered) far.push_back(ball(p, double(lattice_.gap[i])));
  }
  seeds.insert(seeds.end(), far.begin(), far.end());

  // Half-spaces beyond the support, in the directions in which most cells lie there.
  constexpr int kDirections = 60;
  std::vector<std::pair<std::size_t, Seed>> beyond;
  std::vector<std::uint32_t> sample;
  for (const std::uint32_t i : spread(order.size(), kPlaneTargets, 4)) sample.push_back(order[i]);
  for (int k = 0; k < kDirections; ++k) {
    const Vec3d n = direction_on_spiral(k, kDirections);
    Quadric plane{{}, {}, n, 0};
    plane.constant = -double(greatest(monomials(plane), lattice_.boundary));
    Cluster removed;
    for (const std::uint32_t i : sample) {
      const Vec3d p(lattice_.empty[i]);
      if (value(plane, p) > 0) removed.add(p);
    }
    if (removed.count == 0) continue;
    beyond.push_back({removed.count, {plane, removed.centre(), removed.radius(lattice_.edge)}});
  }
  std::stable_sort(beyond.begin(), beyond.end(),
                   [](const auto& a, const auto& b) { return a.first > b.first; });
  beyond.resize(std::min(std::size_t(kPlanes * effort_), beyond.size()));
  for (const auto& [count, seed] : beyond) seeds.push_back(seed);
  return seeds;
}

Dents::Found Dents::best(const std::vector<std::uint32_t>& cells, std::vector<Seed> seeds) const {
  Points targets;
  for (const std::uint32_t i : spread(cells.size(), kMostTargets, 3)) {
    targets.add(lattice_.empty[cells[i]]);
  }
  std::vector<Separation> found(seeds.size());
  const auto search = [&](const SearchEffort& effort) {
    parallel_for(0, seeds.size(), [&](std::size_t i) {
      found[i] = separate(lattice_.boundary, targets, seeds[i], effort, i);
    });
  };
  if (seeds.size() > kLongLooks) {
    search(glance(effort_));
    std::stable_sort(found.begin(), found.end(), [](const Separation& a, const Separation& b) {
      return a.removed > b.removed;
    });
    found.resize(kLongLooks);
    seeds.clear();
    for (const Separation& s : found) seeds.push_back(around(s.quadric, targets, lattice_.edge));
  }
  search(long_look(effort_));
  // The proof may cost a search what it gained between boundary points: compare what is proven.
  std::vector<Found> proven(found.size());
  parallel_for(0, found.size(), [&](std::size_t i) {
    proven[i].quadric = settle(found[i].quadric);
    const std::vector<std::uint8_t> covered = inside(proven[i].quadric);
    for (const std::uint32_t c : cells) proven[i].removed += covered[c];
  });
  return *std::max_element(proven.begin(), proven.end(),
                           [](const Found& x, const Found& y) { return x.removed < y.removed; });
}

Quadric Dents::settle(Quadric q) const {
  // The constant last: it must make up for the rounding of all others.
  q.constant = 0;
  q = round_to_float(FreeForm{q, {}}).base;
  const double above =
      certify_above(FreeForm{q, {}}, support_, frame(support_.lo, support_.hi)).bound;
  Shell alone;
  alone.lo = support_.lo;
  alone.hi = support_.hi;
  alone.form.base = -q;
  alone.form.base.constant = above;
  const float margin = float(above + kMargin * evaluator_margin(alone));
  q.constant = -double(std::nextafter(margin, std::numeric_limits<float>::infinity()));
  return q;
}

}  // namespace pvol::detail
