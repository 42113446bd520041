#include "pvol/density/cumulus.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "math/digits.h"
#include "math/philox.h"
#include "pvol/error.h"

namespace pvol {
namespace {

// The numbers in this file were chosen by eye, from pictures.

struct Puff {
  Vec3d centre;
  double radius;
};

double between(Rng& rng, double lo, double hi) { return lo + (hi - lo) * double(rng.uniform()); }

/// 1/2 (r - |p - c|^2 / r): about the distance from the surface of the ball, positive inside.
double depth(const Puff& puff, Vec3d p) {
  const Vec3d d = p - puff.centre;
  return 0.5 * (puff.radius - dot(d, d) / puff.radius);
}

/// Columns of balls that shrink upwards, lower and thinner away from the middle.
std::vector<Puff> make_towers(const Cumulus& c, Rng& rng) {
  const double golden_angle = std::numbers::pi * (3 - std::sqrt(5.0));  // fills a disc evenly
  const double turn = between(rng, 0, 2 * std::numbers::pi), lean = between(rng, -0.12, 0.12);
  std::vector<Puff> puffs;
  for (int i = 0; i < c.towers; ++i) {
    const double out = std::sqrt((i + between(rng, 0, 0.5)) / c.towers);
    const double angle = turn + golden_angle * i + between(rng, -0.4, 0.4);
    const double top = c.height * (1 - 0.72 * out * out) * between(rng, 0.8, 1);
    double radius = std::min(c.width * between(rng, 0.17, 0.21) * (1 - 0.35 * out), 0.5 * top);
    const double thinnest = 0.4 * radius;
    Vec3d at{(0.4 * out * std::cos(angle) + lean * (1 - out)) * c.width, 0.4 * radius,
             0.3 * out * std::sin(angle) * c.width};
    puffs.push_back({at, radius});
    while (at.y + radius < 0.999 * top) {
      radius = std::max(radius * between(rng, 0.78, 0.92), thinnest);
      const double x = between(rng, -0.3, 0.3), y = between(rng, 0.7, 0.95);
      at += Vec3d{x, y, between(rng, -0.3, 0.3)} * radius;
      at.y = std::min(at.y, top - radius);
      puffs.push_back({at, radius});
    }
  }
  return puffs;
}

/// A unit vector whose height is at least `least`.
Vec3d upward(Rng& rng, double least) {
  const double y = between(rng, least, 1), ring = std::sqrt(1 - y * y);
  const double angle = 2 * std::numbers::pi * double(rng.uniform());
  return {ring * std::cos(angle), y, ring * std::sin(angle)};
}

/// Whether a puff would not show, or stand in the way of one of its own age.
bool is_hidden(const Puff& puff, Vec3d tip, const std::vector<Puff>& old,
               const std::vector<Puff>& young) {
  const auto buries = [&](const Puff& other) { return depth(other, tip) > -0.5 * puff.radius; };
  const auto crowds = [&](const Puff& other) {
    return length(other.centre - puff.centre) < 0.75 * std::max(other.radius, puff.radius);
  };
  return puff.centre.y < -0.2 * puff.radius || std::any_of(old.begin(), old.end(), buries) ||
         std::any_of(young.begin(), young.end(), crowds);
}

/// A generation of smaller balls, on the free surface of those from `first` on.
std::vector<Puff> grow(const std::vector<Puff>& old, std::size_t first, Rng& rng) {
  constexpr int kTries = 14;
  std::vector<Puff> young;
  for (std::size_t i = first; i < old.size(); ++i) {
    for (int t = 0; t < kTries; ++t) {
      const Puff& parent = old[i];
      const Vec3d out = upward(rng, -0.35);
      const double reach = between(rng, 0.8, 0.95), size = between(rng, 0.32, 0.56);
      const Puff puff{parent.centre + out * (parent.radius * reach), parent.radius * size};
      if (!is_hidden(puff, puff.centre + out * puff.radius, old, young)) young.push_back(puff);
    }
  }
  return young;
}

void check(bool holds, const std::string& what, double found, const std::string& expected) {
  if (holds) return;
  throw Error("cumulus: " + what + " is " + detail::digits(found, 6) + "; expected " + expected);
}

void check(const Cumulus& c) {
  check(c.width >= 1e-20 && c.width <= 1e20, "width", c.width, "a number in [1e-20, 1e20]");
  check(c.height >= 0.2 * c.width && c.height <= 2 * c.width, "height", c.height,
        "0.2 to 2 times the width");
  check(c.towers >= 1 && c.towers <= kMostTowers, "towers", c.towers,
        "a whole number in 1.." + std::to_string(kMostTowers));
  check(c.generations >= 0 && c.generations <= 3, "generations", c.generations,
        "a whole number in 0..3");
  check(c.detail >= 0 && c.detail <= 2, "detail", c.detail, "a number in [0, 2]");
  check(c.wisps >= 0 && c.wisps <= 2, "wisps", c.wisps, "a number in [0, 2]");
}

std::vector<MaskedNoise> make_displacements(const Cumulus& c) {
  const double w = c.width;
  const Quadric low = (1 / (0.6 * c.height)) * half_space({0, 0.6 * c.height, 0}, {0, -1, 0});
  const Fbm billows{c.seed, 0.11 * w, 5, 0.55, true};
  const Fbm tatters{c.seed + 1, 0.2 * w, 6, 0.6, false};
  const Fbm fuzz{c.seed + 2, 0.1 * w, 5, 0.6, false};
  return {{billows, 0.09 * w * c.detail},
          {tatters, 0.13 * w * c.wisps, low},
          {fuzz, 0.04 * w * c.wisps}};
}

}  // namespace

Recipe make_recipe(const Cumulus& c) {
  check(c);
  Rng rng(c.seed, 0, 0);
  std::vector<Puff> puffs = make_towers(c, rng);
  std::size_t first = 0;
  for (int g = 0; g < c.generations; ++g) {
    const std::vector<Puff> young = grow(puffs, first, rng);
    first = puffs.size();
    puffs.insert(puffs.end(), young.begin(), young.end());
  }
  Recipe recipe;
  for (const Puff& p : puffs) {
    recipe.forms.push_back(FreeForm{0.5 * p.radius * ellipsoid(p.centre, Vec3d(p.radius)), {}});
  }
  recipe.cuts.push_back(FreeForm{1.3 * half_space({0, 0, 0}, {0, 1, 0}), {}});
  recipe.displacements = make_displacements(c);
  recipe.edge = 0.012 * c.width;
  recipe.voxel = voxel_for(recipe, 256);
  return recipe;
}

}  // namespace pvol
