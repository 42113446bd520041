#include "cli/split.h"

#include <fmt/format.h>

#include <algorithm>
#include <queue>

#include "cli/cli.h"

namespace pvol::cli {
namespace {

constexpr int kLeastEdge = 16;  // of a rectangle: a tile of the renderer

/// How many rectangles of an edge fit along a length: one where none does.
std::int64_t places(int length, int edge) { return std::max(1, length / edge); }

std::int64_t capacity(const PixelRect& r, int edge) {
  return places(r.width, edge) * places(r.height, edge);
}

/// The two rectangles left and right of a cut, or above and below it.
std::pair<PixelRect, PixelRect> cut(const PixelRect& r, bool across, int at) {
  PixelRect a = r, b = r;
  if (across) {
    a.width = at, b.x += at, b.width -= at;
  } else {
    a.height = at, b.y += at, b.height -= at;
  }
  return {a, b};
}

class Bisection {
 public:
  Bisection(const CostSums& cost, int edge) : cost_(cost), edge_(edge) {}

  /// Cuts a rectangle into so many of about equal cost. There must be room for them.
  void run(const PixelRect& r, std::int64_t count) {
    if (count == 1) {
      rectangles.push_back(r);
      return;
    }
    const bool across =
        places(r.height, edge_) == 1 || (r.width >= r.height && places(r.width, edge_) > 1);
    const std::int64_t beside = places(across ? r.height : r.width, edge_);
    const std::int64_t along = places(across ? r.width : r.height, edge_);
    const auto rows = [&](std::int64_t n) { return (n + beside - 1) / beside; };
    std::int64_t first = count / 2;
    // Full rows on one side always leave room on the other.
    if (rows(first) + rows(count - first) > along) {
      first = std::max(beside, first / beside * beside);
    }
    const int length = across ? r.width : r.height;
    const int at = std::clamp(best_cut(r, across, double(first) / double(count)),
                              int(rows(first)) * edge_, length - int(rows(count - first)) * edge_);
    const auto [a, b] = cut(r, across, at);
    run(a, first);
    run(b, count - first);
  }

  std::vector<PixelRect> rectangles;

 private:
  const CostSums& cost_;
  int edge_;

  /// The edge between pixels next to where this share of the cost lies on the one side.
  [[nodiscard]] int best_cut(const PixelRect& r, bool across, double share) const {
    const int length = across ? r.width : r.height;
    const double wanted = cost_.of(r) * share;
    if (!(wanted > 0)) return int(length * share);
    const auto before = [&](int at) { return cost_.of(cut(r, across, at).first); };
    int lo = 0, hi = length;
    while (hi - lo > 1) {
      const int middle = lo + (hi - lo) / 2;
      (before(middle) <= wanted ? lo : hi) = middle;
    }
    return wanted - before(lo) < before(hi) - wanted ? lo : hi;
  }
};

/// The largest edge with which there are rectangles and samples enough.
int choose_edge(const PixelRect& whole, std::uint32_t samples, int count) {
  const std::int64_t wanted = (count + std::int64_t(samples) - 1) / samples;
  int edge = kLeastEdge;
  while (edge > 1 && capacity(whole, edge) < wanted) edge /= 2;
  if (capacity(whole, edge) >= wanted) return edge;
  throw UsageError(fmt::format(
      "--split {}: the picture has {} x {} pixels with {} samples each; expected at most {} parts",
      count, whole.width, whole.height, samples, capacity(whole, 1) * samples));
}

/// Into how many ranges each rectangle's samples are cut, for `count` parts: always the dearest
/// ones are cut once more. There must be samples enough.
std::vector<std::uint32_t> sample_cuts(const std::vector<double>& costs, std::uint32_t samples,
                                       std::int64_t count) {
  std::vector<std::uint32_t> cuts(costs.size(), 1);
  using Dear = std::pair<double, std::size_t>;  // cost of a part of it, rectangle
  std::priority_queue<Dear> dear;
  for (std::size_t i = 0; i < costs.size(); ++i) dear.emplace(costs[i], i);
  for (count -= std::int64_t(costs.size()); count > 0; --count) {
    while (cuts[dear.top().second] == samples) dear.pop();
    const std::size_t i = dear.top().second;
    dear.pop();
    ++cuts[i];
    dear.emplace(costs[i] / cuts[i], i);
  }
  return cuts;
}

/// The picture in so many rectangles, and those in `count` parts.
std::vector<PicturePart> split_into(const PixelRect& whole, std::uint32_t samples, int count,
                                    const CostSums& cost, int edge, std::int64_t rectangles) {
  Bisection bisection(cost, edge);
  bisection.run(whole, rectangles);
  const double total = cost.of(whole);
  std::vector<double> shares;
  for (const PixelRect& r : bisection.rectangles) {
    const double pixels = double(r.width) * r.height / (double(whole.width) * whole.height);
    shares.push_back(total > 0 ? cost.of(r) / total : pixels);
  }
  const std::vector<std::uint32_t> cuts = sample_cuts(shares, samples, count);
  std::vector<PicturePart> parts;
  for (std::size_t i = 0; i < cuts.size(); ++i) {
    const auto bound = [&](std::uint64_t j) { return std::uint32_t(j * samples / cuts[i]); };
    for (std::uint32_t j = 0; j < cuts[i]; ++j) {
      const std::uint32_t first = bound(j), end = bound(j + std::uint64_t(1));
      parts.push_back({bisection.rectangles[i], first, end, shares[i] * (end - first) / samples});
    }
  }
  return parts;
}

}  // namespace

std::vector<PicturePart> split_picture(const PixelRect& whole, std::uint32_t samples, int count,
                                       const CostSums& cost) {
  constexpr double kEven = 1.1;  // the forecast itself is not better
  const int edge = choose_edge(whole, samples, count);
  std::vector<PicturePart> best;
  // Where rectangles get too small to be even, larger ones in ranges of samples may be; but files
  // of parts are as large as their rectangles.
  for (std::int64_t n = std::min<std::int64_t>(count, capacity(whole, edge));
       n > 0 && n >= (count + std::int64_t(samples) - 1) / samples; n /= 2) {
    std::vector<PicturePart> parts = split_into(whole, samples, count, cost, edge, n);
    if (best.empty() || imbalance(parts) < imbalance(best)) best = std::move(parts);
    if (imbalance(best) <= kEven) break;
  }
  return best;
}

double imbalance(const std::vector<PicturePart>& parts) {
  double sum = 0, largest = 0;
  for (const PicturePart& p : parts) sum += p.share, largest = std::max(largest, p.share);
  return sum > 0 ? largest * double(parts.size()) / sum : 1;
}

}  // namespace pvol::cli
