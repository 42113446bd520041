// Layers of objects: how much of a pixel shows which volume, place of a volume or surface, against
// closed forms.
#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <string>
#include <vector>

#include "pvol/render/render.h"
#include "support/cloud_scene.h"
#include "support/error_of.h"
#include "support/fields.h"
#include "support/messages.h"

namespace pvol::test {
namespace objects_layer_test {

constexpr int kEdge = 16;  // voxels, and world units

/// A box of density 1 with sharp faces: nearest look-ups of samples from 0 to kEdge - 1.
const Field& box() {
  static const Field f =
      make_field("box", {0, 0, 0}, {kEdge, kEdge, kEdge}, [](Vec3i) { return 1.0; });
  return f;
}

/// The camera looks along -z through the middle of boxes, each with an optical thickness.
CloudScene looking_through() {
  CloudScene s;
  s.environment = ConstantSky{Rgb(1.0f)};
  s.camera.position = {kEdge / 2.0, kEdge / 2.0, 500};
  s.camera.target = {kEdge / 2.0, kEdge / 2.0, 0};
  s.camera.fov = 0.2;
  s.options.width = s.options.height = 8;
  s.options.samples = proof::samples(512);
  s.options.max_bounces = 0;
  s.options.look_up = LookUp::nearest;
  s.options.aovs = {Aov::objects};
  return s;
}

Volume box_at(CloudScene& s, double thickness, double z, Rgb by_channel = Rgb(1.0f)) {
  s.medium.extinction = thickness / kEdge;
  s.medium.object_to_world = translation({0, 0, z});
  Medium medium = s.medium.medium();
  medium.extinction_color = by_channel;
  return pvol::make_volume(box().grid, build_pyramid(box().grid, LookUp::nearest), medium,
                           s.volume_options());
}

/// Means over the picture.
std::map<std::string, double> coverage(const Film& film) {
  std::map<std::string, double> all;
  for (const Layer& layer : film.layers) {
    for (std::size_t i = 0; i < film.pixels.size(); ++i) {
      all[layer.name] += value(layer, film, i).x / double(film.pixels.size());
    }
  }
  return all;
}

/// Four standard errors of a share of all samples.
double tolerance(const Film& film, double share) {
  double samples = 0;
  for (const PixelSums& p : film.pixels) samples += p.samples;
  return 4 * std::sqrt(share * (1 - share) / samples) + 1e-9;
}

double met(double thickness) { return 1 - std::exp(-thickness); }

TEST(ObjectLayers, OfVolumesOneBehindAnotherAreTheirTransmittances) {
  CloudScene s = looking_through();
  const std::vector<Volume> volumes{box_at(s, 0.5, 0), box_at(s, 1.5, 40)};  // the second in front
  const Film film = render(volumes, s).film;
  const auto found = coverage(film);
  ASSERT_EQ(found.size(), 2u);
  const double front = met(1.5), back = std::exp(-1.5) * met(0.5);
  EXPECT_NEAR(found.at("object.volume_2"), front, tolerance(film, front));
  EXPECT_NEAR(found.at("object.volume_1"), back, tolerance(film, back));
}

TEST(ObjectLayers, OfVolumesInOnePlaceAreSharesOfTheirExtinction) {
  CloudScene s = looking_through();
  const std::vector<Volume> volumes{box_at(s, 0.6, 0), box_at(s, 1.2, 0)};
  const Film film = render(volumes, s).film;
  const auto found = coverage(film);
  EXPECT_NEAR(found.at("object.volume_1"), met(1.8) / 3, tolerance(film, met(1.8) / 3));
  EXPECT_NEAR(found.at("object.volume_2"), met(1.8) * 2 / 3, tolerance(film, met(1.8) * 2 / 3));
}

/// Each channel is covered by the volumes' shares of its own extinction.
TEST(ObjectLayers, OfVolumesInOnePlaceAreMeansOverTheChannels) {
  CloudScene s = looking_through();
  s.options.samples = proof::samples(2048);
  const std::vector<Volume> volumes{box_at(s, 0.4, 0), box_at(s, 0.4, 0, Rgb(1.0f, 0.2f, 0.2f))};
  const Film film = render(volumes, s).film;
  const auto found = coverage(film);
  double grey = 0, red = 0;
  for (const double share : {1.0, 0.2, 0.2}) {
    const double all = met(0.4 * (1 + share)) / (1 + share) / 3;
    grey += all, red += share * all;
  }
  EXPECT_NEAR(found.at("object.volume_1"), grey, 2 * tolerance(film, grey));
  EXPECT_NEAR(found.at("object.volume_2"), red, 2 * tolerance(film, red));
}

TEST(ObjectLayers, TellPlacesAndSurfacesApart) {
  CloudScene s = looking_through();
  s.surfaces = {PlaneSurface{.point = {0, 0, -100}, .normal = {0, 0, 1}},
                PlaneSurface{.point = {0, 0, -50}, .normal = {0, 0, 1}}};
  Volume volume = box_at(s, 0.7, 0);
  volume.further_places = {translation({0, 0, 40}), translation({1000, 0, 0})};
  const Film film = render(std::vector{volume}, s).film;
  const auto found = coverage(film);
  ASSERT_EQ(found.size(), 5u);
  const double front = met(0.7), back = std::exp(-0.7) * met(0.7), wall = std::exp(-1.4);
  EXPECT_NEAR(found.at("object.volume_1.2"), front, tolerance(film, front));
  EXPECT_NEAR(found.at("object.volume_1.1"), back, tolerance(film, back));
  EXPECT_EQ(found.at("object.volume_1.3"), 0) << "beside the picture";
  EXPECT_NEAR(found.at("object.plane_2"), wall, tolerance(film, wall));
  EXPECT_EQ(found.at("object.plane_1"), 0) << "behind the other";
  for (std::size_t i = 0; i < film.pixels.size(); ++i) {
    double sum = 0;
    for (const Layer& layer : film.layers) sum += value(layer, film, i).x;
    ASSERT_NEAR(sum, film.pixels[i].alpha / film.pixels[i].samples, 1e-9) << "all that is covered";
  }
}

TEST(ObjectLayers, SurfacesThatTheCameraDoesNotSeeHaveNothing) {
  CloudScene s = looking_through();
  PlaneSurface unseen{.point = {0, 0, -50}, .normal = {0, 0, 1}};
  unseen.material.visible_camera = false;
  s.surfaces = {unseen, PlaneSurface{.point = {0, 0, -100}, .normal = {0, 0, 1}}};
  const Film film = render(std::vector{box_at(s, 0.7, 0)}, s).film;
  const auto found = coverage(film);
  EXPECT_EQ(found.at("object.plane_1"), 0);
  EXPECT_NEAR(found.at("object.plane_2"), std::exp(-0.7), tolerance(film, std::exp(-0.7)));
}

TEST(ObjectLayers, WeightedTrackersAgree) {
  CloudScene s = looking_through();
  s.options.tracker = Tracker::weighted_decomposition;
  const std::vector<Volume> volumes{box_at(s, 0.6, 0), box_at(s, 1.2, 40)};
  const Film film = render(volumes, s).film;
  const auto found = coverage(film);
  EXPECT_NEAR(found.at("object.volume_2"), met(1.2), 2 * tolerance(film, met(1.2)));
  const double back = std::exp(-1.2) * met(0.6);
  EXPECT_NEAR(found.at("object.volume_1"), back, 2 * tolerance(film, back));
}

TEST(ObjectLayers, ChangeNoPicture) {
  CloudScene s = looking_through();
  s.options.max_bounces = std::nullopt;
  s.options.samples = 8;
  const std::vector<Volume> volumes{box_at(s, 0.6, 0), box_at(s, 1.2, 8)};
  const Film with = render(volumes, s).film;
  s.options.aovs = {};
  const Film without = render(volumes, s).film;
  for (std::size_t i = 0; i < with.pixels.size(); ++i) {
    ASSERT_EQ(with.pixels[i].sum, without.pixels[i].sum);
  }
}

TEST(ObjectLayers, OfTooManyObjectsAreRefused) {
  CloudScene s = looking_through();
  Volume volume = box_at(s, 0.7, 0);
  for (int i = 0; i < 64; ++i) volume.further_places.push_back(translation({100.0 * i, 0, 0}));
  EXPECT_TRUE(says(error_of([&] { (void)render(std::vector{volume}, s); }), "plan.many_objects"));
}

}  // namespace objects_layer_test
}  // namespace pvol::test
