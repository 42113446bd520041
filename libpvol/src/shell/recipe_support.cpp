#include "pvol/shell/recipe_support.h"

#include <iterator>
#include <utility>

#include "bounds/divide_recipe.h"

namespace pvol {
namespace {

using detail::code_of;
using detail::Cube;
using detail::divide_root;
using detail::kLeafLog2;
using detail::NarrowedRecipe;
using detail::RecipeView;
using detail::root_of;

/// What a task finds of the support.
struct FoundCells {
  std::vector<MaskedBlock> parts;
  std::vector<SupportBlock> full;
};

void mark(const Cube& block, const Cube& cube, CellMask& mask) {
  const Vec3l from = cube.lo - block.lo;
  for (std::int64_t x = from.x; x < from.x + cube.edge(); ++x) {
    for (std::int64_t y = from.y; y < from.y + cube.edge(); ++y) {
      const std::uint64_t row = (std::uint64_t(1) << cube.edge()) - 1;
      mask[std::size_t(x)] |= row << (8 * y + from.z);
    }
  }
}

void mark_occupied(const RecipeView& view, const Cube& block, const Cube& cube, Interval range,
                   int last, CellMask& mask) {
  if (range.hi == 0) return;
  if (range.lo > 0 || cube.log2 == last) return mark(block, cube, mask);
  for (int c = 0; c < 8; ++c) {
    const Cube part = cube.child(c);
    const NarrowedRecipe near = narrow(view, part);
    mark_occupied(near.view, block, part, near.density, last, mask);
  }
}

}  // namespace

Support make_support(const Recipe& recipe, int block_log2) {
  validate(recipe);
  detail::check_range(block_log2, "the size of support blocks as a power of two");
  const Box box = support(recipe);
  if (box.empty()) return {};
  const Cube root = root_of(recipe, box);
  const auto whole = [&](const Cube& cube, Interval range, FoundCells& found) {
    if (!(range.lo > 0) || cube.log2 == kLeafLog2) return false;
    const std::uint64_t code = code_of(root, {cube.lo, kLeafLog2});
    found.full.push_back({code, std::uint32_t(cube.log2 - kLeafLog2), 0});
    return true;
  };
  const auto leaf = [&](const RecipeView& view, const Cube& cube, Interval range,
                        FoundCells& found) {
    MaskedBlock part{code_of(root, cube), {}};
    mark_occupied(view, cube, cube, range, block_log2, part.mask);
    found.parts.push_back(part);
  };
  FoundCells all;
  for (FoundCells& f : divide_root<FoundCells>(detail::view(recipe), root, whole, leaf)) {
    std::move(f.parts.begin(), f.parts.end(), std::back_inserter(all.parts));
    std::move(f.full.begin(), f.full.end(), std::back_inserter(all.full));
  }
  const Support s = make_support(root.lo, root.log2, std::move(all.parts), std::move(all.full));
  return s.empty() ? Support{} : s;
}

}  // namespace pvol
