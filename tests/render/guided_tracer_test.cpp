// Paths through a script in place of a cloud: what the tracers do at each collision, to the last
// bit. Means over whole pictures hide errors in what is rare.
#include "render/engine/guided_tracer.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <vector>

#include "support/bodies.h"

namespace pvol::test {
namespace guided_tracer_test {

/// What flights of a path and its branches meet, in this order; all later ones leave.
struct Script {
  std::vector<detail::MediumComponent> collisions;
  std::vector<Vec3f> flown;  ///< the directions of flight
  std::uint64_t passed = 0;  ///< shadow rays
  std::vector<int> from;     ///< where the flights began, by number of the collision
};
Script script;

/// Flies by the script. The place after collision i is cell (i, 0, 0).
class ScriptedTraversal {
 public:
  static constexpr bool kByChannel = false, kHasSurfaces = false;

  explicit ScriptedTraversal(const detail::PathSetup&) {}
  [[nodiscard]] bool start(const Ray&) { return true; }
  [[nodiscard]] detail::Hit fly(Vec3f direction, Rng&) {
    script.flown.push_back(direction);
    script.from.push_back(place_.at.cell[0]);
    const std::size_t i = script.flown.size() - 1;
    if (i >= script.collisions.size()) return {};
    place_.at.cell = Int4{int(i), 0, 0, 0};
    return {&script.collisions[i], 1};
  }
  [[nodiscard]] const Cursor& place() const { return place_; }
  void return_to(const Cursor& place) { place_ = place; }
  [[nodiscard]] Vec3d position() const { return Vec3d(place_.at.cell[0], 0, 0); }
  [[nodiscard]] detail::CollisionPlace collision() const { return {}; }
  struct {
    static void set_time(float) {}
    struct {
      float time = 0;
    } path;
  } work;
  [[nodiscard]] detail::FreeFlight free_flight(Vec3f, Rng&) { return {detail::kEndless, 1}; }
  [[nodiscard]] float transmittance(Vec3f, double, Rng&) {
    ++script.passed;
    return 1;
  }

 private:
  Cursor place_;
};

detail::MediumComponent scattering(float albedo, double g = 0) {
  return {1, Rgb(albedo), Rgb(0.0f), HenyeyGreenstein(g)};
}

using Row = detail::Importance::Row;

/// The same in all directions.
Row flat(float value) {
  Row row;
  row.at.fill(value);
  return row;
}

/// Paths are turned towards the axis.
Row turning(float value) {
  Row row = flat(value);
  row.at.back() = 0.1f * value;
  return row;
}

/// By number of the collision.
detail::Importance importance_of(const std::vector<Row>& rows) {
  detail::CoarseCells cells;
  cells.shift = 0;
  cells.last = Int4{int(rows.size()) - 1, 0, 0, 0};
  cells.size = Vec3i(int(rows.size()), 1, 1);
  for (std::uint32_t i = 0; i < rows.size(); ++i) cells.rows.push_back(i);
  return {std::move(cells), Vec3f(0, 0, 1), HenyeyGreenstein(0),
          PagedVector<Row>(rows.begin(), rows.end()), std::vector<float>(rows.size(), 1.0f)};
}

/// A setup for scripted paths before a sky of radiance 1, which next-event estimation leaves out.
class ScriptedPaths : public testing::Test {
 protected:
  [[nodiscard]] detail::PathSetup setup(std::vector<Light> lights = {}) {
    CloudScene s{{}, ConstantSky{Rgb(1.0f)}, std::move(lights), {}, {}};
    s.options.width = s.options.height = 1;
    s.options.look_up = LookUp::nearest;
    s.options.filter = PixelFilter::box;
    volumes_ = make_volumes(cube(), std::vector{s.medium}, s);
    s.camera = frame(volumes_.front().density.world_box, 1);
    return detail::PathSetup(plan(volumes_, s.scene()));
  }
  [[nodiscard]] detail::PathSetup setup(const std::vector<Row>& importance) {
    detail::PathSetup guided = setup();
    guided.importance = std::make_shared<const detail::Importance>(importance_of(importance));
    return guided;
  }

