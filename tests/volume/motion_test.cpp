// Densities in motion: displacements, their bounds, and what look-ups find at a time.
#include "pvol/volume/motion.h"

#include <gtest/gtest.h>

#include <cmath>

#include "pvol/embed.h"
#include "pvol/trackers.h"
#include "pvol/volume/make_volume.h"
#include "support/error_of.h"
#include "support/fields.h"
#include "support/messages.h"
#include "support/velocities.h"
#include "volume/any_source.h"
#include "volume/flights.h"

namespace pvol::test {
namespace motion_test {

constexpr double kExtinction = 3;

/// Random numbers that belong to lattice points.
double noise(Vec3i p, std::uint64_t seed) {
  const auto u = [](int v) { return std::uint64_t(std::uint32_t(v)); };
  return 2 * to_uniform_double(mix64(mix64(seed ^ u(p.x) << 32 ^ u(p.y)) ^ u(p.z))) - 1;
}
/// A random direction for each point, of a speed that differs much between places.
Vec3d random_velocity(Vec3i p) {
  const double speed = p.x < 12 ? 0.3 : p.y < 10 ? 14 : 3;
  return Vec3d(noise(p, 1), noise(p, 2), noise(p, 3)) * speed;
}

struct Case {
  std::string name;
  const Field* field;
  VelocityGrid velocity;
  std::function<Vec3d(Vec3i)> at;  ///< of its lattice
  Shutter shutter;
  LookUp look_up = LookUp::trilinear;
};

const Field& blob() {
  static const Field f = make_field("blob", {-5, 3, 2}, {30, 21, 26}, [](Vec3i p) {
    const Vec3d d = Vec3d(p) - Vec3d(9, 13, 14);
    return std::max(0.0, 1 - dot(d, d) / 120) * (0.6 + 0.4 * noise(p, 7));
  });
  return f;
}

/// Rises along x, so that a place a hundredth of the way wrong is another value.
const Field& ramp() {
  static const Field f =
      make_field("ramp", {0, 0, 0}, {240, 16, 16}, [](Vec3i p) { return (p.x + 241) / 480.0; });
  return f;
}

std::vector<Case> cases() {
  const Vec3i lo(-8, 0, 0), hi(32, 32, 32);
  const auto inside = [=](const std::function<Vec3d(Vec3i)>& f) {
    return [=](Vec3i p) {
      const bool in = p.x >= -8 && p.y >= 0 && p.z >= 0 && p.x < 32 && p.y < 32 && p.z < 32;
      return in ? f(p) : Vec3d(0);
    };
  };
  const auto swirl = [](Vec3i p) { return Vec3d(p.y - 13, 9 - p.x, 0.1 * p.z) * 0.7; };
  const auto constant = [](Vec3i) { return Vec3d(3.25, -7.5, 11); };
  std::vector<Case> all;
  const auto add = [&](const char* name, const std::function<Vec3d(Vec3i)>& f, Shutter shutter,
                       const Affine& map, LookUp look_up = LookUp::trilinear) {
    all.push_back({name, &blob(), make_velocity(lo, hi, f, map), inside(f), shutter, look_up});
  };
  add("random", random_velocity, {-0.5, 0.5}, {});
  add("random, later", random_velocity, {0.25, 1}, {});
  add("random, nearest", random_velocity, {0, 0.5}, {}, LookUp::nearest);
  add("random, tricubic", random_velocity, {-0.5, 0}, {}, LookUp::tricubic);
  add("swirl on a lattice of its own", swirl, {-1, 0.5},
      translation({0.3, 0.4, -2.1}) * scaling({1.3, 0.8, 1.1}));
  add("constant", constant, {0, 1}, {});
  // Not a whole number of cells, so that bounds by samples are half a cell from what they bound.
  const auto far = [](Vec3i) { return Vec3d(100.5, 0, 0); };
  all.push_back({"ramp", &ramp(), make_velocity({-160, -8, -8}, {400, 24, 24}, far), far, {-1, 1}});
  return all;
}

struct Moved {
  Pyramid pyramid;
  Volume volume;
};
Moved move(const Case& c) {
  Moved m{build_pyramid(c.field->grid, c.look_up), {}};
  VolumeOptions o;
  o.look_up = c.look_up;
  const Medium medium{.extinction = kExtinction};
  m.volume = make_moving(make_volume(c.field->grid, m.pyramid, medium, o), m.pyramid,
                         c.field->grid.index_to_world, {c.velocity, 1, c.shutter}, o);
  return m;
}

/// What there is at a place and a time, without any of the library's structures. For look-ups but
/// trilinear ones those of the still volume serve.
double expected(const Case& c, const Volume& still, Vec3d x, double t) {
  const Vec3d at = inverse(c.velocity.index_to_world()).point(x);
  Vec3d v;
  for (int axis = 0; axis < 3; ++axis) {
    v[axis] = trilinear([&](Vec3i p) { return c.at(p)[axis]; }, at);
  }
  const Vec3d from = x - v * t;
  if (c.look_up != LookUp::trilinear) return extinction_at(still, from);
  return kExtinction * trilinear([&](Vec3i p) { return double(c.field->at(p)); }, from);
}

/// A random place in and around what the volume reaches.
Vec3d random_place(const Volume& v, Rng& rng) {
  const Box box = v.density.world_box;
  return box.lo - Vec3d(2) +
         (box.extent() + Vec3d(4)) * Vec3d{rng.uniform(), rng.uniform(), rng.uniform()};
}

void check_look_ups(const Case& c, const Moved& m, int least_inside) {
  const Volume still = make_volume(c.field->grid, m.pyramid, Medium{.extinction = kExtinction},
                                   {.look_up = c.look_up});
  Rng rng(3, 1, 4);
  int inside = 0, differ = 0;
  for (int i = 0; i < 20'000; ++i) {
    const Vec3d x = random_place(m.volume, rng);
    const auto t = float(c.shutter.at(double(rng.uniform())));
    const double right = expected(c, still, x, double(t));
    const Vec3d cells = m.volume.density.world_to_cells.point(x);
    if (!m.volume.density.octree.support().contains(cells)) {
      EXPECT_EQ(right, 0) << c.name;
      continue;
    }
    const Segment s{0, 1, 0, 1e9f, Octree::kNodeBit};
    const detail::AnyExtinction extinction{m.volume.density, t};
    const float found = extinction(s, make_cursor(m.volume.density.octree, cells).at);
    inside += right > 0;
    // Nearest look-ups jump: places that differ by rounding may lie on either side.
    if (c.look_up == LookUp::nearest) {
      differ += std::abs(double(found) - right) > 1e-3;
    } else {
      EXPECT_NEAR(double(found), right, 2e-5 * kExtinction) << c.name << " at " << x.x;
    }
  }
  EXPECT_GT(inside, least_inside) << c.name;
  EXPECT_LE(differ, 5) << c.name;
}

TEST(Motion, LookUpsFindWhatTheVelocitiesBring) {
  for (const Case& c : cases()) check_look_ups(c, move(c), 400);
}

/// Of a still volume of which walks meet parts of leaves, most of them empty.
TEST(Motion, LookUpsFindSparksThatMove) {
  const Field sparks = make_field("sparks", {0, 0, 0}, {32, 32, 32}, [](Vec3i p) {
    return (p.x & 7) == 5 && (p.y & 7) == 4 && (p.z & 7) == 6 ? 1.0 : 0.0;
  });
  const auto constant = [](Vec3i) { return Vec3d(1.25, -2.5, 3); };
  const auto at = [&](Vec3i p) {
    const bool in = p.x >= -8 && p.y >= -8 && p.z >= -8 && p.x < 40 && p.y < 40 && p.z < 40;
    return in ? constant(p) : Vec3d(0);
  };
  const Case c{
      "sparks", &sparks, make_velocity({-8, -8, -8}, {40, 40, 40}, constant, {}), at, {0, 0.5}};
  check_look_ups(c, move(c), 200);
}

/// Every point of every segment, at all times, and bounds that are met: those of a hundredth less
/// are not bounds.
TEST(Motion, BoundsHoldAtAllTimesAndNotByFar) {
  for (const Case& c : cases()) {
    const Moved m = move(c);
    const Octree& tree = m.volume.density.octree;
    Rng rng(2, 7, 1);
    double slack = 0, extinctions = 0, tightest = 0, lowest = 1e9;
    for (int ray = 0; ray < 6000; ++ray) {
      const Vec3d from = random_place(m.volume, rng), to = random_place(m.volume, rng);
      auto walk = enter(m.volume, {from, normalize(to - from)});
      if (!walk) continue;
      while (const auto s = walk->next()) {
        for (int i = 0; i < 6; ++i) {
          // The ends of the shutter and of segments count most.
          const float u = rng.uniform(), along = i < 4 ? float(i / 2) : rng.uniform();
          const auto t = float(c.shutter.at(i < 4 ? i % 2 : double(u)));
          const LatticePoint p = walk->point(s->t0 + (s->t1 - s->t0) * double(along));
          const float mu = detail::AnyExtinction{m.volume.density, t}(*s, p);
          ASSERT_LE(mu, s->hi * (1 + 1e-6f)) << c.name << ", t " << t;
          ASSERT_GE(mu, s->lo * (1 - 1e-6f)) << c.name << ", t " << t;
          slack += double(s->hi);
          extinctions += double(mu);
          tightest = std::max(tightest, double(mu / s->hi));
          if (s->lo > 0) lowest = std::min(lowest, double(mu / s->lo));
        }
      }
    }
    EXPECT_GT(tightest, c.field == &ramp() ? 0.999 : 0.7) << c.name;
    EXPECT_LT(slack, 40 * extinctions) << c.name;
    EXPECT_LE(lowest, c.field == &ramp() ? 1.005 : 1e9) << c.name;
    EXPECT_LE(validate(m.pyramid).value_or("").size(), 0u);
    EXPECT_GT(tree.terminals, 20u) << c.name;
  }
}

TEST(Motion, BoundsOfWhatHardlyMovesAreHardlyLooser) {
  const auto creep = [](Vec3i) { return Vec3d(0.01, 0, 0); };
  const Pyramid p = build_pyramid(blob().grid);
  const Volume still = make_volume(blob().grid, p, {.extinction = 1}, {});
  const VelocityGrid v = make_velocity({-64, -64, -64}, {64, 64, 64}, creep);
  const Displacements d = make_displacements(v, {}, 1);
  const Pyramid swept = sweep_bounds(p, still.density, d, {-0.25, 0.25});
  double sum = 0, swept_sum = 0;
  for (const PyramidNode& n : p.levels[0]) sum += double(n.hi);
  for (const PyramidNode& n : swept.levels[0]) swept_sum += double(n.hi);
  EXPECT_GE(swept_sum, sum * 0.999);
  EXPECT_LT(swept_sum, sum * 1.25);
}

TEST(Motion, WhereNothingMovesBoundsAreThoseOfTheStillCloud) {
  const auto none = [](Vec3i p) { return p.x > 60 ? Vec3d(1, 0, 0) : Vec3d(0); };
  for (const LookUp look_up : {LookUp::trilinear, LookUp::tricubic}) {
    const Pyramid p = build_pyramid(blob().grid, look_up);
    const Volume still = make_volume(blob().grid, p, {.extinction = 1}, {.look_up = look_up});
    const Displacements d =
        make_displacements(make_velocity({-8, 0, 0}, {72, 32, 32}, none), {}, 1);
    const Pyramid swept = sweep_bounds(p, still.density, d, {-0.25, 0.25});
    ASSERT_EQ(swept.levels[0].size(), p.levels[0].size());
    for (const PyramidNode& n : swept.levels[0]) {
      const Vec3l at = swept.origin + Vec3l(morton_decode(n.code)) * std::int64_t(kLeafEdge);
      const Vec3l of_still = (at - p.origin) / kLeafEdge;
      const auto i = find(p.levels[0], morton_encode(Vec3<std::uint32_t>(of_still)));
      ASSERT_TRUE(i);
      EXPECT_EQ(n.lo, p.levels[0][*i].lo);
      EXPECT_EQ(n.hi, p.levels[0][*i].hi);
    }
  }
}

TEST(Motion, RangesOfDisplacementsHoldInBoxesOfEverySize) {
  const VelocityGrid v = make_velocity({-8, 0, 0}, {80, 72, 64}, random_velocity,
                                       translation({0.5, 2, 1}) * scaling({0.7, 1.2, 1}));
  const Affine index_to_world = scaling({2, 2, 2});
  const Displacements d = make_displacements(v, index_to_world, 0.5);
  Rng rng(5, 5, 5);
  for (int i = 0; i < 3000; ++i) {
    const Vec3d lo = Vec3d(-10, -6, -6) + Vec3d{rng.uniform(), rng.uniform(), rng.uniform()} * 50.0;
    const double edge = std::exp2(1 + 5 * double(rng.uniform()));
    const Displacements::Range r = range_over(d, {lo, lo + Vec3d(edge)});
    for (int k = 0; k < 30; ++k) {
      const Vec3d x = lo + Vec3d{rng.uniform(), rng.uniform(), rng.uniform()} * edge;
      const Float4 at = d.bricks.at(d.index_to_cells.point(x));
      for (int axis = 0; axis < 3; ++axis) {
        ASSERT_GE(at[axis], r.lo[axis] - 1e-5f);
        ASSERT_LE(at[axis], r.hi[axis] + 1e-5f);
      }
    }
  }
  // Half a second at a velocity in world units, in voxels of two.
  const Vec3i p(20, 5, 9);
  const Vec3d world = v.index_to_world().point(Vec3d(p));
  const Float4 there = d.bricks.at(d.index_to_cells.point(inverse(index_to_world).point(world)));
  for (int axis = 0; axis < 3; ++axis) {
    EXPECT_NEAR(double(there[axis]), random_velocity(p)[axis] / 4, 1e-5);
  }
}

TEST(Motion, TilesMoveAsSamplesDo) {
  VelocityGrid tiles;
  for (int c = 0; c < 3; ++c) {
    tiles.along[std::size_t(c)].tiles = {{{0, 0, 0}, 128, float(c - 1)}, {{128, 0, 0}, 8, 2.5f}};
  }
  const Displacements d = make_displacements(tiles, {}, 2);
  EXPECT_EQ(d.largest, 5);
  EXPECT_LT(d.bricks.samples.size(), 1700u * VectorBricks::kSamples)
      << "leaves of one value share it";
  for (int c = 0; c < 3; ++c) {
    EXPECT_EQ(d.bricks.at(d.index_to_cells.point({64, 60, 3}))[c], float(2 * c - 2));
    EXPECT_EQ(d.bricks.at(d.index_to_cells.point({131, 4, 3}))[c], 5);
    EXPECT_EQ(d.bricks.at(d.index_to_cells.point({-0.5, 60, 3}))[c], float(c - 1));
    EXPECT_EQ(d.bricks.at(d.index_to_cells.point({-1, 60, 3}))[c], 0);
    EXPECT_EQ(d.bricks.at(d.index_to_cells.point({1e9, 60, 3}))[c], 0);
  }
}

TEST(Motion, WhatCannotBeIsRefused) {
  const Pyramid p = build_pyramid(blob().grid);
  const VelocityGrid v =
      make_velocity({0, 0, 0}, {8, 8, 8}, [](Vec3i) { return Vec3d(1e5, 0, 0); });
  const auto moving = [&](VolumeOptions o, double seconds = 1e-5) {
    return error_of([&] {
      (void)make_moving(make_volume(blob().grid, p, {.extinction = 1}, o), p, {},
                        {v, seconds, {0, 1}}, o);
    });
  };
  EXPECT_EQ(moving({}), "");
  EXPECT_TRUE(says(moving({.tracker = Tracker::regular}), "motion.volume_motion_no_closed"));
  EXPECT_NE(moving({.majorant_scale = 2}).find("majorant_scale"), std::string::npos);
  EXPECT_NE(moving({.homogenise = 0.1}).find("homogenise"), std::string::npos);
  EXPECT_TRUE(says(moving({}, 1e9), "motion.medium_moves_up_voxels"));
  EXPECT_TRUE(says(moving({}, 1e38), "motion.medium_moves_up_voxels"));
  VelocityGrid huge = v;
  huge.along[0].tiles = {{{4096, 0, 0}, 4096, 1}};
  EXPECT_NE(error_of([&] { (void)make_displacements(huge, {}, 1); }).find("2^24 leaves"),
            std::string::npos);
}

TEST(Motion, AVolumeThatNothingMovesStaysAsItIs) {
  const Pyramid p = build_pyramid(blob().grid);
  const VelocityGrid v = make_velocity({0, 0, 0}, {8, 8, 8}, [](Vec3i) { return Vec3d(0); });
  const Volume still = make_volume(blob().grid, p, {.extinction = 1}, {});
  EXPECT_EQ(make_moving(still, p, {}, {v, 1, {0, 1}}, {}).density.motion, nullptr);
  EXPECT_EQ(make_moving(still, p, {}, {cases().front().velocity, 1, {}}, {}).density.motion,
            nullptr);
  EXPECT_EQ(make_moving(still, p, {}, {cases().front().velocity, 0, {0, 1}}, {}).density.motion,
            nullptr);
}

}  // namespace motion_test
}  // namespace pvol::test
