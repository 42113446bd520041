// Volumes whose samples stay where the grid has them: all calls and pictures are those of volumes
// with copies, to the last bit.
#include <gtest/gtest.h>

#include <memory>

#include "pvol/error.h"
#include "pvol/math/field_map.h"
#include "pvol/render/render.h"
#include "pvol/render/scene_volume.h"
#include "pvol/trackers.h"
#include "pvol/volume/batch.h"
#include "support/error_of.h"
#include "support/pictures.h"
#include "support/placed_clouds.h"
#include "support/small_cloud.h"

namespace pvol::test {
namespace shared_samples_test {

[[nodiscard]] Volume make(const VoxelGrid& grid, bool share, VolumeOptions o = {}) {
  o.samples = share ? SampleStorage::shared : SampleStorage::copied;
  return make_volume(grid, {.extinction = 5 / 20.0}, o);
}

[[nodiscard]] Ray random_ray(const Volume& v, Rng& rng) {
  const Box& box = v.density.world_box;
  const auto point = [&] {
    return box.lo + box.extent() *
                        Vec3d(double(rng.uniform()), double(rng.uniform()), double(rng.uniform()));
  };
  const Vec3d to = point();
  return {point() * 3.0 - to * 2.0, to - point()};
}

TEST(SharedSamples, GiveWhatCopiesGive) {
  using enum Transmittance;
  for (const Field& f : fields()) {
    for (const LookUp look_up : {LookUp::trilinear, LookUp::nearest}) {
      for (const MicroBoundsUse micro : {MicroBoundsUse::none, MicroBoundsUse::edge_2,
                                         MicroBoundsUse::edge_1, MicroBoundsUse::codes}) {
        SCOPED_TRACE(f.name + ", " + name(look_up) + ", micro-bounds " + name(micro));
        const VolumeOptions o{.look_up = look_up, .micro_bounds = micro};
        const Volume shared = make(f.grid, true, o), copied = make(f.grid, false, o);
        ASSERT_TRUE(shared.density.shares_samples());
        for (std::uint64_t i = 0; i < 60; ++i) {
          Rng aim(4, 5, i), a(6, 7, i), b(6, 7, i);
          const Ray ray = random_ray(copied, aim);
          const Flight x = sample_flight(shared, ray, 1e9, a),
                       y = sample_flight(copied, ray, 1e9, b);
          ASSERT_EQ(x.collided, y.collided);
          ASSERT_EQ(x.t, y.t);
          for (const Transmittance e : {analog, ratio, residual_ratio, regular}) {
            ASSERT_EQ(sample_transmittance(shared, ray, 1e9, a, e),
                      sample_transmittance(copied, ray, 1e9, b, e));
          }
          const Vec3d at = ray.at(double(aim.uniform()));
          ASSERT_EQ(density_at(shared, at), density_at(copied, at));
        }
      }
    }
  }
}

TEST(SharedSamples, KeepTheirOwnerAndTakeLessMemory) {
  std::weak_ptr<const void> watch;
  Volume v;
  {
    VoxelGrid grid = make_field("kept", {0, 0, 0}, {32, 32, 32}, [](Vec3i p) {
                       return 0.1 + 0.01 * double((p.x * p.y + p.z) % 83);
                     }).grid;
    watch = grid.owner;
    const Volume copied = make(grid, false);
    v = make(grid, true);
    EXPECT_EQ(v.density.shared_bytes(), grid.bricks.size() * 2048);
    EXPECT_EQ(copied.density.shared_bytes(), 0u);
    EXPECT_LT(v.density.value_bytes(), copied.density.value_bytes() * 3 / 4);
  }
  EXPECT_FALSE(watch.expired());
  EXPECT_GT(density_at(v, {16.5, 16.5, 16.5}), 0.09f);
  v = {};
  EXPECT_TRUE(watch.expired());
}

/// Pictures whose collisions codes decide read few samples: they stay where a grid's owner keeps
/// them, unless something else asks for most of them.
TEST(SharedSamples, ArePlainInPicturesByCodes) {
  const auto shares = [](const VoxelGrid& grid, const VolumeOptions& o) {
    const VolumeField f = std::move(make_volume(grid, {.extinction = 1}, o).density);
    EXPECT_EQ(f.codes != nullptr, f.shares_samples());
    return f.shares_samples();
  };
  const VoxelGrid& grid = cloud().grid;
  ASSERT_NE(grid.owner, nullptr);
  EXPECT_TRUE(shares(grid, {.paths = 1}));
  EXPECT_FALSE(shares(grid, {}));
  EXPECT_FALSE(shares(grid, {.micro_bounds = MicroBoundsUse::edge_2, .paths = 1e9}));
  EXPECT_FALSE(shares(grid, {.tracker = Tracker::weighted_delta, .paths = 1e9}));
  EXPECT_FALSE(shares(grid, {.look_up = LookUp::tricubic, .paths = 1e9}));
  EXPECT_FALSE(shares(grid, {.map = std::make_shared<const FieldMap>(), .paths = 1e9}));
  RenderOptions ratio;
  ratio.transmittance = Transmittance::ratio;
  EXPECT_EQ(volume_options(ratio).samples, SampleStorage::copied);
  EXPECT_EQ(volume_options({}).samples, SampleStorage::automatic);
}

TEST(SharedSamples, MakeTheSamePictures) {
  const Pyramid pyramid = build_pyramid(cloud().grid);
  for (const bool guided : {false, true}) {
    CloudScene s = cloud_scene();
    s.options.kernel = KernelKind::scalar;
    s.options.guide = guided ? GuideUse::on : GuideUse::off;
    const auto picture = [&](std::vector<bool> shares) {
      std::vector<Volume> volumes;
      for (const bool share : shares) {
        VolumeOptions o = s.volume_options();
        o.samples = share ? SampleStorage::shared : SampleStorage::copied;
        if (!volumes.empty()) o.object_to_world = translation({18, 3, -2}) * o.object_to_world;
        volumes.push_back(make_volume(cloud().grid, pyramid, s.medium.medium(), o));
      }
      return render(volumes, s.scene()).film;
    };
    EXPECT_TRUE(same_bytes(picture({false}), picture({true})));
    EXPECT_TRUE(same_bytes(picture({false, false}), picture({true, false}))) << "one of two";
    EXPECT_TRUE(same_bytes(picture({false, false}), picture({true, true})));
  }
}

TEST(SharedSamples, GoRayByRay) {
  const Volume v = make(cloud().grid, true);
  const BatchField f(v, KernelKind::automatic);
  EXPECT_EQ(f.kernel(), KernelKind::scalar);
  EXPECT_NE(f.reason().find("shared"), std::string::npos) << f.reason();
  EXPECT_THROW(BatchField(v, KernelKind::avx2), Error);
}

TEST(SharedSamples, AreRefusedWhereTheyDoNotGo) {
  const auto message = [](VolumeOptions o) {
    return error_of([&] { (void)make(cloud().grid, true, o); });
  };
  EXPECT_NE(message({.look_up = LookUp::tricubic}).find("interpolation"), std::string::npos);
  VolumeOptions homogenised;
  homogenised.homogenise = 0.1;
  EXPECT_NE(message(homogenised).find("homogenised"), std::string::npos);
}

TEST(SharedSamples, GoBesideMappedDensities) {
  CloudScene s = cloud_scene();
  s.options.kernel = KernelKind::scalar;
  const Pyramid pyramid = build_pyramid(cloud().grid);
  const auto picture = [&](bool share) {
    VolumeOptions o = s.volume_options();
    o.map = std::make_shared<const FieldMap>();
    std::vector<Volume> both{make_volume(cloud().grid, pyramid, s.medium.medium(), o)};
    o.map = nullptr, o.samples = share ? SampleStorage::shared : SampleStorage::copied;
    o.object_to_world = translation({9, 3, -2}) * o.object_to_world;
    both.push_back(make_volume(cloud().grid, pyramid, s.medium.medium(), o));
    return render(both, s.scene()).film;
  };
  EXPECT_TRUE(same_bytes(picture(false), picture(true)));
}

}  // namespace shared_samples_test
}  // namespace pvol::test
