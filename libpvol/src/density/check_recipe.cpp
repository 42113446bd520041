// What a recipe must hold to be sampled and bounded.
#include <algorithm>
#include <cmath>
#include <string>

#include "density/recipe_view.h"
#include "math/digits.h"
#include "pvol/density/recipe.h"
#include "pvol/error.h"

namespace pvol {
namespace {

constexpr double kMostCells = 0x1p48;  // leaves 4 bits of a double for the fraction
constexpr double kLeastSize = 1e-30, kMostSize = 1e30;  // squares and quotients stay far inside

void check(bool holds, const std::string& what, double found, const std::string& expected) {
  if (holds) return;
  throw Error("recipe: " + what + " is " + detail::digits(found, 6) + "; expected " + expected);
}

void check_size(const std::string& what, double v) {
  check(v >= kLeastSize && v <= kMostSize, what, v, "a number in [1e-30, 1e30]");
}

void check_depth(const std::string& what, int depth) {
  check(depth <= kDeepestTree, what + " depth", depth,
        "at most " + std::to_string(kDeepestTree) + " levels: divide it into several bodies");
}

void check(const Quadric& q, const std::string& what) {
  const bool finite =
      is_finite(q.square) && is_finite(q.mixed) && is_finite(q.linear) && std::isfinite(q.constant);
  if (!finite) throw Error("recipe: " + what + " has a coefficient that is not finite");
}

void check(const FreeForm& form, const std::string& what, int depth = 0) {
  check_depth(what + " perturbations'", depth);
  check(form.base, what);
  for (const Perturbation& p : form.perturbations) {
    check(p.form, depth == 0 ? what + " in a perturbation" : what, depth + 1);
    check(std::isfinite(p.strength), what + " strength", p.strength, "a finite number");
  }
}

std::string numbered(const std::string& what, std::size_t i) {
  return what + " " + std::to_string(i + 1);
}

void check(const Body& body, const std::string& what, int depth = 0) {
  check_depth(what, depth);
  if (body.op == BodyOp::form) return check(body.form, what);
  if (body.parts.empty()) throw Error("recipe: " + what + " has no parts; expected at least one");
  for (std::size_t i = 0; i < body.parts.size(); ++i) {
    check(body.parts[i], numbered(what + ", part", i), depth + 1);
  }
}

void check(const MaskedNoise& n, const std::string& what) {
  check(std::isfinite(n.amplitude), what + " amplitude", n.amplitude, "a finite number");
  check(n.mask, what + " mask");
  check_size(what + " cell", n.noise.cell);
  check(n.noise.octaves >= 1 && n.noise.octaves <= kMaxOctaves, what + " octaves", n.noise.octaves,
        "a whole number in 1.." + std::to_string(kMaxOctaves));
  check(n.noise.gain > 0 && n.noise.gain <= 1, what + " gain", n.noise.gain, "a number in (0, 1]");
}

void check(const Profile& profile) {
  if (profile.kind != ProfileKind::table) return;
  const std::vector<ProfilePoint>& points = profile.points;
  check(points.size() >= 2, "the number of points in the profile", double(points.size()),
        "at least 2");
  for (std::size_t i = 0; i < points.size(); ++i) {
    const std::string what = numbered("profile point", i);
    check(std::abs(points[i].depth) <= kMostSize, what + " depth", points[i].depth,
          "a number in [-1e30, 1e30]");
    check(points[i].density >= 0 && points[i].density <= kMostSize, what + " density",
          points[i].density, "a number in [0, 1e30]");
    if (i == 0) continue;
    check(points[i].depth - points[i - 1].depth >= kLeastSize, what + " depth", points[i].depth,
          "more than the depth of the point before it");
  }
  check(points.front().density == 0, "the first density of the profile", points.front().density,
        "0, so that the cloud ends");
  check(largest(profile) > 0, "the largest density of the profile", 0, "a number above 0");
}

void check(const Solid& solid, const std::string& what) {
  check(solid.body, what);
  check_size(what + " density", solid.density);
  check_size(what + " edge", solid.edge);
  const Box box = bounds(solid.body);
  if (!box.empty() && !(is_finite(box.lo) && is_finite(box.hi))) {
    throw Error("recipe: " + what + " extends to infinity; intersect it with ellipsoids");
  }
}

template <class T>
void check_each(const std::vector<T>& list, const std::string& what) {
  for (std::size_t i = 0; i < list.size(); ++i) check(list[i], numbered(what, i));
}

/// Whether the lattice of samples and those of noises resolve every point of the box.
void check_lattices(const Recipe& recipe, const Box& box) {
  const double farthest = max_component(max(box.hi, -box.lo));
  const double side = max_component(box.extent()) / recipe.voxel;
  check(side <= kLargestResolution, "the longest side in samples", side,
        "at most " + std::to_string(kLargestResolution) + ": enlarge the voxel");
  check(farthest / recipe.voxel < 0x1p30, "the distance from the origin in samples",
        farthest / recipe.voxel, "less than 2^30: move the forms, or enlarge the voxel");
  for (const auto* noises : {&recipe.displacements, &recipe.modulations}) {
    for (const MaskedNoise& n : *noises) {
      const double cells = farthest / std::ldexp(n.noise.cell, -n.noise.octaves);
      check(cells < kMostCells, "the distance from the origin in cells of the last octave", cells,
            "less than 2^48: move the forms, enlarge the cell, or take fewer octaves");
    }
  }
}

}  // namespace

void validate(const Recipe& recipe) {
  check_size("density", recipe.density);
  check_size("edge", recipe.edge);
  check(recipe.profile);
  if (recipe.forms.empty() && recipe.solids.empty()) {
    throw Error("recipe: there is no form; expected at least one");
  }
  check_each(recipe.forms, "form");
  check_each(recipe.cuts, "cut");
  check_each(recipe.displacements, "displacement");
  check_each(recipe.modulations, "modulation");
  check_each(recipe.solids, "solid");
  const double factor = std::max(1.0, 1 + detail::total(recipe.modulations).hi);
  const double most = recipe.density * largest(recipe.profile) * factor;
  check(most <= kMostSize, "the largest density", most, "at most 1e30");
  const Box box = support(recipe);
  if (!box.empty() && !(is_finite(box.lo) && is_finite(box.hi))) {
    throw Error("recipe: the forms extend to infinity; use ellipsoids, or add cuts around them");
  }
  check_size("voxel", recipe.voxel);  // readers derive it from the support
  if (!box.empty()) check_lattices(recipe, box);
}

}  // namespace pvol
