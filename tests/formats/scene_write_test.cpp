// Scenes as text, and back.
#include <gtest/gtest.h>

#include <algorithm>
#include <random>

#include "pvol/error.h"
#include "pvol/formats/scene_file.h"
#include "support/effort.h"
#include "support/scene_text.h"

namespace pvol::formats {
namespace scene_write_test {

/// Scenes with values of all magnitudes that a scene may hold.
struct RandomScene {
  std::mt19937_64 bits{11};

  double uniform(double lo, double hi) { return std::uniform_real_distribution(lo, hi)(bits); }
  int whole(int lo, int hi) { return std::uniform_int_distribution(lo, hi)(bits); }
  bool coin() { return whole(0, 1) == 1; }
  double magnitude() { return std::exp2(uniform(-40, 40)); }
  double signed_magnitude() { return coin() ? magnitude() : -magnitude(); }
  Vec3d point() { return {signed_magnitude(), signed_magnitude(), signed_magnitude()}; }
  Rgb radiance() { return Rgb(Vec3d{magnitude(), magnitude(), coin() ? magnitude() : 0}); }

  ClearSky clear_sky() {
    ClearSky sky{.turbidity = uniform(1, 20), .ozone = uniform(0, 1000), .sun = coin()};
    if (coin()) sky.elevation = uniform(-90, 90);
    if (coin()) sky.azimuth = uniform(-360, 360);
    if (coin()) {
      sky.elevation = sky.azimuth = std::nullopt;
      sky.date = coin() ? "2024-06-21T14:30:00+02:00" : "1950-01-31T23:59:59.25Z";
      sky.latitude = uniform(-90, 90), sky.longitude = uniform(-180, 180);
    }
    sky.ground = Rgb(Vec3d(uniform(0, 1), uniform(0, 1), 0.5));
    if (coin()) sky.up = {0, 0, 1}, sky.north = {1, uniform(-1, 1), 0};
    return sky;
  }

  Environment environment() {
    switch (whole(0, 3)) {
      case 0:
        return ConstantSky{radiance()};
      case 3:
        return clear_sky();
      case 1:
        return GradientSky{radiance(), radiance(), radiance(), point()};
      default:
        return ImageSky{0,
                        0,
                        {},
                        radiance(),
                        signed_magnitude(),
                        "",
                        {0, 1, 0},
                        coin() ? "sRGB - Texture" : ""};
    }
  }

  Camera camera() {
    const Vec3d position = point(), target = point(), view = normalize(target - position);
    const Vec3d off_axis{view.z, -view.x, view.y};
    const Shutter shutter{uniform(-100, 0), uniform(0, 100)};
    return {position, target, off_axis * magnitude(), uniform(0.1, 179), shutter, uniform(1, 99)};
  }

  VelocityChoice velocity() {
    return {coin() ? "/an other.vdb" : "", coin() ? "wind" : "", uniform(-9, 9)};
  }

  RenderOptions options() {
    RenderOptions o;
    o.width = whole(1, 1 << 20), o.height = whole(1, 1 << 20);
    o.crop_x = whole(0, o.width - 1), o.crop_y = whole(0, o.height - 1);
    o.crop_width = whole(0, o.width - o.crop_x), o.crop_height = whole(0, o.height - o.crop_y);
    o.samples = std::uint32_t(bits() >> 32) | 1u;
    o.first_sample = std::uint32_t(bits() >> 33);
    o.seed = bits() >> 1;
    o.tracker = Tracker(whole(0, 5));
    o.transmittance = Transmittance(whole(0, 4));
    o.micro_bounds = MicroBoundsUse(whole(0, 4));
    o.look_up = LookUp(whole(0, 3));
    o.shells = ShellUse(whole(0, 2));
    o.guide = GuideUse(whole(0, 2));
    if (coin()) o.depth = whole(0, 16);
    if (coin()) o.max_bounces = std::uint32_t(bits() % (kMostBounces + 1));
    o.background = coin();
    for (const AovRow& r : kAovs) {
      if (coin()) o.aovs.add(r.aov);
    }
    if (coin()) o.majorant_scale = uniform(1.0 / 3, 1000);
    if (coin()) o.homogenise = uniform(0, 10);
    o.preview = whole(0, 8);
    o.color_space = ColorSpace(whole(0, 4));
    return o;
  }

