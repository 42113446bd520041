#include "pvol/medium/recipe.h"

#include <tbb/parallel_for.h>

#include <cmath>
#include <limits>
#include <memory>

#include "pvol/error.h"

namespace pvol {
namespace {

constexpr double kMostCells = 0x1p48;  // leaves 4 bits of a double for the fraction
constexpr double kInfinity = std::numeric_limits<double>::infinity();

/// All that displacements may add to the depth, anywhere.
Interval total_displacement(const Recipe& recipe) {
  Interval sum;
  for (const Displacement& d : recipe.displacements) {
    sum = sum + Interval(d.amplitude) * hull(0, fbm_range(d.noise));
  }
  return sum;
}

Interval unit_part(Interval a) { return {std::clamp(a.lo, 0.0, 1.0), std::clamp(a.hi, 0.0, 1.0)}; }

double displacement(const Displacement& d, Vec3d p) {
  const double strength = d.amplitude * std::clamp(value(d.mask, p), 0.0, 1.0);
  return strength == 0 ? 0 : strength * fbm(d.noise, p);
}

Interval displacement(const Displacement& d, const Box& box) {
  const Interval strength = Interval(d.amplitude) * unit_part(range(d.mask, box));
  return strength * fbm_range(d.noise, box);
}

/// A recipe with those of its forms that can be the highest somewhere in the box at hand. Leaving
/// the others out changes no value.
struct Part {
  const Recipe* recipe = nullptr;
  Interval displacement;  ///< total_displacement
  std::vector<const FreeForm*> forms;
};

Part whole(const Recipe& recipe) {
  Part part{&recipe, total_displacement(recipe), {}};
  for (const FreeForm& form : recipe.forms) part.forms.push_back(&form);
  return part;
}

/// Rounded operations are monotone, so the density computed from any depth in an interval lies
/// between those of its ends.
double density_at_depth(const Recipe& recipe, double depth) {
  return recipe.density * std::clamp(depth / recipe.edge, 0.0, 1.0);
}
Interval density_at_depth(const Recipe& recipe, Interval depth) {
  return {density_at_depth(recipe, depth.lo), density_at_depth(recipe, depth.hi)};
}
bool is_constant(Interval a) { return a.lo == a.hi; }

double density(const Part& part, Vec3d p) {
  const Recipe& recipe = *part.recipe;
  double depth = -kInfinity;
  for (const FreeForm* form : part.forms) depth = std::max(depth, value(*form, p));
  for (const FreeForm& cut : recipe.cuts) depth = std::min(depth, value(cut, p));
  // Noise is costly, and far from the surface it decides nothing.
  const Interval rough = density_at_depth(recipe, Interval(depth) + part.displacement);
  if (is_constant(rough)) return rough.lo;
  for (const Displacement& d : recipe.displacements) depth += displacement(d, p);
  return density_at_depth(recipe, depth);
}

/// `united` holds the highest form over the box.
Interval density_range(const Part& part, Interval united, const Box& box) {
  const Recipe& recipe = *part.recipe;
  Interval depth = united;
  for (const FreeForm& cut : recipe.cuts) depth = min(depth, range(cut, box));
  const Interval rough = density_at_depth(recipe, depth + part.displacement);
  if (is_constant(rough)) return rough;
  for (const Displacement& d : recipe.displacements) depth = depth + displacement(d, box);
  return density_at_depth(recipe, depth);
}

/// The part's forms that may be the highest somewhere in the box, and the range of the highest.
struct Narrowed {
  Part part;
  Interval united{-kInfinity};
};
Narrowed narrow(const Part& part, const Box& box) {
  std::vector<double> greatest;
  greatest.reserve(part.forms.size());
  Narrowed narrowed{{part.recipe, part.displacement, {}}, {-kInfinity}};
  for (const FreeForm* form : part.forms) {
    const Interval r = range(*form, box);
    narrowed.united = max(narrowed.united, r);
    greatest.push_back(r.hi);
  }
  for (std::size_t i = 0; i < part.forms.size(); ++i) {
    if (greatest[i] >= narrowed.united.lo) narrowed.part.forms.push_back(part.forms[i]);
  }
  return narrowed;
}

/// The samples at origin + [0, edge)^3.
struct Block {
  Vec3i origin;
  std::int32_t edge = 0;
};

Vec3d place(const Recipe& recipe, Vec3i at) { return Vec3d(at) * recipe.voxel; }

/// What one task found.
struct Found {
  std::vector<Vec3i> origins;  ///< of bricks
  std::vector<float> samples;  ///< of all of them
  std::vector<Tile> tiles;
};

void sample_brick(const Part& part, const Block& block, Found& found) {
  const std::size_t begin = found.samples.size();
  for (int i = 0; i < kBrickEdge; ++i) {
    for (int j = 0; j < kBrickEdge; ++j) {
      for (int k = 0; k < kBrickEdge; ++k) {
        const Vec3d p = place(*part.recipe, block.origin + Vec3i{i, j, k});
        found.samples.push_back(static_cast<float>(density(part, p)));
      }
    }
  }
  const auto first = found.samples.begin() + std::ptrdiff_t(begin);
  if (std::any_of(first, found.samples.end(), [](float v) { return v > 0; })) {
    found.origins.push_back(block.origin);
  } else {
    found.samples.resize(begin);
  }
}

bool is_tile(std::int32_t edge) { return edge == 8 || edge == 128 || edge == 4096; }

/// Divides the block into blocks of edge `last` for `visit(part, block)`, and leaves out those in
/// which the density is certainly constant: zero needs no sample, other values become tiles.
template <class Visit>
void divide(const Part& part, const Block& block, std::int32_t last, std::vector<Tile>& tiles,
            const Visit& visit) {
  const Box box{place(*part.recipe, block.origin),
                place(*part.recipe, block.origin + Vec3i(block.edge - 1))};
  const Narrowed near = narrow(part, box);
  const Interval range = density_range(near.part, near.united, box);
  if (range.hi == 0) return;
  if (is_constant(range) && is_tile(block.edge)) {
    tiles.push_back({block.origin, block.edge, static_cast<float>(range.lo)});
  } else if (block.edge == last) {
    visit(near.part, block);
  } else {
    const std::int32_t half = block.edge / 2;
    for (int child = 0; child < 8; ++child) {
      const Vec3i step{child & 1 ? half : 0, child & 2 ? half : 0, child & 4 ? half : 0};
      divide(near.part, {block.origin + step, half}, last, tiles, visit);
    }
  }
}

struct Task {
  Part part;
  Block block;
};
constexpr std::int32_t kTaskEdge = 64;  // some hundred tasks in a grid of 256 samples a side

/// The few largest blocks, aligned to their edge, that hold all samples in the box.
std::vector<Block> roots(const Box& box, double voxel) {
  const auto sample = [&](double x) { return static_cast<std::int32_t>(std::floor(x / voxel)); };
  // One more on each side, whatever the quotients were rounded to.
  const Vec3i lo = Vec3i{sample(box.lo.x), sample(box.lo.y), sample(box.lo.z)} - Vec3i(1);
  const Vec3i hi = Vec3i{sample(box.hi.x), sample(box.hi.y), sample(box.hi.z)} + Vec3i(2);
  std::int32_t edge = kTaskEdge;
  while (edge < max_component(hi - lo)) edge *= 2;
  const auto aligned = [edge](std::int32_t x) { return x & -edge; };
  std::vector<Block> blocks;
  for (std::int32_t x = aligned(lo.x); x <= hi.x; x += edge) {
    for (std::int32_t y = aligned(lo.y); y <= hi.y; y += edge) {
      for (std::int32_t z = aligned(lo.z); z <= hi.z; z += edge)
        blocks.push_back({{x, y, z}, edge});
    }
  }
  return blocks;
}

/// One grid of what the tasks found.
VoxelGrid collect(const Recipe& recipe, std::vector<Found> found, std::vector<Tile> tiles) {
  VoxelGrid grid;
  grid.name = recipe.name;
  grid.index_to_world = scaling(Vec3d(recipe.voxel));
  grid.tiles = std::move(tiles);
  const auto owner = std::make_shared<const std::vector<Found>>(std::move(found));
  for (const Found& f : *owner) {
    grid.tiles.insert(grid.tiles.end(), f.tiles.begin(), f.tiles.end());
    const float* values = f.samples.data();
    for (const Vec3i origin : f.origins) {
      grid.bricks.push_back({origin, values});
      values += kBrickSamples;
    }
  }
  grid.owner = owner;
  sort(grid);
  return grid;
}

void check(bool holds, const std::string& what, double found, const std::string& expected) {
  if (holds) return;
  throw Error("recipe: " + what + " is " + std::to_string(found) + "; expected " + expected);
}

void check_size(const std::string& what, double v) {
  constexpr double kLeast = 1e-30, kMost = 1e30;  // squares and quotients stay far inside double
  check(v >= kLeast && v <= kMost, what, v, "a number in [1e-30, 1e30]");
}

void check_finite(const Quadric& q, const std::string& what) {
  const bool finite =
      is_finite(q.square) && is_finite(q.mixed) && is_finite(q.linear) && std::isfinite(q.constant);
  if (!finite) throw Error("recipe: " + what + " has a coefficient that is not finite");
}

void check_finite(const std::vector<FreeForm>& forms, const std::string& what) {
  for (std::size_t i = 0; i < forms.size(); ++i) {
    const std::string name = what + " " + std::to_string(i + 1);
    check_finite(forms[i].base, name);
    for (const Perturbation& p : forms[i].perturbations) {
      check_finite(p.quadric, name + " in a perturbation");
      check(std::isfinite(p.strength), name + " strength", p.strength, "a finite number");
    }
  }
}

void check(const Displacement& d, const std::string& what) {
  check(std::isfinite(d.amplitude), what + " amplitude", d.amplitude, "a finite number");
  check_finite(d.mask, what + " mask");
  check_size(what + " cell", d.noise.cell);
  check(d.noise.octaves >= 1 && d.noise.octaves <= kMaxOctaves, what + " octaves", d.noise.octaves,
        "a whole number in 1.." + std::to_string(kMaxOctaves));
  check(d.noise.gain > 0 && d.noise.gain <= 1, what + " gain", d.noise.gain, "a number in (0, 1]");
}

}  // namespace

double density(const Recipe& recipe, Vec3d world) { return density(whole(recipe), world); }

Interval density_range(const Recipe& recipe, const Box& world) {
  const Narrowed near = narrow(whole(recipe), world);
  return density_range(near.part, near.united, world);
}

Box support(const Recipe& recipe) {
  // A share of the edge that no rounding of the forms' values reaches, and that no picture shows.
  constexpr double kMargin = 1e-6;
  const double level = -total_displacement(recipe).hi - kMargin * recipe.edge;
  Box box;
  for (const FreeForm& form : recipe.forms) {
    const Box b = bounds(form, level);
    if (!b.empty()) box = {min(box.lo, b.lo), max(box.hi, b.hi)};
  }
  for (const FreeForm& cut : recipe.cuts) {
    const Box b = bounds(cut, level);
    box = {max(box.lo, b.lo), min(box.hi, b.hi)};
  }
  return box.empty() ? Box{} : box;
}

void validate(const Recipe& recipe) {
  check_size("density", recipe.density);
  check_size("edge", recipe.edge);
  if (recipe.forms.empty()) throw Error("recipe: there is no form; add one");
  check_finite(recipe.forms, "form");
  check_finite(recipe.cuts, "cut");
  for (std::size_t i = 0; i < recipe.displacements.size(); ++i) {
    check(recipe.displacements[i], "displacement " + std::to_string(i + 1));
  }
  const Box box = support(recipe);
  if (!box.empty() && !(is_finite(box.lo) && is_finite(box.hi))) {
    throw Error("recipe: the forms reach to infinity; use ellipsoids, or add cuts around them");
  }
  check_size("voxel", recipe.voxel);  // readers derive it from the support
  if (box.empty()) return;
  const double side = max_component(box.extent()) / recipe.voxel;
  const double far = max_component(max(box.hi, -box.lo)) / recipe.voxel;
  check(side <= kLargestResolution, "the longest side in samples", side,
        "at most " + std::to_string(kLargestResolution) + ": enlarge the voxel");
  check(far < 0x1p30, "the distance from the origin in samples", far,
        "less than 2^30: move the forms, or enlarge the voxel");
  for (const Displacement& d : recipe.displacements) {
    const double cells =
        max_component(max(box.hi, -box.lo)) / std::ldexp(d.noise.cell, -d.noise.octaves);
    check(cells < kMostCells, "the distance from the origin in cells of the last octave", cells,
          "less than 2^48: move the forms, enlarge the cell, or take fewer octaves");
  }
}

double voxel_for(const Recipe& recipe, int resolution) {
  const Box box = support(recipe);
  return box.empty() ? recipe.voxel : max_component(box.extent()) / resolution;
}

VoxelGrid make_grid(const Recipe& recipe) {
  validate(recipe);
  const Box box = support(recipe);
  if (box.empty()) return collect(recipe, {}, {});
  std::vector<Task> tasks;
  std::vector<Tile> tiles;
  for (const Block& root : roots(box, recipe.voxel)) {
    divide(whole(recipe), root, kTaskEdge, tiles, [&](const Part& part, const Block& block) {
      tasks.push_back({part, block});
    });
  }
  std::vector<Found> found(tasks.size());
  tbb::parallel_for(std::size_t{0}, tasks.size(), [&](std::size_t i) {
    divide(tasks[i].part, tasks[i].block, kBrickEdge, found[i].tiles,
           [&](const Part& part, const Block& block) { sample_brick(part, block, found[i]); });
  });
  return collect(recipe, std::move(found), std::move(tiles));
}

}  // namespace pvol
