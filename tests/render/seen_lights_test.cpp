// Lights that the camera sees through volumes: transmittances by series, and pictures of them.
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <numbers>

#include "pvol/render/lights.h"
#include "pvol/render/sky_picture.h"
#include "render/path/transmittance_series.h"
#include "render/scene/projection.h"
#include "support/bodies.h"
#include "support/moving_places.h"
#include "support/oracle.h"
#include "support/pictures.h"
#include "support/small_cloud.h"

namespace pvol::test {
namespace seen_lights_test {

/// Of depths that are uniform about tau, and have no other relation to the pivot.
proof::Moments transmittances(double tau, double wide, int count) {
  Rng rng(proof::seeded(7), std::uint64_t(tau * 1000), std::uint64_t(wide * 1000));
  const auto depth = [&] { return Rgb(float(tau + wide * (2 * double(rng.uniform()) - 1))); };
  proof::Moments m;
  for (int k = 0; k < count; ++k) {
    const Rgb pivot = depth();
    m.add(double(detail::transmittance_around(pivot, depth, rng).y));
  }
  return m;
}

TEST(TransmittanceSeries, IsRightOnAverage) {
  proof::Family family;
  for (const double tau : {0.0, 0.2, 1.0, 5.0, 12.0}) {
    for (const double wide : {0.05, 0.5, 2.0}) {
      const proof::Moments m = transmittances(tau, wide, int(proof::samples(400'000)));
      const double expected = std::exp(-tau);
      family.add("depth " + std::to_string(tau) + ", off by up to " + std::to_string(wide),
                 proof::mean_p_value(m, expected, 1e-6 * expected));
      if (wide < 1) {
        EXPECT_LT(std::sqrt(m.variance_of_mean()), 1.5e-3 * expected);
      }
      // A uniform law of half width w varies by w^2 / 3; the pivot and the first depth count once.
      if (wide < 0.1) {
        EXPECT_NEAR(m.variance() / (expected * expected), wide * wide / 3, 2e-4);
      }
    }
  }
  EXPECT_TRUE(family.passes());
}

TEST(TransmittanceSeries, OfExactDepthsIsExact) {
  Rng rng(1, 2, 3);
  const Rgb tau(0.0f, 0.7f, 30.0f);
  int asked = 0;
  const auto depth = [&] {
    ++asked;
    return tau;
  };
  const Rgb t = detail::transmittance_around(tau, depth, rng);
  for (int c = 0; c < 3; ++c) EXPECT_EQ(t[c], float(std::exp(-double(tau[c]))));
  EXPECT_EQ(asked, 1);
}

TEST(TransmittanceSeries, OfDepthsFarApartIsFinite) {
  Rng rng(1, 2, 3);
  int asked = 0;
  const auto depth = [&] { return Rgb(asked++ % 2 == 0 ? 10.0f : 90.0f); };
  for (const float pivot : {10.0f, 50.0f, 90.0f}) {
    EXPECT_TRUE(is_finite(detail::transmittance_around(Rgb(pivot), depth, rng))) << pivot;
  }
}

constexpr double kPi = std::numbers::pi;

/// A light behind the small cloud that fills the picture, and what the camera would see of it.
struct Behind {
  std::string name;
  std::function<void(CloudScene&)> add;
};

constexpr float kRadiance = 2;
const Rgb kColor{1.0f, 0.7f, 0.4f};

/// The pixels of a sky within so many degrees of -z are bright.
ImageSky sky_with_spot(double degrees) {
  ImageSky sky{32, 16, std::vector<Rgb>(512, Rgb(0.01f))};
  const SkyPicture even(sky, SkyPixels::even);
  for (int y = 0; y < 16; ++y) {
    for (int x = 0; x < 32; ++x) {
      const Vec3d d(even.direction_at((x + 0.5) / 32, (y + 0.5) / 16));
      if (-d.z < std::cos(degrees / 180 * kPi)) continue;
      sky.pixels.edit()[std::size_t(y) * 32 + std::size_t(x)] = kColor * kRadiance;
    }
  }
  return sky;
}

const std::vector<Behind>& behind() {
  static const std::vector<Behind> all{
      {"a ball",
       [](CloudScene& s) {
         PointLight ball;
         ball.position = {0, 0, -700}, ball.radius = 500;
         ball.intensity = kColor * float(double(kRadiance) * kPi * ball.radius * ball.radius);
         s.lights = {ball};
       }},
      {"an area",
       [](CloudScene& s) {
         s.lights = {AreaLight{.position = {0, 0, -100},
                               .direction = {0, 0, 1},
                               .size = {500, 500},
                               .radiance = kColor * kRadiance}};
       }},
      {"a sun",
       [](CloudScene& s) {
         Sun sun{{0, 0, -1}, kColor, 80};
         sun.irradiance =
             kColor * (kRadiance / luminance(SunLight(sun).disc_radiance) * luminance(kColor));
         s.lights = {sun};
       }},
      {"a spot of the sky", [](CloudScene& s) { s.environment = sky_with_spot(30); }},
  };
  return all;
}

/// The cloud, which only absorbs, before one of them.
CloudScene before(const Behind& light, double extinction) {
  CloudScene s = cloud_scene();
  s.environment = ConstantSky{Rgb(0.0f)};
  s.lights.clear();
  s.medium.extinction = extinction;
  s.medium.albedo = Rgb(0.0f);
  s.options.filter = PixelFilter::box;
  s.options.width = s.options.height = 36;
  s.options.samples = 9;
  light.add(s);
  return s;
}

/// What passes through clouds, the mean over a picture's pixels: of it, of its variance in a pixel,
/// and of that of samples which pass or do not.
struct Passed {
  double mean = 0, variance = 0, analog_variance = 0;
};
Passed passed_through(const Field& field, const CloudScene& s, const std::vector<Affine>& to_world,
                      double share = 1) {
  constexpr int kRays = 3;  // across a pixel
  const detail::Projection projection(s.camera, s.options.width, s.options.height);
  const auto transmittance = [&](const Ray& ray) {
    double depth = 0;
    for (const Affine& map : to_world) {
      const Affine to_cloud = inverse(map);
      const Ray own{to_cloud.point(ray.o), to_cloud.vector(ray.d)};
      depth +=
          RayOracle(field, s.options.look_up, own, share * s.medium.extinction).optical_depth();
    }
    return std::exp(-depth);
  };
  Passed sum;
  const int pixels = s.options.width * s.options.height;
  for (int i = 0; i < pixels; ++i) {
    proof::Moments m;
    for (int k = 0; k < kRays * kRays; ++k) {
      m.add(transmittance(projection.ray(i % s.options.width + (k % kRays + 0.5) / kRays,
                                         i / s.options.width + (k / kRays + 0.5) / kRays)));
    }
    sum.mean += m.mean() / pixels;
    sum.variance += m.variance() / pixels;
    sum.analog_variance += m.mean() * (1 - m.mean()) / pixels;
  }
  return sum;
}

/// Adds the comparison of a picture's mean, by channel, with light of this color that passes; and
/// demands that samples vary much less than if each passed or did not.
void expect_passed(const std::vector<Volume>& volumes, CloudScene s,
                   const std::array<Passed, 3>& passed, const std::string& name,
                   proof::Family& family) {
  proof::Moments means[3];
  double variance = 0;
  constexpr int kSeeds = 12;
  for (int seed = 0; seed < kSeeds; ++seed) {
    s.options.seed = 100 + std::uint64_t(seed);
    const Film film = render(volumes, s).film;
    const Average a = average(film);
    for (int c = 0; c < 3; ++c) means[c].add(a.mean[c]);
    for (const PixelSums& p : film.pixels)
      variance += variance_of_mean(p).x * p.samples / double(film.pixels.size() * kSeeds);
  }
  for (int c = 0; c < 3; ++c) {
    const double expected = passed[std::size_t(c)].mean * double(kColor[c]) * double(kRadiance);
    family.add(name + ", channel " + std::to_string(c),
               proof::mean_p_value(means[c], expected, 1e-3 * expected));
    EXPECT_LT(std::sqrt(means[c].variance_of_mean()), 1e-3 * expected) << name;
  }
  const Passed& red = passed[0];
  variance /= double(kRadiance) * double(kRadiance);
  EXPECT_LT(variance, 1.2 * red.variance + 0.2 * red.analog_variance) << name;
}

/// What passes is the same for each light.
Passed passed_at(double extinction, LookUp look_up = LookUp::trilinear) {
  CloudScene s = before(behind().front(), extinction);
  s.options.look_up = look_up;
  return passed_through(cloud(), s, {Affine{}});
}

void expect_passed_by(const Behind& light, double extinction, LookUp look_up, const Passed& p,
                      proof::Family& family) {
  CloudScene s = before(light, extinction);
  s.options.look_up = look_up;
  const Volume v = make_volume(cloud().grid, build_pyramid(cloud().grid, look_up), s);
  expect_passed({v}, s, {p, p, p},
                light.name + " at " + std::to_string(extinction) + " by " + name(look_up), family);
}

TEST(SeenLights, PassAsMuchAsTheOracle) {
  proof::Family family;
  for (const double extinction : {0.05, 0.4, 1.8}) {
    const Passed p = passed_at(extinction);
    for (const Behind& light : behind())
      expect_passed_by(light, extinction, LookUp::trilinear, p, family);
  }
  for (const LookUp look_up : {LookUp::nearest, LookUp::tricubic})
    expect_passed_by(behind().front(), 0.4, look_up, passed_at(0.4, look_up), family);
  EXPECT_TRUE(family.passes());
}

/// Adds the comparison of a channel of pictures of a volume with what is expected.
void expect_mean(const Volume& v, CloudScene s, int channel, double expected, double rounding,
                 const std::string& name, proof::Family& family) {
  proof::Moments mean;
  for (int seed = 0; seed < 8; ++seed) {
    s.options.seed = 100 + std::uint64_t(seed);
    mean.add(average(render(std::span<const Volume>(&v, 1), s).film).mean[channel]);
  }
  family.add(name, proof::mean_p_value(mean, expected, rounding * expected));
  EXPECT_LT(std::sqrt(mean.variance_of_mean()), 1e-3 * expected) << name;
}

/// Beside a light that the camera does not see, and which nothing scatters, others are faint: most
/// samples leave them out.
TEST(SeenLights, ThatAreFaintPassAsMuch) {
  proof::Family family;
  const Passed p = passed_at(0.4);
  for (const Behind& light : behind()) {
    CloudScene s = before(light, 0.4);
    s.lights.push_back(Sun{{0, 1, 0}, Rgb(200.0f), 0});
    s.options.samples = proof::samples(400);
    const Volume v = make_volume(cloud().grid, build_pyramid(cloud().grid), s);
    expect_mean(v, s, 0, p.mean * double(kRadiance), 1e-3, light.name, family);
  }
  EXPECT_TRUE(family.passes());
}

TEST(SeenLights, PassSeveralVolumesChannelByChannel) {
  proof::Family family;
  const Affine beside = translation({3, 1, -8});
  const Rgb shares{1.0f, 0.5f, 0.2f};
  std::array<Passed, 3> colored;
  for (int c = 0; c < 3; ++c) {
    colored[std::size_t(c)] = passed_through(cloud(), before(behind().front(), 0.3),
                                             {Affine{}, beside}, double(shares[c]));
  }
  const Passed& grey = colored[0];
  for (const Behind& light : behind()) {
    CloudScene s = before(light, 0.3);
    const Pyramid pyramid = build_pyramid(cloud().grid, s.options.look_up);
    std::vector<Volume> volumes{make_volume(cloud().grid, pyramid, s)};
    s.medium.object_to_world = beside;
    volumes.push_back(make_volume(cloud().grid, pyramid, s));
    expect_passed(volumes, s, {grey, grey, grey}, light.name + " behind two", family);
    for (Volume& v : volumes) v.medium.extinction_color = shares;
    expect_passed(volumes, s, colored, light.name + " behind two of a colour", family);
  }
  EXPECT_TRUE(family.passes());
}

/// Samples of which most lie below half a step of their bricks' codes, which are 0 there: depths
/// must not be those of codes.
const Field& coarse() {
  static const Field f = make_field("coarse", {-12, -12, -12}, {24, 24, 24}, [](Vec3i p) {
    const int number = (p.x & 7) * 64 + (p.y & 7) * 8 + (p.z & 7);
    return number == 219 ? 1.0 : number == 73 ? 0.0 : 0.0017;
  });
  return f;
}

TEST(SeenLights, PassCoarseCodesAsMuchAsSamples) {
  proof::Family family;
  for (const SampleStorage storage : {SampleStorage::shared, SampleStorage::copied}) {
    CloudScene s = before(behind().front(), 1.9);
    const Passed p = passed_through(coarse(), s, {Affine{}});
    VolumeOptions o = s.volume_options();
    o.samples = storage;
    const Volume v =
        pvol::make_volume(coarse().grid, build_pyramid(coarse().grid), s.medium.medium(), o);
    expect_passed({v}, s, {p, p, p},
                  storage == SampleStorage::shared ? "shared samples" : "copied samples", family);
  }
  EXPECT_TRUE(family.passes());
}

/// As it passes by while the shutter is open.
TEST(SeenLights, PassWhatMovesAsMuchAsWhatStands) {
  proof::Family family;
  const Vec3d by{6, -3, 4};
  constexpr int kTimes = 16;
  double expected = 0;
  for (int k = 0; k < kTimes; ++k) {
    const Affine place = translation(by * ((k + 0.5) / kTimes));
    const Passed p = passed_through(cloud(), before(behind().front(), 0.4), {place});
    expected += p.mean / kTimes * double(kRadiance);
  }
  for (const Behind& light : behind()) {
    CloudScene s = before(light, 0.4);
    s.camera.shutter = {0, 1};
    const std::vector<MovingPlace> places = alone(between(Placement{}, moved(by)));
    const Volume v = moving(cloud(), s, places);
    s.options.samples = proof::samples(64);
    expect_mean(v, s, 0, expected, 1e-3, light.name, family);
  }
  EXPECT_TRUE(family.passes());
}

/// Guided paths have a constant taken off the sky, of which a bright place of one colour has less
/// than nothing in the others.
TEST(SeenLights, OfOneColourAreTheSameIfPathsAreGuided) {
  CloudScene s = before(behind().back(), 0.6);
  auto& sky = std::get<ImageSky>(s.environment);
  for (Rgb& pixel : sky.pixels.edit()) {
    pixel = luminance(pixel) > 1 ? Rgb(60.0f, 0.0f, 0.0f) : Rgb(0.3f, 0.3f, 0.6f);
  }
  s.medium.albedo = Rgb(0.6f);
  s.options.samples = proof::samples(100);
  Volume v = make_volume(cloud().grid, build_pyramid(cloud().grid), s);
  v.medium.extinction_color = {1.0f, 0.3f, 0.1f};
  s.options.guide = GuideUse::off;
  const Film plain = render(std::span<const Volume>(&v, 1), s).film;
  s.options.guide = GuideUse::on;
  s.options.seed = 2;
  const Film guided = render(std::span<const Volume>(&v, 1), s).film;
  proof::Family family;
  compare(average(plain), average(guided), "guided and plain", family);
  EXPECT_TRUE(family.passes());
}

/// Clouds of cells so dense that lines would take very many points.
TEST(SeenLights, PassOpaqueCellsByFlights) {
  proof::Family family;
  const double expected = passed_at(40).mean * double(kRadiance) * double(kColor.y);
  for (const Behind& light : behind()) {
    CloudScene s = before(light, 40);
    s.options.samples = proof::samples(400);
    const Volume v = make_volume(cloud().grid, build_pyramid(cloud().grid), s);
    expect_mean(v, s, 1, expected, 2e-3, light.name, family);
  }
  EXPECT_TRUE(family.passes());
}

/// Of one scene among surfaces: its mean over that without.
double share_seen(CloudScene s, const PlaneSurface& plane) {
  const Volume v = make_volume(cloud().grid, build_pyramid(cloud().grid, s.options.look_up), s);
  const double open = average(render({&v, 1}, s).film).mean.x;
  s.surfaces = {plane};
  return average(render({&v, 1}, s).film).mean.x / open;
}

TEST(SeenLights, HideBehindSurfaces) {
  for (const Behind& light : behind()) {
    const CloudScene s = before(light, 0.4);
    const Material black{.albedo = Rgb(0.0f)};
    EXPECT_EQ(share_seen(s, {{0, 0, -40}, {0, 0, 1}, black}), 0) << light.name;
    Material unseen = black;
    unseen.visible_camera = false;
    EXPECT_EQ(share_seen(s, {{0, 0, -40}, {0, 0, 1}, unseen}), 1) << light.name;
    const bool nearer = light.name == "an area" || light.name == "a ball";
    EXPECT_EQ(share_seen(s, {{0, 0, -1e4}, {0, 0, 1}, black}), nearer ? 1 : 0) << light.name;
    if (light.name != "an area") continue;
    EXPECT_EQ(share_seen(s, {{0, 0, -100}, {0, 0, 1}, black}), 1) << "which it lies on";
  }
}

TEST(SeenLights, AreInTheLayersOfTheirLights) {
  for (const Behind& light : behind()) {
    CloudScene s = before(light, 0.4);
    s.options.aovs = {Aov::lights, Aov::scattering};
    const Volume v = make_volume(cloud().grid, build_pyramid(cloud().grid, s.options.look_up), s);
    const Film film = render({&v, 1}, s).film;
    Vec3d own, unscattered, all;
    for (const PixelSums& p : film.pixels) all += p.sum;
    for (const Layer& l : film.layers) {
      for (const Vec3d& sum : l.sums) {
        if (l.name == "unscattered") unscattered += sum;
        if (l.name == (s.lights.empty() ? "sky" : "point_1") || l.name == "area_1" ||
            l.name == "sun_1")
          own += sum;
      }
    }
    EXPECT_GT(all.x, 0) << light.name;
    EXPECT_NEAR(own.x / all.x, 1, 1e-6) << light.name;
    EXPECT_NEAR(unscattered.x / all.x, 1, 1e-6) << light.name;
  }
}

/// What is behind a cloud is not in its samples, however it is found.
TEST(SeenLights, AreNotInDeepPictures) {
  for (const Behind& light : behind()) {
    if (light.name == "a ball" || light.name == "an area") continue;  // deep pictures refuse them
    CloudScene s = before(light, 0.4);
    s.options.deep = true;
    const Volume v = make_volume(cloud().grid, build_pyramid(cloud().grid, s.options.look_up), s);
    const Film film = render({&v, 1}, s).film;
    std::uint64_t count = 0;
    for (const auto& bins : film.deep.pixels) {
      for (const DeepBin& b : bins) {
        count += b.count;
        EXPECT_EQ(b.sum, Vec3d()) << light.name;
      }
    }
    EXPECT_GT(count, 0u) << light.name;
    EXPECT_GT(average(film).mean.x, 0) << light.name << ": the picture itself has a background";
    s.options.deep = false, s.options.background = false;
    EXPECT_EQ(average(render({&v, 1}, s).film).mean.x, 0) << light.name;
  }
}

}  // namespace seen_lights_test
}  // namespace pvol::test