  PhaseFunction phase() {
    const auto lobe = [&] { return HenyeyGreenstein(uniform(-0.9999, 0.9999)); };
    switch (whole(0, 5)) {
      case 0:
        return lobe();
      case 1:
        return TwoLobes{lobe(), lobe(), uniform(0, 1)};
      case 2:
        return Rayleigh{};
      case 3:
        return Draine(uniform(-0.9999, 0.9999), uniform(0, kLargestAlpha));
      case 4:
        return Droplets(uniform(1e-3, kLargestDroplet));
    }
    return PhaseTable({{0, magnitude()}, {uniform(1, 179), magnitude()}, {180, magnitude()}});
  }

  Component component(double share) {
    return {share, Rgb(Vec3d{uniform(0, 1), uniform(0, 1), double(whole(0, 1))}), phase(),
            coin() ? Rgb(0.0f) : radiance()};
  }

  FieldMap map() {
    FieldMap m{.scale = uniform(-3, 3), .offset = coin() ? 0 : uniform(-1, 1)};
    if (coin()) m.clamp = {{uniform(-1, 0), uniform(0.5, 2)}};
    if (coin()) m.power = uniform(0.1, 4);
    if (coin()) {
      m.ramp = {{{0, float(uniform(-1, 1))}, {float(uniform(0.5, 1)), 2}}, coin()};
    }
    return m;
  }

  Fire fire() {
    Fire f{.field = coin() ? "flames" : "", .map = map(), .color = radiance()};
    f.intensity = magnitude();
    if (coin()) f.color_by = "a \"b\"";
    if (coin()) {
      f.kelvin = uniform(1, 3000);
      if (coin()) f.kelvin_of_intensity = uniform(1, 3000);
    } else if (coin()) {
      for (Ramp& r : f.colors.channels) r.points = {{0, float(uniform(0, 1))}, {1, 0.25f}};
    }
    return f;
  }

  AlbedoMap albedo_field() {
    AlbedoMap a{.grid = coin() ? "Cd" : ""};
    if (coin()) return a;
    a.map = map();
    for (Ramp& r : a.colors.channels) r.points = {{0, float(uniform(0, 1))}, {1, 0.25f}};
    return a;
  }

  Affine placement() {
    return {{Vec3d{1, uniform(0, 1), 0}, Vec3d{0, 1, uniform(0, 1)}, Vec3d{uniform(0, 1), 0, 1}},
            point()};
  }

  /// By keys or matrices, which differ a frame later or do not.
  MovingPlacement moving() {
    MovingPlacement m;
    const auto fill = [&](Placement& p) {
      if (coin()) p.scale = Vec3d(uniform(0.5, 2), uniform(0.5, 2), 1);
      if (coin()) p.rotate = {{{0, 1, uniform(0, 1)}, uniform(-500, 500)}, {{1, 0, 0}, 5}};
      if (coin()) p.translate = point();
    };
    if (coin()) {
      m.from.matrix = placement();
      m.to.matrix = placement();
      return m;
    }
    fill(m.from);
    m.to = m.from;
    fill(m.to);
    return m;
  }

  SceneVolume volume(const char* file) {
    SceneVolume v{.file = file, .grid = coin() ? "density[1]" : "", .has_extinction = coin()};
    if (coin()) v.velocity = velocity();
    if (v.has_extinction) v.medium.extinction = magnitude();
    v.medium.components = {component(1)};
    for (int n = whole(0, 2); n > 0; --n) {
      v.medium.components.push_back(component(uniform(0, 0.5)));
      v.medium.components.front().share -= v.medium.components.back().share;
    }
    v.object_to_world = placement();
    for (int n = whole(0, 3); n > 1; --n) v.instances.push_back(placement());
    if (coin()) v.moving = moving(), v.object_to_world = v.moving->from.map();
    if (!v.instances.empty() && coin()) {
      v.moving_instances = {moving()};
      v.instances[0] = v.moving_instances[0]->from.map();
    }
    if (coin()) v.density_map = map();
    if (coin()) v.fire = fire();
    v.has_intensity = v.fire && coin();
    if (coin()) v.albedo_field = albedo_field();
    if (v.fire && !v.has_intensity) v.fire->intensity = Fire{}.intensity;
    return v;
  }