  std::vector<Volume> volumes_;
};

/// The radiance of one scripted path.
template <class Tracer>
float trace(Tracer& tracer, std::uint32_t sample = 0) {
  script.flown.clear();
  script.from.clear();
  return tracer.trace(0, 0, sample).radiance.x;
}

using Guided = detail::GuidedTracer<ScriptedTraversal>;
using Plain = detail::PathTracer<ScriptedTraversal>;

/// `survivor` is what each path brings that roulette spares; together they make up for the others.
template <class Tracer>
void expect_fair_roulette(Tracer& tracer, float chance, float survivor, proof::Family& family) {
  const std::uint32_t kPaths = proof::samples<std::uint32_t>(200'000);
  std::uint64_t counts[2] = {};
  for (std::uint32_t i = 0; i < kPaths; ++i) {
    const float brought = trace(tracer, i);
    ++counts[brought > 0];
    ASSERT_TRUE(brought == 0 || std::abs(brought / survivor - 1) < 1e-6f) << brought;
  }
  const double expected[2] = {kPaths * (1 - double(chance)), kPaths * double(chance)};
  family.add(std::to_string(chance), proof::counts_p_value(counts, expected));
}

TEST_F(ScriptedPaths, SurvivorsOfImportanceRouletteMakeUpForTheOthers) {
  proof::Family family;
  for (const float importance : {0.03f, 0.25f, 0.45f}) {
    script.collisions = {scattering(0.5f)};
    const detail::PathSetup s = setup({flat(importance)});
    Guided tracer(s);
    expect_fair_roulette(tracer, importance, 0.5f / importance, family);
  }
  EXPECT_TRUE(family.passes());
}

TEST_F(ScriptedPaths, SurvivorsOfPathRouletteMakeUpForTheOthers) {
  proof::Family family;
  const detail::PathSetup s = setup();
  for (const float chance : {0.1f, 0.5f, 0.9f}) {
    script.collisions = {scattering(chance * detail::kPathRoulette)};
    Plain tracer(s);
    expect_fair_roulette(tracer, chance, detail::kPathRoulette, family);
  }
  EXPECT_TRUE(family.passes());
}

TEST_F(ScriptedPaths, NoRouletteWhereItWouldSaveNothing) {
  script.collisions = {scattering(detail::kPathRoulette)};
  const detail::PathSetup s = setup();
  Plain plain(s);
  const detail::PathSetup t = setup({flat(detail::kEndBelow)});
  Guided guided(t);
  for (std::uint32_t i = 0; i < 100; ++i) {
    EXPECT_EQ(trace(plain, i), detail::kPathRoulette);
    EXPECT_EQ(trace(guided, i), detail::kPathRoulette);
  }
}

/// Each path brings what all of its branches together do: nothing is lost or made twice.
TEST_F(ScriptedPaths, BranchesShareTheThroughput) {
  for (const float importance : {2.0f, 2.5f, 4.0f, 7.9f, 8.0f, 1e9f}) {
    script.collisions = {scattering(1)};
    const detail::PathSetup s = setup({flat(importance)});
    Guided tracer(s);
    EXPECT_FLOAT_EQ(trace(tracer), 1) << importance;
    const int paths = importance > detail::kSplitAbove ? int(std::min(importance, 8.0f)) : 1;
    EXPECT_EQ(int(script.flown.size()), 1 + paths) << importance;
  }
}

/// More collisions ask for branches than places are there to wait.
TEST_F(ScriptedPaths, NothingIsLostWhereNoMoreBranchesCanWait) {
  constexpr int kCollisions = 20, kPlaces = 16;
  std::vector<Row> importance;
  for (int i = 0; i < kCollisions; ++i) importance.push_back(flat(std::ldexp(2.5f, i)));  // two
  script.collisions.assign(kCollisions, scattering(1));
  const detail::PathSetup s = setup(importance);
  Guided tracer(s);
  for (std::uint32_t sample = 0; sample < 3; ++sample) {
    EXPECT_EQ(trace(tracer, sample), 1);  // sums of powers of 2
    EXPECT_EQ(int(script.flown.size()), 1 + kCollisions + kPlaces);
  }
}

/// Branches scatter at the collision where they waited: by its medium, and out of the flight that
/// ended there.
TEST_F(ScriptedPaths, BranchesGoOnFromTheirOwnCollision) {
  const double g = kLargestMeanCosine;  // straight on or back
  script.collisions = {scattering(1, g), scattering(1, -g), scattering(1, g)};
  const detail::PathSetup s = setup({flat(2.5f), flat(5), flat(10)});
  Guided tracer(s);
  for (std::uint32_t sample = 0; sample < 100; ++sample) {
    EXPECT_EQ(trace(tracer, sample), 1);
    ASSERT_EQ(script.flown.size(), 7u);
    const Vec3f ahead = script.flown[0];
    const float along[] = {1, 1, -1, -1, -1, -1, 1};
    EXPECT_EQ(script.from, (std::vector<int>{0, 0, 1, 2, 2, 1, 0}));
    for (std::size_t i = 0; i < 7; ++i) {
      EXPECT_NEAR(dot(script.flown[i], ahead), along[i], 0.5f) << i;
    }
  }
}

/// Of both tracers; a path that meets nothing sees the sky.
TEST_F(ScriptedPaths, AlphaIsWhetherTheFirstFlightCollides) {
  const detail::PathSetup s = setup(), t = setup({flat(1)});
  Plain plain(s);
  Guided guided(t);
  for (const int collisions : {0, 1}) {
    script.collisions.assign(std::size_t(collisions), scattering(0.5f));
    EXPECT_EQ(trace(plain), collisions ? 0.5f : 1);
    EXPECT_EQ(trace(guided), collisions ? 0.5f : 1);
    script.flown.clear();
    EXPECT_EQ(plain.trace(0, 0, 0).alpha, float(collisions));
    script.flown.clear();
    EXPECT_EQ(guided.trace(0, 0, 0).alpha, float(collisions));
  }
}

/// Before absorption, and what later collisions emit after that of earlier ones.
TEST_F(ScriptedPaths, EveryCollisionEmits) {
  detail::MediumComponent glowing = scattering(0.5f);
  glowing.emitted = Rgb(0.25f);
  script.collisions = {glowing, glowing};
  const detail::PathSetup s = setup(), t = setup({flat(1), flat(2)});
  Plain plain(s);
  Guided guided(t);
  EXPECT_EQ(trace(plain), 0.25f + 0.5f * 0.25f + 0.25f);  // and the sky
  EXPECT_EQ(trace(guided), 0.25f + 0.5f * 0.25f + 0.25f);
}

TEST_F(ScriptedPaths, ShadowRaysAreCounted) {
  script.collisions = {scattering(1), scattering(1)};
  script.passed = 0;
  const detail::PathSetup s = setup({Sun{{0, 1, 0}, Rgb(3.0f), 0}, Sun{{1, 0, 0}, Rgb(0.1f), 0}});
  Plain tracer(s);
  for (std::uint32_t i = 0; i < 100; ++i) (void)trace(tracer, i);
  EXPECT_GT(script.passed, 0u);
  EXPECT_EQ(tracer.shadow_rays, script.passed);
  EXPECT_EQ(tracer.collisions, 200u);
}

/// So the number of shadow rays does not hang on the unit of light.
TEST_F(ScriptedPaths, ATenthOfTheLightIsWorthAShadowRay) {
  EXPECT_EQ(setup().light.shadow_unit, 0);
  EXPECT_NEAR(setup({Sun{{0, 1, 0}, Rgb(3.0f), 0}}).light.shadow_unit, 0.3, 1e-6);
  EXPECT_NEAR(setup({Sun{{0, 1, 0}, Rgb(3e-6f), 0}}).light.shadow_unit, 3e-7, 1e-12);
}

/// All over its pixel, and nowhere else.
TEST_F(ScriptedPaths, CameraRaysBeginInTheirPixel) {
  const detail::PathSetup s = setup();
  const detail::Projection& p = s.view.projection;
  const Vec3d forward = p.ray(0.5, 0.5).d;  // the middle of the one pixel
  const auto in_plane = [&](Vec3d d) { return d / dot(d, forward); };
  const Vec3d corner = in_plane(p.ray(0, 0).d);
  const Vec3d right = in_plane(p.ray(1, 0).d) - corner, below = in_plane(p.ray(0, 1).d) - corner;
  proof::Histogram across(8), down(8);
  for (std::uint32_t i = 0; i < 1000; ++i) {
    const Vec3d at = in_plane(detail::CameraSample(s, 2, 5, i).ray.d) - corner;
    across.add(dot(at, right) / dot(right, right) - 2);
    down.add(dot(at, below) / dot(below, below) - 5);
  }
  proof::Family family;
  family.add("across", across.uniform_p_value());
  family.add("down", down.uniform_p_value());
  EXPECT_TRUE(family.passes());
}

TEST(ImportanceRow, IsLinearBetweenItsNodes) {
  constexpr int kLast = detail::kDirectionNodes - 1;
  std::vector<Row> rows(2, flat(std::numeric_limits<float>::quiet_NaN()));  // nothing of the next
  for (int i = 0; i <= kLast; ++i) rows[0].at[std::size_t(i)] = float(i * i);
  for (int i = 0; i <= kLast; ++i) {
    EXPECT_NEAR(rows[0].of(float(i) / kLast), i * i, 1e-3) << i;
    if (i == kLast) break;
    const float half = 0.5f * float(i * i + (i + 1) * (i + 1));
    EXPECT_NEAR(rows[0].of((float(i) + 0.5f) / kLast), half, 1e-3) << i;
  }
}

TEST(CoarseCells, HaveTheRowOfTheCubeAroundACell) {
  detail::CoarseCells cells;
  cells.low = Int4{1, 2, 3, 0};
  cells.last = Int4{1, 0, 2, 0};
  cells.size = Vec3i(2, 1, 3);
  cells.rows = {10, 11, 12, 13, 14, 15};
  EXPECT_EQ(cells.row(Int4{8, 16, 24, 0}), 10u);
  EXPECT_EQ(cells.row(Int4{15, 23, 32, 0}), 11u);
  EXPECT_EQ(cells.row(Int4{16, 23, 31, 0}), 13u);
  EXPECT_EQ(cells.row(Int4{23, 16, 47, 0}), 15u);
  EXPECT_EQ(cells.row(Int4{0, 99, 99, 0}), 12u);  // the nearest
}

/// Where the place of the last collision, which ended the path, would turn it and change its
/// weight, and that of the branch does not.
TEST_F(ScriptedPaths, BranchesAreTurnedByTheirOwnPlace) {
  script.collisions = {scattering(1), scattering(0)};
  const detail::PathSetup s = setup({flat(2.5f), turning(2)});
  Guided tracer(s);
  for (std::uint32_t sample = 0; sample < 100; ++sample) EXPECT_EQ(trace(tracer, sample), 0.5f);
}

}  // namespace guided_tracer_test
}  // namespace pvol::test
