// Where in a picture the work is, before it is rendered: for cutting it into parts that take
// equally long.
#pragma once

#include <vector>

#include "pvol/render/plan.h"

namespace pvol {

/// Pixels of an image, counted from its upper left corner.
struct PixelRect {
  int x = 0, y = 0, width = 0, height = 0;
  friend bool operator==(const PixelRect&, const PixelRect&) = default;
};

/// The part of an image that is rendered: all of it, or the crop.
[[nodiscard]] PixelRect rendered_part(const RenderOptions& options);

/// The work in cells that cover the part of a picture that is rendered, row by row.
struct CostMap {
  double left = 0, top = 0;                ///< of the first cell, in pixels of the image
  double cell_width = 1, cell_height = 1;  ///< likewise
  int columns = 0, rows = 0;
  std::vector<double> work;        ///< in mean samples of the picture
  std::vector<double> pilot_work;  ///< of the pilot, for adaptive samples
};

/// Renders a small picture of the plan's scene, of about `cells` pixels with a few samples each,
/// and prices the work in it by the cost model (THEORY.md, T6.1). The unit is what a sample costs
/// on average where all pixels have equally many: the sum is then the number of samples. Adaptive
/// samples follow from the small picture's noise (T5.8). Deterministic. Throws what `plan` and
/// `render` throw.
[[nodiscard]] CostMap map_cost(const RenderPlan& plan, int cells);

/// The work in any rectangle, in constant time.
class CostSums {
 public:
  /// `work` has one number for each of the map's cells, which are spread evenly in the cell.
  CostSums(const CostMap& map, const std::vector<double>& work);

  [[nodiscard]] double of(const PixelRect& part) const;

 private:
  double left_, top_, cell_width_, cell_height_;
  int columns_, rows_;
  std::vector<double> below_;  // sums of cells left of and above a corner

  [[nodiscard]] double before(double x, double y) const;
};

}  // namespace pvol
