#include "pvol/density/recipe.h"

#include <algorithm>
#include <limits>
#include <utility>

#include "density/recipe_view.h"

namespace pvol {

using detail::is_constant;
using detail::RecipeView;

namespace {

Interval unit_part(Interval a) { return {std::clamp(a.lo, 0.0, 1.0), std::clamp(a.hi, 0.0, 1.0)}; }

double strength(const MaskedNoise& n, Vec3d p) {
  return n.amplitude * std::clamp(value(n.mask, p), 0.0, 1.0);
}

double value(const MaskedNoise& n, Vec3d p) {
  const double s = strength(n, p);
  return s == 0 ? 0 : s * fbm(n.noise, p);
}

Interval range(const MaskedNoise& n, const Box& box) {
  const Interval mask = unit_part(range(n.mask, box));
  return mask.hi == 0 ? Interval() : Interval(n.amplitude) * mask * fbm_range(n.noise, box);
}

/// The product of computed numbers that are not negative: rounding is monotone, so those of the
/// ends hold all.
Interval rounded_product(Interval a, Interval b) { return {a.lo * b.lo, a.hi * b.hi}; }

double density_at_depth(const Recipe& recipe, double depth) {
  return recipe.density * value(recipe.profile, depth / recipe.edge);
}
Interval density_at_depth(const Recipe& recipe, Interval depth) {
  const Interval x{depth.lo / recipe.edge, depth.hi / recipe.edge};
  return rounded_product(recipe.density, range(recipe.profile, x));
}

double modulation(const Recipe& recipe, Vec3d p) {
  double factor = 1;
  for (const MaskedNoise& n : recipe.modulations) factor += value(n, p);
  return std::max(0.0, factor);
}
Interval modulation(const Recipe& recipe, const Box& box) {
  Interval factor = 1;
  for (const MaskedNoise& n : recipe.modulations) factor = factor + range(n, box);
  return max(factor, Interval(0));
}

double density_at_depth(const Solid& solid, double depth) {
  return solid.density * std::clamp(depth / solid.edge, 0.0, 1.0);
}
Interval density_at_depth(const Solid& solid, Interval depth) {
  return {density_at_depth(solid, depth.lo), density_at_depth(solid, depth.hi)};
}

/// `depth` is that of the cloud's body at p, and `displacement` holds all that may be added to it.
double cloud_density(const Recipe& recipe, Interval displacement, double depth, Vec3d p) {
  // Noise is costly, and far from the surface it decides nothing.
  const Interval rough = density_at_depth(recipe, Interval(depth) + displacement);
  double rho = rough.lo;
  if (!is_constant(rough)) {
    for (const MaskedNoise& n : recipe.displacements) depth += value(n, p);
    rho = density_at_depth(recipe, depth);
  }
  return recipe.modulations.empty() || rho == 0 ? rho : rho * modulation(recipe, p);
}

/// Adds a noise to the `sum` of each open point.
void add(const MaskedNoise& n, std::span<const detail::RecipePoint> points,
         detail::RecipeScratch& scratch, std::vector<double>& sum) {
  scratch.noise.n = 0;
  scratch.of.clear();
  scratch.strength.clear();
  for (const std::uint32_t i : scratch.open) {
    const double s = strength(n, points[i].at);
    if (s == 0) continue;
    scratch.noise.add(points[i].at);
    scratch.of.push_back(i);
    scratch.strength.push_back(s);
  }
  find_fbm(n.noise, scratch.noise);
  for (std::size_t k = 0; k < scratch.of.size(); ++k) {
    sum[scratch.of[k]] += scratch.strength[k] * scratch.noise.noise[k];
  }
}

/// cloud_density at all points, for bodies' depths in the scratch: its `rho`.
void cloud_densities(const Recipe& recipe, std::span<const detail::RecipePoint> points,
                     detail::RecipeScratch& scratch) {
  std::vector<std::uint32_t>& open = scratch.open;
  std::vector<double>& rho = scratch.rho;
  rho.resize(points.size());
  open.clear();
  for (std::uint32_t i = 0; i < points.size(); ++i) {
    const Interval rough =
        density_at_depth(recipe, Interval(scratch.depth[i]) + points[i].view->displacement);
    rho[i] = rough.lo;
    if (!is_constant(rough)) open.push_back(i);
  }
  for (const MaskedNoise& n : recipe.displacements) add(n, points, scratch, scratch.depth);
  for (const std::uint32_t i : open) rho[i] = density_at_depth(recipe, scratch.depth[i]);
  if (recipe.modulations.empty()) return;
  open.clear();
  for (std::uint32_t i = 0; i < points.size(); ++i) {
    if (rho[i] != 0) open.push_back(i);
  }
  scratch.modulation.assign(points.size(), 1);
  for (const MaskedNoise& n : recipe.modulations) add(n, points, scratch, scratch.modulation);
  for (const std::uint32_t i : open) rho[i] *= std::max(0.0, scratch.modulation[i]);
}

/// The greatest of the cloud's density and those of the solids.
double with_solids(const RecipeView& view, double rho, Vec3d p) {
  for (const detail::SolidView& s : view.solids) {
    rho = std::max(rho, density_at_depth(*s.solid, value(s.body, p)));
  }
  return rho;
}

/// `depth` holds the cloud's body over the box.
Interval cloud_range(const RecipeView& view, Interval depth, const Box& box) {
  const Recipe& recipe = *view.recipe;
  Interval rho = density_at_depth(recipe, depth + view.displacement);
  if (!is_constant(rho)) {
    for (const MaskedNoise& n : recipe.displacements) depth = depth + range(n, box);
    rho = density_at_depth(recipe, depth);
  }
  if (recipe.modulations.empty() || rho.hi == 0) return rho;
  return rounded_product(rho, modulation(recipe, box));
}

std::vector<BodyView> views(const std::vector<Body>& bodies) {
  std::vector<BodyView> result;
  for (const Body& body : bodies) result.push_back(view(body));
  return result;
}

// A share of the edge that no rounding of the bodies' values reaches, and that no picture shows.
constexpr double kMargin = 1e-6;

Box cloud_support(const Recipe& recipe) {
  const double level =
      recipe.edge * (start(recipe.profile) - kMargin) - detail::total(recipe.displacements).hi;
  Box box;
  for (const Body& form : recipe.forms) box = join(box, bounds(form, level));
  for (const Body& cut : recipe.cuts) {
    const Box b = bounds(cut, level);
    box = {max(box.lo, b.lo), min(box.hi, b.hi)};
  }
  return box.empty() ? Box{} : box;
}

}  // namespace

namespace detail {

Interval total(const std::vector<MaskedNoise>& noises) {
  Interval sum;
  for (const MaskedNoise& n : noises) {
    sum = sum + Interval(n.amplitude) * hull(0, fbm_range(n.noise));
  }
  return sum;
}

RecipeView view(const Recipe& recipe) {
  std::vector<BodyView> all = views(recipe.cuts);
  all.push_back(combine(BodyView::Op::max, views(recipe.forms)));
  RecipeView result{&recipe,
                    total(recipe.displacements),
                    combine(BodyView::Op::min, std::move(all)),
                    {},
                    support(recipe)};
  for (const Solid& solid : recipe.solids) result.solids.push_back({&solid, view(solid.body)});
  return result;
}

double density(const RecipeView& view, Vec3d p) {
  const double depth = value(view.cloud, p);
  return with_solids(view, cloud_density(*view.recipe, view.displacement, depth, p), p);
}

void densities(std::span<const RecipePoint> points, RecipeScratch& scratch, float* rho) {
  if (points.empty()) return;
  scratch.depth.clear();
  for (const RecipePoint& p : points) scratch.depth.push_back(value(p.view->cloud, p.at));
  cloud_densities(*points.front().view->recipe, points, scratch);
  for (std::size_t i = 0; i < points.size(); ++i) {
    rho[i] = static_cast<float>(with_solids(*points[i].view, scratch.rho[i], points[i].at));
  }
}

NarrowedRecipe narrow(const RecipeView& view, const Box& box) {
  const Box inside{max(view.support.lo, box.lo), min(view.support.hi, box.hi)};
  if (inside.empty()) return {{view.recipe, view.displacement, {}, {}, {}}, 0};
  NarrowedBody cloud = narrow(view.cloud, box);
  const Interval cloud_rho = cloud_range(view, cloud.range, box);
  Interval rho = cloud_rho;
  RecipeView near{view.recipe, view.displacement, std::move(cloud.view), {}, view.support};
  for (const SolidView& s : view.solids) {
    NarrowedBody body = narrow(s.body, box);
    const Interval solid_rho = density_at_depth(*s.solid, body.range);
    if (solid_rho.hi == 0) continue;
    rho = max(rho, solid_rho);
    near.solids.push_back({s.solid, std::move(body.view)});
  }
  if (cloud_rho.hi < rho.lo) near.cloud = {};  // certainly below a solid
  return {std::move(near), rho};
}

}  // namespace detail

double density(const Recipe& recipe, Vec3d world) {
  double depth = -std::numeric_limits<double>::infinity();
  for (const Body& form : recipe.forms) depth = std::max(depth, value(form, world));
  for (const Body& cut : recipe.cuts) depth = std::min(depth, value(cut, world));
  double rho = cloud_density(recipe, detail::total(recipe.displacements), depth, world);
  for (const Solid& solid : recipe.solids) {
    rho = std::max(rho, density_at_depth(solid, value(solid.body, world)));
  }
  return rho;
}

Interval density_range(const Recipe& recipe, const Box& world) {
  return narrow(detail::view(recipe), world).density;
}

Box support(const Recipe& recipe) {
  Box box = cloud_support(recipe);
  for (const Solid& solid : recipe.solids) {
    box = join(box, bounds(solid.body, -kMargin * solid.edge));
  }
  return box;
}

double voxel_for(const Recipe& recipe, int resolution) {
  const Box box = support(recipe);
  return box.empty() ? recipe.voxel : max_component(box.extent()) / resolution;
}

}  // namespace pvol
