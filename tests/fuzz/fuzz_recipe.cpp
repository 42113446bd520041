// Recipes, and what tools do with those that describe few samples.
#include <cmath>

#include "fuzz.h"
#include "pvol/bounds/recipe_bounds.h"
#include "pvol/formats/recipe_file.h"
#include "use_cloud.h"

namespace {

using namespace pvol;

constexpr double kMostSamples = 16 * 16 * 16;

double count_samples(const Recipe& recipe) {
  const Vec3d size = support(recipe).hi - support(recipe).lo;
  return (size.x / recipe.voxel + 1) * (size.y / recipe.voxel + 1) * (size.z / recipe.voxel + 1);
}

/// Values of the recipe lie in the range that is told for its box.
void check_range(const Recipe& recipe) {
  const Box box = support(recipe);
  const Interval range = density_range(recipe, box);
  const double value = density(recipe, 0.5 * (box.lo + box.hi));
  fuzz::require(value >= 0 && std::isfinite(value), "a density is negative or not finite");
  fuzz::require(range.lo <= value && value <= range.hi, "a density is outside its range");
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string_view text(reinterpret_cast<const char*>(data), size);
  fuzz::accepts([&] {
    const Recipe recipe = formats::parse_recipe(text, "recipe.toml");
    if (!support(recipe).empty()) check_range(recipe);
    if (count_samples(recipe) > kMostSamples) return;
    fuzz::use_grid(make_grid(recipe));
    const auto flow = formats::parse_flow(text, "recipe.toml");
    if (flow && !support(recipe).empty()) (void)sample_flow(*flow, support(recipe), recipe.voxel);
  });
  return 0;
}
