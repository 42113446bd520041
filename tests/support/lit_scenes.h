// A cloud in every kind of light.
#pragma once

#include <algorithm>
#include <cmath>
#include <functional>
#include <string>
#include <vector>

#include "support/bodies.h"
#include "support/cloud_scene.h"

namespace pvol::test {

/// A body of density 1 with soft, uneven edges, some cells across.
inline const Field& puff() {
  static const Field f = make_field("puff", {0, 0, 0}, {40, 32, 36}, [](Vec3i p) {
    const Vec3d d = (Vec3d(p) - Vec3d(20, 16, 18)) * 0.065;
    const double bumps = 0.15 * std::sin(0.9 * p.x) * std::sin(0.7 * p.y + 1) * std::sin(0.8 * p.z);
    return std::clamp(3 * (1 - dot(d, d) + bumps), 0.0, 1.0);
  });
  return f;
}

/// The puff in the sun, before a constant sky; its optical thickness is about 12.
inline CloudScene sunny() {
  CloudScene s;
  s.medium = component(0.4, Rgb(0.999f), 0.877);
  s.environment = ConstantSky{Rgb(0.5f)};
  s.lights = {Sun{{0.6, 0.8, 0.35}, Rgb(3.0f), 0}};
  s.options.width = s.options.height = 16;
  s.options.samples = 100;
  s.options.threads = 1;
  s.options.guide = GuideUse::on;
  return s;
}

inline Volume volume_of(CloudScene& s) {
  Volume v = make_volumes(puff(), std::vector{s.medium}, s).front();
  if (s.camera == Camera{}) s.camera = frame(v.density.world_box, 1);
  return v;
}

/// A scene by its name.
struct Case {
  std::string name;
  CloudScene scene;
};

/// Each has something that the others lack.
inline std::vector<Case> cases() {
  std::vector<Case> all;
  const auto add = [&](const std::string& name, const std::function<void(CloudScene&)>& change) {
    CloudScene s = sunny();
    change(s);
    all.push_back({name, s});
  };
  add("forward", [](CloudScene&) {});
  add("isotropic", [](CloudScene& s) { s.medium.g = 0; });
  add("backward", [](CloudScene& s) { s.medium.g = -0.5; });
  add("coloured", [](CloudScene& s) { s.medium.albedo = Rgb(0.9f, 0.97f, 0.6f); });
  add("two components", [](CloudScene& s) {
    s.medium.others = {{0.4, Rgb(0.7f, 0.8f, 0.9f), HenyeyGreenstein(-0.2), Rgb(0.0f)}};
  });
  add("droplets in air", [](CloudScene& s) {
    s.medium.others = {{0.7, Rgb(0.999f), Droplets(20), Rgb(0.0f)},
                       {0.299, Rgb(0.7f, 0.8f, 0.95f), Rayleigh{}, Rgb(0.0f)}};
  });
  add("table", [](CloudScene& s) {
    const PhaseTable bow({{0, 900}, {1, 90}, {10, 2}, {90, 0}, {120, 0}, {140, 0.3}, {180, 0.1}});
    s.medium.others = {{0.999, Rgb(0.99f), bow, Rgb(0.0f)}};
  });
  add("emission", [](CloudScene& s) {
    s.medium.albedo = Rgb(0.8f);
    s.medium.emission = Rgb(2.0f, 1.0f, 0.2f);
  });
  add("emission alone", [](CloudScene& s) {
    s.medium.albedo = Rgb(0.95f);
    s.medium.emission = Rgb(2.0f, 1.0f, 0.2f);
    s.lights.clear();
  });
  add("sun disc", [](CloudScene& s) { std::get<Sun>(s.lights.front()).angle = 20; });
  add("two suns", [](CloudScene& s) {
    s.lights.emplace_back(Sun{{-1, 0.2, 0.1}, Rgb(2.0f, 1.0f, 0.5f), 5});
  });
  add("point light", [](CloudScene& s) {
    s.lights = {PointLight{{60, 30, 40}, Rgb(6e3f, 3e3f, 5e3f)}};
  });
  add("point light behind, and a sun", [](CloudScene& s) {
    s.lights.emplace_back(PointLight{{-10, 16, -15}, Rgb(2e3f)});
  });
  add("gradient", [](CloudScene& s) { s.environment = GradientSky{}; });
  add("picture with a sun", [](CloudScene& s) {
    ImageSky sky{16, 8, std::vector<Rgb>(128, Rgb(0.4f, 0.5f, 0.6f)), Rgb(1.0f), 30};
    sky.pixels.edit()[20] = Rgb(40.0f, 35.0f, 30.0f);
    for (std::size_t i = 64; i < 128; ++i) sky.pixels.edit()[i] = Rgb(0.0f);
    s.environment = sky;
    s.lights.clear();
  });
  add("clear sky", [](CloudScene& s) {
    s.environment = ClearSky{.elevation = 20, .azimuth = 70, .turbidity = 4};
    s.lights.clear();
  });
  add("thin", [](CloudScene& s) { s.medium.extinction = 0.01; });
  add("inside", [](CloudScene& s) {
    s.camera.position = {20, 16, 18};
    s.camera.target = {26, 21, 20};
    s.camera.fov = 90;
  });
  add("no background", [](CloudScene& s) {
    s.options.background = false;
    s.medium.albedo = Rgb(0.9f);
  });
  return all;
}

}  // namespace pvol::test
