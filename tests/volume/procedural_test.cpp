// Procedural look-ups: certified bounds, trackers, the squeeze and whole images.
#include "pvol/field/procedural.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <map>

#include "pvol/bounds/recipe_bounds.h"
#include "pvol/embed.h"
#include "pvol/error.h"
#include "pvol/formats/recipe_file.h"
#include "pvol/render/render.h"
#include "pvol/trackers.h"
#include "pvol/volume/extinction_source.h"
#include "pvol/volume/facts.h"
#include "support/cloud_scene.h"
#include "support/estimators.h"
#include "support/field_proof.h"
#include "support/flights.h"
#include "support/nasty_offset.h"
#include "support/pictures.h"

namespace pvol::test {
namespace procedural_test {

constexpr auto kProcedural = LookUp::procedural;

/// A sample's recipe with the voxels of a small test.
struct Cloud {
  std::string name;
  std::shared_ptr<const Recipe> recipe;
  Pyramid pyramid;
};

const std::vector<Cloud>& clouds() {
  static const std::vector<Cloud> all = [] {
    std::vector<Cloud> list;
    for (const char* name : {"column", "solid", "cumulus"}) {
      Recipe r =
          formats::read_recipe(std::filesystem::path(PVOL_SAMPLES) / (name + std::string(".toml")));
      r.voxel = voxel_for(r, name == std::string("column") ? 80 : 40);
      Pyramid pyramid = build_pyramid(r);
      list.push_back({name, std::make_shared<const Recipe>(std::move(r)), std::move(pyramid)});
    }
    return list;
  }();
  return all;
}

CloudScene scene_for(const Cloud& c, Tracker tracker = Tracker::delta) {
  CloudScene s;
  s.medium.extinction = 15 / min_component(c.pyramid.support().extent()) / c.recipe->voxel;
  s.options.tracker = tracker;
  s.options.look_up = kProcedural;
  s.options.width = s.options.height = 16;
  s.options.samples = 4;
  return s;
}

std::uint32_t brick_of(const Volume& v, Int4 cell) {
  return v.density.octree.brick_at(Octree::kNodeBit, cell, kZeroBrick);
}

Int4 random_cell(const Volume& v, Rng& rng) {
  Vec3i cell;
  for (int axis = 0; axis < 3; ++axis) {
    const int size = v.density.octree.support_hi[axis] - v.density.octree.support_lo[axis];
    cell[axis] = v.density.octree.support_lo[axis] + int(rng.block().lo % std::uint64_t(size));
  }
  return widen(cell);
}

/// Look-ups are the recipe's density to the last bit, 0 outside all leaves, and inside the bounds
/// of their leaf and of the cube around them.
TEST(Procedural, LookupsAreTheRecipeAndKeepAllBounds) {
  for (const Cloud& c : clouds()) {
    CloudScene s = scene_for(c);
    const Volume v = make_volume(c.recipe, c.pyramid, s);
    const MicroBounds one = build_micro_bounds(v.density.recipe(), 1);
    const MicroBounds two = build_micro_bounds(v.density.recipe(), 2);
    Rng rng(kSeed, 1, 0);
    int wrong = 0, outside = 0, inside = 0;
    std::vector<std::uint32_t> bricks;
    std::vector<LatticePoint> places;
    std::vector<float> densities;
    for (int i = 0; i < proof::samples(60'000); ++i) {
      const LatticePoint p{random_cell(v, rng), nasty_offsets(rng)};
      const std::uint32_t brick = brick_of(v, p.cell);
      const float rho = density_in_brick(v.density.recipe(), brick, p);
      bricks.push_back(brick), places.push_back(p), densities.push_back(rho);
      const Vec3d index =
          Vec3d(vec3(p.cell)) + Vec3d(v.density.octree.origin) + Vec3d(vec3(p.frac));
      wrong += rho != float(density(*c.recipe, index * c.recipe->voxel));
      for (const DensityRange r :
           {micro_range(one, brick, p.cell), micro_range(two, brick, p.cell)}) {
        outside += !(r.lo <= rho && rho <= r.hi);
      }
      const auto leaf =
          find(c.pyramid.levels[0], morton_encode(Vec3<std::uint32_t>(Vec3i(vec3(p.cell >> 3)))));
      if (!leaf) continue;
      const PyramidNode& n = c.pyramid.levels[0][*leaf];
      outside += !(n.lo <= rho && rho <= n.hi);
      inside += rho > 0 && rho < c.pyramid.scale;
    }
    EXPECT_EQ(wrong, 0) << c.name;
    EXPECT_EQ(outside, 0) << c.name;
    EXPECT_GT(inside, proof::samples(200)) << c.name;
    std::vector<float> at_once(places.size(), -1);
    densities_in_bricks(v.density.recipe(), bricks, places, at_once.data());
    EXPECT_EQ(at_once, densities) << c.name;
  }
}

/// Bounds that end at a depth of the octree: what is above stays as it is, and all that is asked of
/// the recipe below is inside them.
TEST(Procedural, BoundsOfALimitedDepthHold) {
  for (const Cloud& c : clouds()) {
    CloudScene s = scene_for(c);
    const int deepest = int(c.pyramid.levels.size()) - 1;
    EXPECT_EQ(limit_depth(c.pyramid, deepest), c.pyramid) << c.name;
    const Pyramid limited = limit_depth(c.pyramid, deepest - 1);
    EXPECT_EQ(limited.levels[1], c.pyramid.levels[1]) << c.name;
    const Volume v = make_volume(c.recipe, limited, s), whole = make_volume(c.recipe, c.pyramid, s);
    const MicroBounds codes = build_micro_bounds(v.density.recipe(), 1);
    EXPECT_LT(codes.scales.size(), build_micro_bounds(whole.density.recipe(), 1).scales.size());
    Rng rng(kSeed, 2, 0);
    int inside = 0;
    for (int i = 0; i < 20'000; ++i) {
      const LatticePoint p{random_cell(v, rng), nasty_offsets(rng)};
      const std::uint32_t brick = brick_of(v, p.cell);
      const float rho = density_in_brick(v.density.recipe(), brick, p);
      ASSERT_EQ(rho, density_in_brick(whole.density.recipe(), brick_of(whole, p.cell), p));
      const DensityRange r = micro_range(codes, brick, p.cell);
      ASSERT_LE(r.lo, rho) << c.name;
      ASSERT_GE(r.hi, rho) << c.name;
      inside += rho > 0;
    }
    EXPECT_GT(inside, 200) << c.name;
  }
}

/// mu(t) by the recipe itself, tabulated: Simpson's rule on panels far finer than a voxel.
class TabulatedRay {
 public:
  template <class Mu>
  TabulatedRay(const Mu& mu, double end) : step_(end / kPanels), depth_(kPanels + 1) {
    double before = mu(0.0);
    for (std::size_t i = 0; i < kPanels; ++i) {
      const double a = double(i) * step_, after = mu(a + step_);
      depth_[i + 1] = depth_[i] + step_ / 6 * (before + 4 * mu(a + 0.5 * step_) + after);
      before = after;
    }
  }
  [[nodiscard]] double optical_depth() const { return depth_.back(); }
  [[nodiscard]] double inverse_optical_depth(double depth) const {
    const auto at = std::upper_bound(depth_.begin() + 1, depth_.end() - 1, depth);
    const auto i = std::size_t(at - depth_.begin());
    return (double(i) - (depth_[i] - depth) / (depth_[i] - depth_[i - 1])) * step_;
  }
  /// The same ray walked `factor` times as fast.
  [[nodiscard]] TabulatedRay faster(double factor) const {
    TabulatedRay r = *this;
    r.step_ /= factor;
    for (double& d : r.depth_) d /= factor;
    return r;
  }

 private:
  static constexpr std::size_t kPanels = 2000;
  double step_;
  std::vector<double> depth_;
};

struct Start {
  Cursor cursor;
  Float4 direction;
  TabulatedRay oracle;
};

/// A ray from outside through the cloud, its lengths scaled to an optical depth of 2.
Start find_ray(const Cloud& c, const Volume& v, std::uint64_t stream) {
  const Box box = v.density.octree.support();
  Rng rng(kSeed, 2, stream);
  for (;;) {
    const auto number = [&] { return 2 * double(rng.uniform()) - 1; };
    const Vec3d d = normalize(Vec3d{number(), number(), number()});
    const Vec3d middle = box.centre() + box.extent() * 0.3 * Vec3d{number(), number(), number()};
    const auto span = intersect(box, {middle - d * 1000.0, d}, 0, 1e9);
    if (!span) continue;
    const Cursor cursor = make_cursor(v.density.octree, middle + d * (span->t0 - 1000));
    const Vec3d from = Vec3d(vec3(cursor.at.cell)) + Vec3d(vec3(cursor.at.frac));
    const Float4 unit = widen(Vec3f(d));
    const auto mu = [&](double t) {
      const Vec3d p = from + Vec3d(vec3(unit)) * t + Vec3d(v.density.octree.origin);
      return double(v.density.scale) * density(*c.recipe, p * c.recipe->voxel);
    };
    const TabulatedRay ray(mu, span->t1 - span->t0);
    const auto factor = float(ray.optical_depth() / 2);
    constexpr float kEnough = 1;  // thin rays have many null collisions for each real one
    if (factor > kEnough) return {cursor, unit * splat(factor), ray.faster(double(factor))};
  }
}

constexpr std::uint64_t kRaysOfCloud = 3;

/// The rays of a cloud, in a volume made for `scene_for` it with any tree.
const Start& aim(const Cloud& c, const Volume& v, std::uint64_t ray) {
  static std::map<std::string, std::vector<Start>> all;
  std::vector<Start>& starts = all[c.name];
  while (starts.size() <= ray) starts.push_back(find_ray(c, v, starts.size()));
  return starts[ray];
}

/// The start of a ray in the tree of a volume: nodes differ from tree to tree.
Start start_in(const Cloud& c, const Volume& v, std::uint64_t ray) {
  Start s = aim(c, v, ray);
  const LatticePoint at = s.cursor.at;
  s.cursor = make_cursor(v.density.octree, Vec3d(vec3(at.cell)) + Vec3d(vec3(at.frac)));
  return s;
}

TEST(ProceduralTracking, FollowsTheOpticalDepthOfTheRecipe) {
  proof::Family family, together;
  std::map<std::string, FlightHistogram> sums;
  std::uint64_t stream = 0;
  for (const Cloud& c : clouds()) {
    for (const std::optional<int> depth : {std::optional<int>(2), std::optional<int>()}) {
      CloudScene s = scene_for(c);
      s.options.depth = depth;
      const Volume v = make_volume(c.recipe, c.pyramid, s);
      for (std::uint64_t ray = 0; ray < kRaysOfCloud; ++ray) {
        const PlainField field{extinction_source<kProcedural>(v.density)};
        prove(v.density.octree, start_in(c, v, ray), field, 2000, c.name, stream, family, sums);
      }
    }
  }
  for (const auto& [name, sum] : sums) together.add(name, sum.p_value());
  EXPECT_TRUE(family.passes());
  EXPECT_TRUE(together.passes());
}

/// Over the two clouds whose look-ups cost least.
double p_value_with_extinction_times(float factor, int flights) {
  std::optional<FlightHistogram> sum;
  for (std::size_t i = 0; i < 2; ++i) {
    const Cloud& c = clouds()[i];
    CloudScene s = scene_for(c);
    s.options.micro_bounds = MicroBoundsUse::edge_2;
    const Volume v = make_volume(c.recipe, c.pyramid, s);
    for (std::uint64_t ray = 0; ray < kRaysOfCloud; ++ray) {
      const Start a = start_in(c, v, ray);
      auto source = extinction_source<kProcedural>(v.density);
      source.scale *= factor;
      const SqueezedField<CubeBounds, ProceduralExtinction> wrong{source, {v.density.micro}};
      if (!sum) sum.emplace(a.oracle);
      sum->add(sample_flights<Tracker::delta>(v.density.octree, a, wrong, flights, 900 + ray));
    }
  }
  return sum->p_value();
}

/// On a commit of two, by as many flights as are to find them there.
TEST(ProceduralTracking, TheProofFindsAnErrorOfOnePerCent) {
  EXPECT_GT(p_value_with_extinction_times(1, 30'000), proof::kFalseAlarmRate);
  const float wrong = proof::runs_all() ? 0.99f : 0.98f;
  EXPECT_LT(p_value_with_extinction_times(wrong, proof::samples(120'000)), 1e-6);
}

TEST(ProceduralSqueeze, IsBitIdenticalToPlainTracking) {
  for (const Cloud& c : clouds()) {
    SCOPED_TRACE(c.name);
    CloudScene s = scene_for(c);
    const Volume v = make_volume(c.recipe, c.pyramid, s);
    const auto source = extinction_source<kProcedural>(v.density);
    const PlainField plain{source};
    const MicroBounds one = build_micro_bounds(v.density.recipe(), 1);
    const MicroBounds two = build_micro_bounds(v.density.recipe(), 2);
    const SqueezedField<CubeBounds, ProceduralExtinction> single{source, {one}};
    const SqueezedField<CubeBounds, ProceduralExtinction> cubes{source, {two}};
    for (std::uint64_t ray = 0; ray < kRaysOfCloud; ++ray) {
      const Start a = start_in(c, v, ray);
      const double fine = compare_flights<Tracker::delta>(v.density.octree, a, plain, single, 2000);
      const double coarse =
          compare_flights<Tracker::delta>(v.density.octree, a, plain, cubes, 2000);
      EXPECT_LE(fine, coarse);
      EXPECT_LE(compare_flights<Tracker::decomposition>(v.density.octree, a, plain, cubes, 2000),
                1);
      EXPECT_LT(fine, c.name == "column" ? 0.7 : 1);  // its cells are finer than its noise
    }
  }
}

TEST(ProceduralSqueeze, LeavesEveryImageAsItIs) {
  std::size_t turn = 0;
  for (const Cloud& c : clouds()) {
    for (const Tracker tracker : {Tracker::delta_global, Tracker::delta, Tracker::decomposition}) {
      if (!proof::has_turn(turn++)) continue;
      CloudScene s = scene_for(c, tracker);
      std::optional<Film> first;
      for (const auto micro :
           {MicroBoundsUse::none, MicroBoundsUse::edge_2, MicroBoundsUse::edge_1}) {
        s.options.micro_bounds = micro;
        s.options.threads = micro == MicroBoundsUse::none ? 1 : 3;
        const Volume v = make_volume(c.recipe, c.pyramid, s);
        s.camera = frame(v.density.world_box, 1);
        const RenderResult r = render(v, s);
        if (!first) first = r.film;
        EXPECT_TRUE(same_bytes(*first, r.film)) << c.name << ", " << label(tracker);
      }
    }
  }
}

TEST(ProceduralImages, AreTheSkyInAFurnace) {
  for (const Cloud& c : clouds()) {
    for (const Tracker tracker : kTrackers) {
      if (tracker == Tracker::regular) continue;
      CloudScene s = scene_for(c, tracker);
      s.medium.albedo = Rgb(1.0f);
      s.environment = ConstantSky{Rgb(1.0f)};
      const Volume v = make_volume(c.recipe, c.pyramid, s);
      s.camera = frame(v.density.world_box, 1);
      double scattered = 0;
      for (const PixelSums& p : render(v, s).film.pixels) {
        EXPECT_EQ(mean(p), Vec3d(1.0)) << c.name << ", " << label(tracker);
        scattered += p.alpha;
      }
      EXPECT_GT(scattered, 20) << c.name;
    }
  }
}

/// Two clouds at once, and one of them far away: placement works as it does for samples.
TEST(ProceduralImages, MayHoldSeveralRecipes) {
  const Cloud& c = clouds()[0];
  CloudScene s = scene_for(c);
  s.medium.albedo = Rgb(1.0f);
  s.environment = ConstantSky{Rgb(1.0f)};
  std::vector<Volume> volumes;
  volumes.push_back(make_volume(c.recipe, c.pyramid, s));
  CloudScene moved = s;
  moved.medium.object_to_world = translation({0.3, 0.2, 0.1});
  volumes.push_back(make_volume(clouds()[1].recipe, clouds()[1].pyramid, moved));
  s.camera = frame(volumes[0].density.world_box, 1);
  for (const PixelSums& p : render(volumes, s).film.pixels) EXPECT_EQ(mean(p), Vec3d(1.0));
}

TEST(Procedural, IsDescribedByCoarseSamples) {
  for (const Cloud& c : clouds()) {
    const CloudScene s = scene_for(c);
    const Volume v = make_volume(c.recipe, c.pyramid, s);
    const VolumeFacts f = describe(v, describe(*c.recipe, s.medium.extinction, {}));
    Recipe fine = *c.recipe;
    fine.voxel = voxel_for(fine, 128);
    const VolumeFacts g = describe(make_grid(fine), s.medium.extinction, {});
    for (int axis = 0; axis < 3; ++axis) {
      const double expected = g.mean_optical_thickness[axis];
      EXPECT_NEAR(f.mean_optical_thickness[axis], expected, 0.2 * expected) << c.name;
    }
    EXPECT_NEAR(f.largest_extinction, g.largest_extinction, 0.2 * g.largest_extinction) << c.name;
    EXPECT_GT(f.terminals, 0u);
    EXPECT_GT(f.field_bytes, 0u);
  }
}

TEST(Procedural, IsEmbeddedAsAnyVolume) {
  const Cloud& c = clouds()[0];
  const Volume v = make_volume(*c.recipe, {.extinction = 3});
  Rng rng(kSeed, 9, 0);
  for (int i = 0; i < 2000; ++i) {
    const LatticePoint p{random_cell(v, rng), Float4{0.5f, 0.25f, 0.75f, 0}};
    const Vec3d index = Vec3d(vec3(p.cell)) + Vec3d(v.density.octree.origin) + Vec3d(vec3(p.frac));
    const Vec3d world = index * c.recipe->voxel;
    EXPECT_NEAR(double(density_at(v, world)), density(*c.recipe, world), 1e-4);
  }
  const Ray ray{v.density.world_box.centre() - Vec3d(10, 0, 0), {1, 0, 0}};
  const TabulatedRay oracle([&](double t) { return 3 * density(*c.recipe, ray.at(t)); }, 20);
  proof::Moments m;
  for (int i = 0; i < 20'000; ++i) m.add(double(sample_transmittance(v, ray, 20, rng)));
  EXPECT_GT(proof::mean_p_value(m, std::exp(-oracle.optical_depth())), proof::kFalseAlarmRate);
}

TEST(Procedural, RefusesWhatDoesNotFit) {
  const Cloud& c = clouds()[0];
  CloudScene s = scene_for(c);
  const VoxelGrid grid = make_grid(*c.recipe);
  EXPECT_THROW((void)make_volume(grid, c.pyramid, s), Error);                // samples
  EXPECT_THROW((void)make_volume(c.recipe, build_pyramid(grid), s), Error);  // of the samples alone
  Recipe denser = *c.recipe;
  denser.density *= 1.01;
  EXPECT_THROW((void)make_volume(std::make_shared<const Recipe>(denser), c.pyramid, s), Error);
  CloudScene regular = s;
  regular.options.tracker = Tracker::regular;
  const Volume v = make_volume(c.recipe, c.pyramid, regular);
  regular.camera = frame(v.density.world_box, 1);
  EXPECT_THROW((void)render(v, regular), Error);
  EXPECT_THROW((void)build_micro_bounds(v.density.recipe(), 3), Error);
  s.options.look_up = LookUp::tricubic;
  EXPECT_THROW((void)make_volume(grid, c.pyramid, s), Error);  // the wider kernel leaves the bounds
  s.options.look_up = LookUp::trilinear;
  EXPECT_NO_THROW((void)make_volume(grid, c.pyramid, s));
  const Volume evaluated = make_volume(c.recipe, c.pyramid, s);  // whatever the options say
  EXPECT_EQ(evaluated.density.look_up, LookUp::procedural);
  EXPECT_THROW((void)render(evaluated, s), Error);
}

TEST(Procedural, MayBeEmpty) {
  Recipe r = *clouds()[0].recipe;
  r.displacements.clear();
  r.cuts.emplace_back(FreeForm{Quadric{{}, {}, {}, -1}, {}});
  const auto empty = std::make_shared<const Recipe>(r);
  const Pyramid p = build_pyramid(r);
  ASSERT_TRUE(p.empty());
  CloudScene s = scene_for(clouds()[0]);
  const Volume v = make_volume(empty, p, s);
  EXPECT_TRUE(render(v, s).complete);
  EXPECT_EQ(describe(v, describe(r, s.medium.extinction, {})).largest_optical_thickness, 0);
}

}  // namespace procedural_test
}  // namespace pvol::test
