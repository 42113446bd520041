// Recipes of every kind, for tests of their density and of the grids made of it.
#pragma once

#include <random>
#include <vector>

#include "pvol/density/cumulus.h"
#include "pvol/density/recipe.h"

namespace pvol::test {

using Random = std::mt19937_64;

inline double uniform(Random& random, double lo, double hi) {
  return std::uniform_real_distribution<double>(lo, hi)(random);
}
inline Vec3d point_in(Random& random, const Box& b) {
  return {uniform(random, b.lo.x, b.hi.x), uniform(random, b.lo.y, b.hi.y),
          uniform(random, b.lo.z, b.hi.z)};
}

inline FreeForm ball(Vec3d centre, double radius) {
  return {0.5 * radius * ellipsoid(centre, Vec3d(radius)), {}};
}

/// Large smooth inside, bulge and dent, cut, noise of both kinds, one of them masked.
inline Recipe make_sample() {
  Recipe r;
  r.voxel = 0.05;
  r.density = 0.7;
  r.edge = 0.05;
  r.forms = {ball({0, 0, 0}, 1), ball({0.9, 0.2, 0.1}, 0.6), ball({-0.3, 1, -0.2}, 0.5)};
  r.forms[0].form.perturbations = {{{ellipsoid({0, 0, 1}, Vec3d(0.5)), {}}, 0.3},
                                   {{ellipsoid({0, 0, -1}, Vec3d(0.5)), {}}, -0.3}};
  r.cuts = {FreeForm{2.0 * half_space({0, -0.5, 0}, {0.1, 1, 0}), {}}};
  r.displacements = {{{1, 0.3, 4, 0.5, true}, 0.1},
                     {{2, 0.4, 3, 0.5, false}, 0.1, half_space({0, 0.5, 0}, {0, -1, 0})}};
  return r;
}

/// One form with a mixed term, no noise.
inline Recipe make_plain() {
  Recipe r;
  r.voxel = 0.04;
  Affine turn;
  turn.m = {Vec3d{0.6, -0.8, 0}, Vec3d{0.8, 0.6, 0}, Vec3d{0, 0, 1}};
  r.forms = {FreeForm{0.1 * ellipsoid({5, -3, 2}, {0.2, 0.9, 1.3}, turn), {}}};
  return r;
}

inline Recipe make_small_cumulus() {
  Cumulus c;
  c.towers = 3;
  c.generations = 2;
  Recipe r = make_recipe(c);
  r.voxel = voxel_for(r, 60);
  return r;
}

/// Trees of bodies with nested perturbations, a profile that rises and falls, noise on the density,
/// and a solid in the cloud.
inline Recipe make_modelled(ProfileKind kind) {
  Recipe r;
  r.voxel = 0.06;
  r.edge = 0.1;
  r.profile.kind = kind;
  if (kind == ProfileKind::table) r.profile.points = {{-0.5, 0}, {1, 1}, {1.5, 0.2}, {4, 0.6}};
  FreeForm dented = ball({0, 0, 0}, 1);
  FreeForm bump{ellipsoid({0, 0.8, 0}, Vec3d(0.7)), {}};
  bump.perturbations = {{{ellipsoid({0, 1.2, 0}, Vec3d(0.4)), {}}, -2}};
  dented.perturbations = {{bump, 0.4}};
  const pvol::Body pair{BodyOp::join, {dented, ball({1.2, 0, 0}, 0.7)}};
  const pvol::Body holes{BodyOp::join, {ball({0, 0, 0.9}, 0.4), ball({1.2, 0, 0.6}, 0.3)}};
  r.forms = {{BodyOp::difference, {pair, holes}},
             {BodyOp::intersection, {ball({-1, 0, 0}, 0.8), ball({-1, 0.5, 0}, 0.8)}}};
  r.displacements = {{{1, 0.4, 3, 0.5, true}, 0.1}};
  r.modulations = {{{2, 0.3, 3, 0.5, false}, 1.5}, {{3, 1, 1, 0.5, true}, -0.5}};
  r.solids = {
      {pvol::Body{BodyOp::difference, {ball({0.2, 0, 0}, 0.5), ball({0.2, 0.4, 0}, 0.4)}}, 5, 0.05},
      {ball({1.2, 0, 0}, 0.2), 0.1, 0.2}};
  return r;
}

inline const Recipe kRecipes[] = {make_sample(),
                                  make_plain(),
                                  make_small_cumulus(),
                                  make_modelled(ProfileKind::linear),
                                  make_modelled(ProfileKind::smooth),
                                  make_modelled(ProfileKind::table)};

}  // namespace pvol::test
