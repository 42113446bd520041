// Density mapped after interpolation: bounds that hold, look-ups, pictures.
#include <gtest/gtest.h>

#include "pvol/embed.h"
#include "pvol/math/field_map.h"
#include "pvol/trackers.h"
#include "support/error_of.h"
#include "support/estimators.h"
#include "support/messages.h"
#include "support/pictures.h"
#include "support/small_cloud.h"

namespace pvol::test {
namespace mapped_density_test {

std::shared_ptr<const FieldMap> shared(const FieldMap& map) {
  return std::make_shared<const FieldMap>(map);
}

const FieldMap kMaps[] = {
    {.scale = 2.5},
    {.power = 3},
    {.ramp = {{{0, 0}, {0.3f, 0}, {0.31f, 1}}, false}},
    {.ramp = {{{0, 0}, {0.2f, 1.5f}, {0.5f, 0}, {1, 0.7f}}, true}},
    {.scale = -1, .offset = 0, .clamp = {{-0.6, -0.1}}, .ramp = {{{-0.6f, 2}, {-0.1f, 0}}, false}},
};

Volume mapped(const Field& field, const FieldMap& map, double extinction,
              VolumeOptions options = {}) {
  options.map = shared(map);
  return make_volume(field.grid, Medium{.extinction = extinction}, options);
}

TEST(MappedDensity, IsTheMapOfTheInterpolatedValue) {
  Rng rng(11, 0, 0);
  for (const Field& f : fields()) {
    const Volume plain = make_test_volume(f, 1, std::nullopt);
    for (const FieldMap& map : kMaps) {
      const Volume v = mapped(f, map, 3);
      for (int i = 0; i < 200; ++i) {
        const Vec3d p = f.grid.index_to_world.point(random_point_near_density(f, rng));
        const float expected = value_at(map, density_at(plain, p));
        EXPECT_FLOAT_EQ(density_at(v, p), expected) << f.name;
        EXPECT_FLOAT_EQ(extinction_at(v, p), 3 * expected) << f.name;
      }
    }
  }
}

TEST(MappedDensity, BoundsHoldAlongRaysAndWhatIsEmptyIsSkipped) {
  Rng rng(12, 0, 0);
  std::uint64_t kept = 0, whole = 0;
  for (const Field& f : fields()) {
    for (const FieldMap& map : kMaps) {
      const Volume v = mapped(f, map, 2);
      const Volume plain = make_test_volume(f, 2, std::nullopt);
      whole += plain.density.octree.terminals;
      kept += v.density.octree.terminals;
      for (int i = 0; i < 50; ++i) {
        const Vec3d p = f.grid.index_to_world.point(random_point_near_density(f, rng));
        const Vec3d d = normalize(Vec3d(Vec3f{rng.uniform() - 0.5f, rng.uniform() - 0.5f, 0.3f}));
        auto walk = enter(v, {p - d * 100, d});
        if (!walk) continue;
        visit_field(v, [&](const auto& field) {
          NoTally none;
          while (const auto s = walk->next()) {
            ASSERT_GT(s->hi, 0);
            const auto at = walk->point(s->t0 + double(rng.uniform()) * (s->t1 - s->t0));
            const float mu = field.extinction(*s, at, none);
            ASSERT_LE(mu, s->hi) << f.name;
            ASSERT_GE(mu, s->lo) << f.name;
          }
        });
      }
    }
  }
  EXPECT_LT(kept, whole) << "maps that cut leave less to walk through";
}

/// A linear field mapped linearly in pieces is the picture of samples that were mapped before: the
/// two commute where the map is linear.
TEST(MappedDensity, OfALinearMapIsThatOfMappedSamples) {
  proof::Family family;
  std::uint64_t seed = 20;
  for (const Tracker tracker : {Tracker::decomposition, Tracker::delta, Tracker::weighted_delta,
                                Tracker::weighted_decomposition, Tracker::delta_global}) {
    for (const Transmittance t :
         {Transmittance::ratio, Transmittance::analog, Transmittance::residual_ratio}) {
      CloudScene s = cloud_scene();
      s.options.tracker = tracker;
      s.options.transmittance = t;
      s.options.samples = proof::samples(300);
      CloudScene scaled = s;
      scaled.medium.extinction *= 1.75;
      scaled.options.seed = ++seed;
      const Pyramid pyramid = build_pyramid(cloud().grid);
      VolumeOptions o = s.volume_options();
      o.map = shared({.scale = 1.75});
      const Volume a = pvol::make_volume(cloud().grid, pyramid, s.medium.medium(), o);
      const Volume b = make_volume(cloud().grid, pyramid, scaled);
      compare(render({&a, 1}, s).film, render({&b, 1}, scaled).film,
              std::string(name(tracker)) + ", " + name(t), family);
    }
  }
  EXPECT_TRUE(family.passes());
}

TEST(MappedDensity, OpticalDepthIsItsIntegral) {
  // rho falls from 1 to 0 along z over 16 cells; the map cuts below a half and doubles the rest.
  const Field ramp = make_field("ramp", {0, 0, 0}, {24, 24, 18},
                                [](Vec3i p) { return std::clamp(1 - (p.z - 1) / 16.0, 0.0, 1.0); });
  const FieldMap map{.ramp = {{{0, 0}, {0.5f, 0}, {1, 2}}, false}};
  // Along z from 1 to 9: 2 (2 rho - 1), whose mean is 1; half a voxel of a rim of its own before.
  const Volume v = mapped(ramp, map, 0.05);
  const Ray ray{{12.3, 11.7, -50}, {0, 0, 1}};
  // From z = -1 to 0 rho rises from 0 to 1, from 0 to 1 it is 1.
  const double rim = 0.5, full = 2, fall = 8;
  const double expected = std::exp(-0.05 * (rim + full + fall));
  proof::Family family;
  for (const Transmittance t :
       {Transmittance::ratio, Transmittance::analog, Transmittance::residual_ratio}) {
    proof::Moments m;
    Rng rng(proof::seeded(5), std::uint64_t(t), 0);
    for (int i = 0; i < 200'000; ++i) {
      m.add(double(sample_transmittance(v, ray, 1e9, rng, t)));
    }
    family.add(name(t), proof::mean_p_value(m, expected, 1e-6));
  }
  EXPECT_TRUE(family.passes());
}

TEST(MappedDensity, BesideOneWithoutAMap) {
  proof::Family family;
  CloudScene s = cloud_scene();
  s.options.samples = proof::samples(300);
  const Pyramid pyramid = build_pyramid(cloud().grid);
  VolumeOptions o = s.volume_options();
  o.map = shared({.scale = 2});
  CloudScene thin = s;
  thin.medium.extinction *= 0.5;
  const Volume plain = make_volume(cloud().grid, pyramid, s);
  const std::vector<Volume> both{plain,
                                 pvol::make_volume(cloud().grid, pyramid, thin.medium.medium(), o)};
  const std::vector<Volume> twice{plain, plain};
  s.options.seed = 77;
  const RenderResult a = render(both, s);
  s.options.seed = 78;
  compare(a.film, render(twice, s).film, "beside", family);
  EXPECT_TRUE(family.passes());
}

TEST(MappedDensity, MadeEmptyIsNothing) {
  const Volume v = mapped(field("gaussian"), {.scale = 0}, 3);
  EXPECT_TRUE(v.density.octree.empty());
  EXPECT_EQ(density_at(v, {0, 0, 0}), 0);
}

TEST(MappedDensity, RefusesWhatDoesNotGoWithIt) {
  const Field& f = field("gaussian");
  const auto refusal = [&](VolumeOptions o, const FieldMap& map) {
    return error_of([&] { (void)mapped(f, map, 1, o); });
  };
  EXPECT_TRUE(says(refusal({}, {.offset = 0.1}), "density.map_makes_fill"));
  EXPECT_NE(refusal({.homogenise = 0.1}, {.scale = 2}).find("homogenised"), std::string::npos);
  CloudScene s = cloud_scene();
  s.options.tracker = Tracker::regular;
  Volume v = mapped(cloud(), {.scale = 2}, s.medium.extinction);
  EXPECT_TRUE(says(error_of([&] {
                     (void)plan({&v, 1}, s.scene());
                   }),
                   "density.regular_tracking_regular"));
  EXPECT_THROW((void)exact_transmittance(v, {{0, 0, 90}, {0, 0, -1}}, 1e9), Error);
}

}  // namespace mapped_density_test
}  // namespace pvol::test
