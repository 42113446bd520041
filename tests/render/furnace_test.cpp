// The white furnace: what only scatters, in light that is the same from everywhere, is invisible.
// For every sample recipe, near and far, with all trackers and estimators.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <string>
#include <vector>

#include "pvol/bounds/pyramid.h"
#include "pvol/formats/recipe_file.h"
#include "pvol/render/render.h"
#include "support/cloud_scene.h"
#include "support/estimators.h"
#include "support/statistics.h"

namespace pvol {
namespace furnace_test {

using test::CloudScene;

using test::is_slow;
using test::kTrackers;
using test::kTransmittances;
using test::label;

/// A sample's cloud, coarse enough for a test.
struct Cloud {
  std::string name;
  VoxelGrid grid;
  Pyramid pyramid;
};

const std::vector<Cloud>& clouds() {
  static const std::vector<Cloud> all = [] {
    constexpr int kResolution = 48;
    std::vector<std::filesystem::path> files;
    for (const auto& entry : std::filesystem::directory_iterator(PVOL_SAMPLES)) {
      const bool is_toml = entry.path().extension() == ".toml";
      if (is_toml && formats::is_recipe(entry.path())) files.push_back(entry.path());
    }
    std::sort(files.begin(), files.end());
    std::vector<Cloud> list;
    for (const auto& file : files) {
      Recipe recipe = formats::read_recipe(file);
      recipe.voxel = voxel_for(recipe, kResolution);
      VoxelGrid grid = make_grid(recipe);
      Pyramid pyramid = build_pyramid(grid);
      list.push_back({file.stem().string(), std::move(grid), std::move(pyramid)});
    }
    return list;
  }();
  return all;
}

/// The cloud at an optical thickness of 15 across the middle of a homogeneous body of its size.
CloudScene scene_of(const Cloud& cloud, Tracker tracker) {
  const CloudScene unit;
  const Box box = make_volume(cloud.grid, cloud.pyramid, unit).density.world_box;
  CloudScene s;
  s.medium.extinction = 15 / min_component(box.extent());
  s.medium.albedo = Rgb(1.0f);
  s.environment = ConstantSky{Rgb(1.0f)};
  s.options.tracker = tracker;
  s.options.width = s.options.height = 8;
  s.options.samples = 8;
  s.options.threads = 1;
  return s;
}

/// Framed, from so far that a pixel sees all of it, and from the middle.
std::vector<Camera> cameras(const Box& box) {
  const Vec3d middle = (box.lo + box.hi) * 0.5;
  Camera inside;
  inside.position = middle;
  inside.target = middle + Vec3d(1, 0.2, -0.3);
  inside.fov = 90;
  Camera far = frame(box, 1);
  far.position = middle + (far.position - middle) * 1e4;
  far.fov /= 1e4;
  return {frame(box, 1), far, inside};
}

/// Sky light that scattered rays find by themselves has weight 1 along every path: no noise at all.
/// A tracker whose flights carry weights would leave some.
TEST(Furnace, EveryPixelIsTheSky) {
  ASSERT_GE(clouds().size(), 3u);
  std::size_t turn = 0;
  for (const Cloud& cloud : clouds()) {
    ++turn;
    for (const Tracker tracker : kTrackers) {
      ++turn;
      CloudScene s = scene_of(cloud, tracker);
      const Volume volume = make_volume(cloud.grid, cloud.pyramid, s);
      double scattered = 0;
      for (const Camera& camera : cameras(volume.density.world_box)) {
        for (const double g : {-0.9, 0.0, 0.9}) {
          if (!proof::has_turn(++turn)) continue;
          s.camera = camera;
          s.medium.g = g;
          for (const PixelSums& p : render(volume, s).film.pixels) {
            EXPECT_EQ(mean(p), Vec3d(1.0)) << cloud.name << ", " << label(tracker);
            scattered += p.alpha;
          }
        }
      }
      EXPECT_GT(scattered, 500) << cloud.name << ": the cameras miss it";
    }
  }
}

/// Mean of a picture with its variance.
struct Average {
  Vec3d mean, variance;
};
Average average(const Film& film) {
  Average a;
  const double n = double(film.pixels.size());
  for (const PixelSums& p : film.pixels) {
    a.mean += mean(p) / n;
    a.variance += variance_of_mean(p) / (n * n);
  }
  return a;
}

/// A sky that is a picture is met by shadow rays as well: the estimators of transmittance and the
/// weights between the two techniques.
TEST(Furnace, ShadowRaysFindTheSameSky) {
  proof::Family family;
  proof::Moments all;
  for (const Cloud& cloud : clouds()) {
    std::uint64_t turn = 0;
    for (const Tracker tracker : kTrackers) {
      CloudScene s = scene_of(cloud, tracker);
      s.environment = ImageSky{6, 3, std::vector<Rgb>(18, Rgb(1.0f)), Rgb(1.0f), 20};
      const Volume volume = make_volume(cloud.grid, cloud.pyramid, s);
      const std::vector<Camera> views = cameras(volume.density.world_box);
      for (const Transmittance transmittance : kTransmittances) {
        for (const double g : {-0.9, 0.0, 0.9}) {
          s.options.transmittance = transmittance;
          s.options.samples = is_slow(tracker, transmittance) ? 3 : proof::samples(24);
          s.medium.g = g;
          s.camera = views[(turn + turn / 3) % views.size()];
          s.options.seed = ++turn;
          const Average a = average(render(volume, s).film);
          const double deviation = (a.mean.y - 1) / std::sqrt(a.variance.y);
          all.add(deviation);
          family.add(cloud.name + ", " + label(tracker) + ", " + label(transmittance) + ", g " +
                         std::to_string(g),
                     proof::normal_p_value(deviation));
        }
      }
    }
  }
  family.add("all together", proof::normal_p_value(all.mean() * std::sqrt(double(all.count()))));
  EXPECT_TRUE(family.passes());
}

/// With absorption every pixel that sees the cloud lies between darkness and the sky, and the less
/// a channel absorbs the brighter is the picture, and no pixel darker. Rays that miss see the sky
/// itself.
TEST(Furnace, AbsorptionDarkensByChannel) {
  std::size_t turn = 0;
  for (const Cloud& cloud : clouds()) {
    for (const Tracker tracker : kTrackers) {
      CloudScene s = scene_of(cloud, tracker);
      s.medium.albedo = Rgb(0.9f, 0.99f, 0.6f);
      s.options.samples = 16;
      const Volume volume = make_volume(cloud.grid, cloud.pyramid, s);
      for (const Camera& camera : cameras(volume.density.world_box)) {
        if (!proof::has_turn(turn++)) continue;
        s.camera = camera;
        Vec3d sum;
        for (const PixelSums& p : render(volume, s).film.pixels) {
          const Vec3d m = mean(p);
          sum += m;
          if (p.alpha == 0) {
            EXPECT_EQ(m, Vec3d(1.0));
          } else {
            EXPECT_GT(m.z, 0);
            EXPECT_LE(m.z, m.x);  // the same where a path ended with all its light
            EXPECT_LE(m.x, m.y);
            EXPECT_LT(m.y, 1);
          }
        }
        EXPECT_LT(sum.z, sum.x);
        EXPECT_LT(sum.x, sum.y);
      }
    }
  }
}

}  // namespace furnace_test
}  // namespace pvol