  Material finish() {
    return {Rgb(Vec3d{uniform(0, 1), uniform(0, 1), double(whole(0, 1))}), Visibility(whole(0, 2))};
  }

  /// Of every kind some, in the order of kinds.
  std::vector<Surface> surfaces() {
    std::vector<Surface> all;
    for (int n = whole(0, 2); n > 0; --n)
      all.emplace_back(PlaneSurface{point(), point(), finish()});
    if (coin()) all.emplace_back(BallSurface{point(), magnitude(), finish()});
    if (coin()) all.emplace_back(SolidSurface{"/a.toml", nullptr, moving().from, finish()});
    for (int n = whole(0, 2); n > 0; --n) {
      const MovingPlacement way = moving();
      all.emplace_back(MeshSurface{"/a \"b\".obj", nullptr, way.from, finish(),
                                   coin() ? std::optional(way.to) : std::nullopt});
    }
    return all;
  }

  SceneFile operator()() {
    SceneFile file;
    file.volumes = {volume("/a folder/\"quoted\" \\ back\tslash \u00e9.vdb")};
    for (int n = whole(0, 2); n > 0; --n) file.volumes.push_back(volume("/other.vdb"));
    file.has_camera = coin();
    if (file.has_camera) {
      file.scene.camera = camera();
      if (coin()) {
        file.scene.camera.to = {file.scene.camera.position + Vec3d(uniform(0, 1), 0, 0),
                                file.scene.camera.target, file.scene.camera.up};
      }
    } else if (coin()) {  // a frame keeps the rest
      file.scene.camera.shutter = {-0.5, uniform(0, 1)};
      file.scene.camera.fov = 50;
    }
    file.scene.environment = environment();
    if (auto* sky = std::get_if<ImageSky>(&file.scene.environment)) sky->file = "/sky.exr";
    for (int n = whole(0, 3); n > 0; --n) {
      const Sun sun{point(), radiance(), uniform(0, 179)};
      file.scene.lights.emplace_back(sun);
    }
    for (int n = whole(0, 2); n > 0; --n) {
      file.scene.lights.emplace_back(
          PointLight{point(), radiance(), coin() ? "lamps" : "", coin() ? magnitude() : 0});
    }
    if (coin()) {
      file.scene.lights.emplace_back(
          SpotLight{point(), point(), radiance(), uniform(1, 360), uniform(0, 1), ""});
    }
    if (coin()) {
      file.scene.lights.emplace_back(
          AreaLight{point(), point(), {magnitude(), magnitude()}, point(), radiance(), "lamps"});
    }
    file.scene.surfaces = surfaces();
    file.scene.options = options();
    if (coin()) file.density = Quantisation{Precision(whole(0, 3))};
    if (file.density && file.density->precision == Precision::fpn) {
      file.density->tolerance = uniform(kLeastTolerance, kLargestTolerance);
    }
    return file;
  }
};

TEST_F(SceneText, WrittenScenesReadBackEqual) {
  RandomScene random;
  for (int i = 0; i < proof::samples(300); ++i) {
    SceneFile file = random();
    auto& lights = file.scene.lights;
    std::shuffle(lights.begin(), lights.end(), random.bits);
    const std::string text = to_toml(file);
    std::stable_sort(lights.begin(), lights.end(),
                     [](const Light& a, const Light& b) { return a.index() < b.index(); });
    ASSERT_EQ(read(text), file) << text;
    ASSERT_EQ(to_toml(read(text)), to_toml(file));
  }
  SceneFile largest;
  largest.volumes = {{.file = "/a", .has_extinction = true}};
  for (const double extinction : {0.0, 1e17, 1.2345678901234567e20, 1e300, 5e-324}) {
    largest.volumes[0].medium.extinction = extinction;
    EXPECT_EQ(read(to_toml(largest)), largest) << to_toml(largest);
  }
}

TEST(SceneNames, SeedThatTomlCannotHoldIsRefused) {
  SceneFile file{.volumes = {{.file = "/a"}}};
  file.scene.options.seed = ~std::uint64_t{0};
  EXPECT_THROW((void)to_toml(file), Error);
}

}  // namespace scene_write_test
}  // namespace pvol::formats
