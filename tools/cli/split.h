// A picture in parts that take about equally long.
#pragma once

#include <cstdint>
#include <vector>

#include "pvol/render/cost_map.h"

namespace pvol::cli {

/// Some samples of some pixels.
struct PicturePart {
  PixelRect pixels;
  std::uint32_t first_sample = 0, end_sample = 0;  ///< of each pixel: from the first up to the end
  double share = 0;                                ///< of the picture's forecast cost
};

inline constexpr int kMostParts = 100'000;

/// Cuts a picture of so many samples a pixel into exactly `count` parts, 1 or more, that cover each
/// sample of each pixel of `whole` once. Rectangles are halved, or nearly, where that halves their
/// cost. They have 16 x 16 pixels or more where that leaves enough of them of even cost; where it
/// does not, samples are cut as well and, in the end, smaller rectangles. Throws UsageError for
/// more parts than samples.
[[nodiscard]] std::vector<PicturePart> split_picture(const PixelRect& whole, std::uint32_t samples,
                                                     int count, const CostSums& cost);

/// The largest share of the parts over their mean: 1 where all take equally long.
[[nodiscard]] double imbalance(const std::vector<PicturePart>& parts);

}  // namespace pvol::cli
