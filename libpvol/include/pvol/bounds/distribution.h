// How the tightness of bounds is distributed over a cloud, depth by depth.
#pragma once

#include <array>
#include <vector>

#include "pvol/bounds/pyramid.h"
#include "pvol/bounds/statistics.h"

namespace pvol {

/// Shares of quantiles below.
inline constexpr std::array<double, 5> kQuantileShares = {0.05, 0.25, 0.5, 0.75, 0.95};

/// A weighted distribution of ratios >= 0. Bin i holds the share of the weight at ratios in
/// [2^((kFirst + i) / 4), 2^((kFirst + i + 1) / 4)), four bins to a factor of two; what is smaller,
/// 0 among it, and what is larger is apart. All shares add up to 1.
struct Distribution {
  static constexpr int kFirst = -40;            ///< the lowest edge is 2^-10
  static constexpr std::size_t kBins = 4 * 26;  ///< the highest 2^16
  std::array<double, kBins> share{};
  double below = 0, above = 0;
  /// The ratios that 5, 25, 50, 75 and 95 % of the weight do not exceed.
  std::array<double, 5> quantiles{};

  /// Lower edge of bin i; that of bin kBins is the upper edge of the last.
  [[nodiscard]] static double edge(std::size_t i);
};

/// One ratio, with cubes weighted by their volume and by their mass.
struct TwoDistributions {
  Distribution by_volume, by_mass;
};

/// The cubes in which a walk that stops at one depth meets density: those of the depth and the
/// leaves above it. Ratios of their bounds to their own mean density, within the box of the
/// support, at which walks end; empty space is not counted.
struct DepthDistributions {
  int depth = 0;
  TwoDistributions hi;   ///< hi / mean, 1 at best
  TwoDistributions lo;   ///< lo / mean, 1 at best
  TwoDistributions gap;  ///< (hi - lo) / mean, 0 at best
};

/// From the root down; nothing for an empty pyramid. `content` is that of the pyramid.
[[nodiscard]] std::vector<DepthDistributions> measure_distributions(const Pyramid& pyramid,
                                                                    const PyramidContent& content);

/// The share of the support's box that lies in no leaf and no uniform cube: what walks skip.
[[nodiscard]] double empty_share_of_box(const Pyramid& pyramid);

}  // namespace pvol
