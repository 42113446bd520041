// Segments of a walk against the exact density.
#include "pvol/bounds/walk.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "pvol/bounds/integrals.h"
#include "pvol/bounds/pyramid.h"
#include "pvol/embed.h"
#include "pvol/math/rng.h"
#include "pvol/trackers.h"
#include "pvol/volume/make_volume.h"
#include "support/fields.h"
#include "support/oracle.h"

namespace pvol::test {
namespace walk_test {

/// Rounding of a walk in cells: 2^-24 for each of some 60 steps (THEORY.md, T1.3), and of the cells
/// walked.
constexpr double kPlace = 4e-6;
/// Rounding of bounds and densities, relative.
constexpr double kValue = 1e-6;

const std::vector<std::optional<int>> kDepths = [] {
  std::vector<std::optional<int>> d{std::nullopt};
  for (int depth = 0; depth <= 16; ++depth) d.push_back(depth);
  return d;
}();

/// The level of the octree at which its leaves are.
int leaf_depth(const Field& f) { return int(build_pyramid(f.grid).levels.size()) - 1; }

double uniform(Rng& rng, double lo, double hi) { return lo + (hi - lo) * double(rng.uniform()); }

Vec3d uniform_in(Rng& rng, const Box& b) {
  return {uniform(rng, b.lo.x, b.hi.x), uniform(rng, b.lo.y, b.hi.y), uniform(rng, b.lo.z, b.hi.z)};
}

Box support_of(const Volume& v) {
  const Box b = v.density.octree.support();
  return {b.lo + Vec3d(v.density.octree.origin), b.hi + Vec3d(v.density.octree.origin)};
}

/// A direction of components -1, 0, -0 and 1 in turn, never zero.
Vec3d lattice_direction(std::uint64_t i) {
  const double component[4] = {-1, 0.0, -0.0, 1};
  const Vec3d d(component[i & 3], component[i >> 2 & 3], component[i >> 4 & 3]);
  return d == Vec3d(0.0) ? Vec3d(1, 0.0, -0.0) : d;
}

/// Rays in index space: random ones from outside and inside, and those that touch the lattice.
std::vector<Ray> rays_through(const Volume& v) {
  const Box support = support_of(v);
  Rng rng(1, 2, 3);
  std::vector<Ray> rays;
  for (std::uint64_t i = 0; i < 12; ++i) {
    const Vec3d p = uniform_in(rng, support), q = uniform_in(rng, support);
    rays.push_back({p, normalize(q - p)});
    rays.push_back({p + (p - q) * 3.0, normalize(q - p)});
    rays.push_back({p, lattice_direction(7 * i + 1)});
  }
  for (std::uint64_t i = 0; i < 64; i += 3) {
    const Vec3d p = uniform_in(rng, support);
    const Vec3d corner(std::floor(p.x), std::floor(p.y), std::floor(p.z));
    const Vec3d leaf(8 * std::round(p.x / 8), 8 * std::round(p.y / 8), 8 * std::round(p.z / 8));
    const Vec3d face(i & 1 ? support.lo.x : support.hi.x, p.y, i & 2 ? support.lo.z : p.z);
    const Vec3d d = lattice_direction(i), skew = normalize(uniform_in(rng, support) - p);
    rays.push_back({corner, d});              // edges, corners and diagonals of cells
    rays.push_back({corner - d * 100.0, d});  // the same from outside
    rays.push_back({leaf, d});                // borders of leaves
    rays.push_back({leaf, skew});
    rays.push_back({leaf, -skew});
    rays.push_back({Vec3d(leaf.x, p.y, p.z), {0.0, d.y, d.z == 0 ? 0.7 : d.z}});  // in a face
    rays.push_back({face, skew});  // from the support's faces
    rays.push_back({face, d});
    rays.push_back({corner + Vec3d(0.5), d});
  }
  return rays;
}

/// The terminal whose cube holds a cell, by descent from the root.
struct Terminal {
  const Octree::Entry* entry = nullptr;
  Vec3i low;
};
Terminal terminal_at(const Octree& tree, Vec3i cell) {
  const Octree::Node* node = &tree.nodes[0];
  for (;;) {
    const Octree::Entry* e =
        tree.child(*node, Octree::child_bit(widen(cell), Octree::child_log2(int(node->height))));
    if (e == nullptr) return {};
    if (e->log2 != 0) {
      const int mask = ~((1 << e->log2) - 1);
      return {e, {cell.x & mask, cell.y & mask, cell.z & mask}};
    }
    node = &tree.nodes[e->link & ~Octree::kNodeBit];
  }
}

/// A ray of a volume from where it enters the support, as the walk sees it, with an exact twin.
struct Start {
  Cursor cursor;
  Float4 direction;  // cells per world length
  Ray exact;         // in cells; t is world length
};
std::optional<Start> start(const Volume& v, const Ray& in_index, double cells_per_length = 1) {
  const Vec3f direction(in_index.d * cells_per_length);
  const Ray ray{in_index.o - Vec3d(v.density.octree.origin), Vec3d(direction)};
  const auto span =
      intersect(v.density.octree.support(), ray, 0, std::numeric_limits<double>::infinity());
  if (!span) return std::nullopt;
  const Vec3d o = ray.at(span->t0);
  return Start{make_cursor(v.density.octree, o), widen(direction), {o, ray.d}};
}

/// Largest distance from a walk's point to the exact one: rounding of steps and of t.
double tolerance(const Ray& exact, double t) { return kPlace * (1 + t * length(exact.d)); }

/// Every claim of walk.h about one segment.
void check_segment(const Field& f, const Volume& v, const Start& from, const Walk& walk,
                   const Segment& s) {
  ASSERT_LT(0, s.hi);
  ASSERT_LE(0, s.lo);
  ASSERT_LE(s.lo, s.hi);
  constexpr int kSteps = 12;
  const Terminal home = terminal_at(v.density.octree, vec3(walk.point(0.5 * (s.t0 + s.t1)).cell));
  ASSERT_NE(home.entry, nullptr);
  for (int i = 0; i <= kSteps; ++i) {
    const double t = std::min(s.t1, s.t0 + (s.t1 - s.t0) * i / kSteps);
    const LatticePoint p = walk.point(t);
    ASSERT_GE(min_component(vec3(p.frac)), 0);
    ASSERT_LE(max_component(vec3(p.frac)), 1);
    const Terminal terminal = terminal_at(v.density.octree, vec3(p.cell));
    ASSERT_EQ(terminal.entry ? terminal.low : Vec3i(-1), home.low);
    ASSERT_EQ(terminal.entry->lo, s.lo);
    ASSERT_EQ(terminal.entry->hi, s.hi);
    const Vec3d exact = from.exact.at(t);
    ASSERT_LE(length(position(p) - exact), tolerance(from.exact, t));
    for (const auto look_up : {LookUp::trilinear, LookUp::nearest}) {
      const double mu = double(v.density.scale) *
                        density_at(f, look_up, position(p) + Vec3d(v.density.octree.origin));
      ASSERT_GE(mu, double(s.lo) * (1 - kValue));
      ASSERT_LE(mu, double(s.hi) * (1 + kValue));
    }
  }
}

/// Between t0 and t1, the density must be 0 but for rounding of places.
void check_gap(const Field& f, const Volume& v, const Start& from, double t0, double t1) {
  if (!(t0 < t1)) return;
  constexpr int kSteps = 16;
  for (int i = 0; i <= kSteps; ++i) {
    const double t = t0 + (t1 - t0) * i / kSteps;
    const double steepest = 4 * double(f.largest);  // per cell, generously
    ASSERT_LE(density_at(f, LookUp::trilinear, from.exact.at(t) + Vec3d(v.density.octree.origin)),
              steepest * tolerance(from.exact, t))
        << "at t = " << t << " of a gap from " << t0 << " to " << t1;
  }
}

/// Terminals that a line in the support can cross: each step passes a face of one axis.
int most_segments(const Volume& v) {
  int smallest = kLeafEdge;
  for (const Octree::Entry& e : v.density.octree.entries) {
    if (e.log2 != 0) smallest = std::min(smallest, 1 << e.log2);
  }
  const Vec3d extent = v.density.octree.support().extent() * (1.0 / smallest);
  return int(extent.x + extent.y + extent.z) + 6;
}

void check_walk(const Field& f, const Volume& v, const Start& from) {
  const auto end = intersect(v.density.octree.support(), from.exact, 0, 1e38);
  Cursor cursor = from.cursor;
  Walk walk(v.density.octree, cursor, from.direction);
  double last = 0;
  int count = 0;
  const int most = most_segments(v);
  while (const auto s = walk.next()) {
    ASSERT_LE(++count, most);
    ASSERT_GE(s->t0, last);  // ascending, without overlap
    ASSERT_GE(s->t1, s->t0);
    ASSERT_NO_FATAL_FAILURE(check_gap(f, v, from, last, s->t0));
    ASSERT_NO_FATAL_FAILURE(check_segment(f, v, from, walk, *s));
    last = s->t1;
  }
  if (!end) return;
  ASSERT_NO_FATAL_FAILURE(check_gap(f, v, from, last, end->t1));
}

class WalkOver : public testing::TestWithParam<std::string> {};

std::vector<std::string> field_names() {
  std::vector<std::string> names;
  for (const Field& f : fields()) names.push_back(f.name);
  return names;
}
INSTANTIATE_TEST_SUITE_P(Fields, WalkOver, testing::ValuesIn(field_names()),
                         [](const auto& test) { return test.param; });

TEST_P(WalkOver, SegmentsCoverTheDensityAndTheirBoundsHold) {
  const Field& f = field(GetParam());
  for (const auto depth : kDepths) {
    const Volume v = make_test_volume(f, 0.37, depth);
    int hit = 0;
    for (const Ray& ray : rays_through(v)) {
      const auto from = start(v, ray);
      if (!from) continue;
      ++hit;
      ASSERT_NO_FATAL_FAILURE(check_walk(f, v, *from))
          << "depth " << depth.value_or(-1) << ", from " << ray.o.x << ' ' << ray.o.y << ' '
          << ray.o.z << " along " << ray.d.x << ' ' << ray.d.y << ' ' << ray.d.z;
    }
    EXPECT_GT(hit, 100);
  }
}

/// Among leaves: in a face between parts of one, either side may be the ray's.
TEST_P(WalkOver, NeighboursInNonEmptySpaceAbut) {
  const Field& f = field(GetParam());
  const Volume v = make_test_volume(f, 1, leaf_depth(f));
  for (const Ray& ray : rays_through(v)) {
    const auto from = start(v, ray);
    if (!from) continue;
    Cursor cursor = from->cursor;
    Walk walk(v.density.octree, cursor, from->direction);
    std::optional<Segment> last;
    while (const auto s = walk.next()) {
      if (last && last->t1 < s->t0) {
        const Vec3d middle = from->exact.at(0.5 * (last->t1 + s->t0));
        const Vec3i cell(int(std::floor(middle.x)), int(std::floor(middle.y)),
                         int(std::floor(middle.z)));
        const double gap = (s->t0 - last->t1) * length(from->exact.d);
        // In a gap that is more than rounding lies an empty cube.
        if (gap > 10 * tolerance(from->exact, s->t0)) {
          ASSERT_EQ(terminal_at(v.density.octree, cell).entry, nullptr);
        }
      }
      last = s;
    }
  }
}

TEST_P(WalkOver, PersistentCursorWalksLikeAFreshOne) {
  const Field& f = field(GetParam());
  for (const std::optional<int> depth : {std::optional<int>{}, std::optional<int>{16}}) {
    const Volume v = make_test_volume(f, 1, depth);
    const Box support = v.density.octree.support();
    Rng rng(4, 5, 6);
    int turns = 0;
    for (int path = 0; path < 100; ++path) {
      Cursor cursor = make_cursor(
          v.density.octree, random_point_near_density(f, rng) - Vec3d(v.density.octree.origin));
      for (int turn = 0; turn < 60; ++turn) {
        Cursor fresh;
        fresh.at = cursor.at;
        fresh.height = v.density.octree.height;
        const Vec3d aim = uniform_in(rng, support) - position(cursor.at);
        const Float4 d =
            widen(Vec3f(turn % 4 == 0 ? lattice_direction(rng.block().lo) : normalize(aim)));
        Walk walk(v.density.octree, cursor, d), plain(v.density.octree, fresh, d);
        const std::uint64_t stop = rng.block().lo % 5;
        bool turned = false;
        for (std::uint64_t i = 0; !turned; ++i) {
          const auto a = walk.next(), b = plain.next();
          ASSERT_EQ(a.has_value(), b.has_value());
          if (!a) break;
          ASSERT_EQ(a->t0, b->t0);
          ASSERT_EQ(a->t1, b->t1);
          ASSERT_EQ(a->lo, b->lo);
          ASSERT_EQ(a->hi, b->hi);
          ASSERT_EQ(a->leaf, b->leaf);
          if (i < stop) continue;
          cursor = walk.stop_at(walk.point(a->t0 + (a->t1 - a->t0) * double(rng.uniform())));
          turned = true;
        }
        if (!turned) break;
        ++turns;
      }
    }
    EXPECT_GT(turns, 10);
  }
}

TEST_P(WalkOver, LengthEndsTheWalk) {
  const Field& f = field(GetParam());
  const Volume v = make_test_volume(f, 1, std::nullopt);
  Rng rng(7, 8, 9);
  for (const Ray& ray : rays_through(v)) {
    const auto from = start(v, ray);
    if (!from) continue;
    const float end = float(uniform(rng, 0, 40));
    Cursor a = from->cursor, b = from->cursor;
    Walk whole(v.density.octree, a, from->direction),
        part(v.density.octree, b, from->direction, end);
    const double rounding = 1e-5 * (1 + double(end));
    while (const auto s = part.next()) {
      const auto t = whole.next();
      ASSERT_TRUE(t);
      ASSERT_EQ(s->t0, t->t0);
      ASSERT_EQ(s->hi, t->hi);
      ASSERT_LE(s->t1, double(end) + rounding);
      if (s->t1 != t->t1) {
        ASSERT_NEAR(s->t1, end, rounding);
      }
    }
    if (const auto rest = whole.next()) {
      EXPECT_GE(rest->t1, double(end) - rounding);
    }
  }
}

TEST(Walk, EndsForEveryDirection) {
  const float tiny = 1e-30f, denormal = std::numeric_limits<float>::denorm_min();
  const float largest_subnormal = 1e-38f;
  const std::vector<float> components{
      0.0f,  -0.0f, tiny, -tiny, denormal, -denormal,         1.0f,
      -1.0f, 1e-7f, 1e9f, -1e9f, 1e-9f,    largest_subnormal, -1e-20f};
  for (const Field& f : fields()) {
    const Volume v = make_test_volume(f, 1, 16);
    const int most = most_segments(v);
    Rng rng(10, 11, 12);
    for (const float x : components) {
      for (const float y : components) {
        for (const float z : components) {
          if (x == 0 && y == 0 && z == 0) continue;
          Cursor cursor =
              make_cursor(v.density.octree, uniform_in(rng, v.density.octree.support()));
          Walk walk(v.density.octree, cursor, widen(Vec3f(x, y, z)));
          int count = 0;
          while (const auto s = walk.next()) {
            ASSERT_LE(++count, most) << x << ' ' << y << ' ' << z;
            ASSERT_FALSE(std::isnan(s->t0) || std::isnan(s->t1));
            const LatticePoint p = walk.point(s->t0);
            ASSERT_TRUE(is_finite(vec3(p.frac)));
          }
        }
      }
    }
  }
}

TEST(Walk, ScalesWithTheVoxel) {
  for (const double voxel : {1e-9, 1e-3, 1e3, 1e9}) {
    const Field f = make_field(
        "scaled", {5, -7, 9}, {20, 20, 20},
        [](Vec3i p) { return (p.x * 7 + p.y * 3 + p.z) % 5 == 0 ? 1 : 0.25; }, Tiles::none, voxel);
    const Volume v = make_test_volume(f, 0.5 / voxel, 16);
    int hit = 0;
    for (const Ray& ray : rays_through(v)) {
      const auto from = start(v, ray, 1 / voxel);
      if (!from) continue;
      ++hit;
      ASSERT_NO_FATAL_FAILURE(check_walk(f, v, *from)) << "voxel " << voxel;
    }
    EXPECT_GT(hit, 100);
  }
}

/// Into parts of leaves where these are thick and loose, with what tighter bounds are for.
TEST(Walk, GoesIntoLeavesWhereThatPays) {
  const Field& f = field("gaussian");
  const auto smallest = [](const Volume& v) {
    int log2 = 16;
    for (const Octree::Entry& e : v.density.octree.entries) {
      if (e.log2 != 0) log2 = std::min(log2, int(e.log2));
    }
    return log2;
  };
  const Volume thin = make_test_volume(f, 0.01, std::nullopt);
  const Volume thick = make_test_volume(f, 5, std::nullopt);
  const Volume leaves = make_test_volume(f, 5, leaf_depth(f));
  EXPECT_GE(smallest(thin), 3);
  EXPECT_EQ(smallest(leaves), 3);
  EXPECT_EQ(smallest(thick), 1);
  const BoundIntegrals parts = integrate_bounds(thick.density.octree);
  const BoundIntegrals whole = integrate_bounds(leaves.density.octree);
  EXPECT_LT(parts.hi - parts.lo, 0.6 * (whole.hi - whole.lo));
  // The closed form of a ray sees the same field through both.
  Rng rng(4, 4, 4);
  for (int i = 0; i < 500; ++i) {
    const Box box = support_of(thick);
    const Vec3d to = uniform_in(rng, box), from = uniform_in(rng, box) * 3.0 - to * 2.0;
    const double exact = exact_transmittance(leaves, {from, to - from}, 1e9);
    EXPECT_NEAR(exact_transmittance(thick, {from, to - from}, 1e9), exact, 1e-5 * exact + 1e-12);
  }
}

/// The depth of a tree is the limit under which it is made again; greater ones change nothing.
TEST(Walk, StopsAtTheSamePlacesByTheDepthOfItsTree) {
  const auto same = [](const Octree::Entry& a, const Octree::Entry& b) {
    return a.lo == b.lo && a.hi == b.hi && a.link == b.link && a.log2 == b.log2 &&
           a.grouped == b.grouped;
  };
  int leaves = 0, parts = 0;
  for (const Field& f : fields()) {
    for (const double extinction : {0.001, 0.05, 0.3, 1.0, 5.0, 200.0}) {
      const Octree tree = make_test_volume(f, extinction, std::nullopt).density.octree;
      for (const int depth : {tree.depth, kDeepestOctree}) {
        const Octree again = make_test_volume(f, extinction, depth).density.octree;
        EXPECT_EQ(again.depth, tree.depth) << f.name << ' ' << extinction;
        EXPECT_EQ(again.terminals, tree.terminals) << f.name << ' ' << extinction;
        EXPECT_TRUE(std::ranges::equal(again.entries, tree.entries, same)) << f.name;
      }
      for (int depth = 0; depth < tree.depth; ++depth) {
        EXPECT_LE(make_test_volume(f, extinction, depth).density.octree.depth, depth);
      }
      ++(tree.depth <= leaf_depth(f) ? leaves : parts);
    }
  }
  EXPECT_GT(leaves, 3);
  EXPECT_GT(parts, 3);
}

/// Two voxels as far apart as a cloud may reach.
TEST(Walk, CrossesTheLargestCloud) {
  constexpr std::int32_t kFar = (1 << kMaxRootLog2) - 64;
  std::vector<float> one(kBrickSamples, 0.0f);
  one[0] = 1;
  VoxelGrid grid;
  grid.bricks = {{{8, 8, 8}, one.data()}, {{8 + kFar, 8 + kFar, 8 + kFar}, one.data()}};
  const Volume v = make_volume(grid, Medium{});
  // Along the diagonal all places are exact.
  Cursor cursor = make_cursor(v.density.octree, Vec3d(8.0) - Vec3d(v.density.octree.origin));
  Walk walk(v.density.octree, cursor, widen(Vec3f(1.0f)));
  auto s = walk.next();
  ASSERT_TRUE(s);
  EXPECT_EQ(s->t0, 0);
  while (s && s->t0 < 16) s = walk.next();  // parts of the first voxel's leaves
  ASSERT_TRUE(s);
  EXPECT_NEAR(s->t0, double(kFar) - 1, 8);
  // At least to the end of the support, and not beyond its leaf.
  Vec3d end;
  for (; s; s = walk.next()) end = position(walk.point(s->t1));
  const Vec3d support = v.density.octree.support().hi;
  EXPECT_GE(min_component(end - support), 0);
  EXPECT_LE(max_component(end - support), kLeafEdge);
}

/// Steps of equal length round alike: over a hundred thousand of them a float would drift by cells.
TEST(Walk, ReachesTheEndOfALongCloud) {
  const std::vector<float> ones(kBrickSamples, 1.0f);
  VoxelGrid grid;
  for (std::int32_t x = 0; x < 1 << 19; x += kBrickEdge)
    grid.bricks.push_back({{x, 0, 0}, ones.data()});
  const Pyramid p = build_pyramid(grid);
  std::vector<std::vector<std::uint32_t>> no_bricks;
  for (const auto& level : p.levels) no_bricks.emplace_back(level.size(), kZeroBrick);
  const Octree tree = build_octree(p, 1, 1, {.everywhere = true}, no_bricks, kZeroBrick);
  for (const float speed : {0.3f, 0.7f, 1.1f, 1.9f}) {
    const Cursor cursor = make_cursor(tree, tree.support().lo + Vec3d(0.5, 2, 2));
    Walk walk(tree, cursor, widen(Vec3f(speed, 4e-6f * speed, 5e-6f * speed)));
    double end = 0;
    while (const auto s = walk.next()) end = s->t1;
    EXPECT_GE(0.5 + end * double(speed), tree.support().extent().x - 0.01) << speed;
  }
}

TEST(Walk, OfAnEmptyCloudHasNoSegments) {
  const Field f = make_field("empty", {0, 0, 0}, {8, 8, 8}, [](Vec3i) { return 0; });
  EXPECT_TRUE(make_test_volume(f, 1, std::nullopt).density.octree.empty());
}

TEST(Walk, WithoutExtinctionHasNoSegments) {
  const Volume v = make_test_volume(field("gaussian"), 0, std::nullopt);
  for (const Ray& ray : rays_through(v)) {
    if (auto from = start(v, ray)) {
      EXPECT_FALSE(Walk(v.density.octree, from->cursor, from->direction).next());
    }
  }
}

}  // namespace walk_test
}  // namespace pvol::test
