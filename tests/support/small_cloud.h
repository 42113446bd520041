// A small cloud, a cube and their pictures, for tests of whole renders.
#pragma once

#include <string>

#include "pvol/bounds/pyramid.h"
#include "support/cloud_scene.h"
#include "support/fields.h"

namespace pvol::test {

/// A blob of 20 voxels across with values between 0.05 and 1, in front of the camera.
inline const Field& cloud() {
  static const Field f = make_field("cloud", {-12, -12, -12}, {24, 24, 24}, [](Vec3i p) {
    const double r2 = dot(Vec3d(p), Vec3d(p)) / 100;
    const bool hole = (p.x >> 2 ^ p.y >> 2 ^ p.z >> 2) & 1;
    return r2 > 1 ? 0.0 : (hole ? 0.05 : 1.0) * (1 - 0.5 * r2);
  });
  return f;
}

/// 16^3 samples of density 1: with the nearest interpolation, a cube [-0.5, 15.5]^3 of mu =
/// extinction.
inline const Field& cube_of_leaves() {
  static const Field f = make_field("cube", {0, 0, 0}, {16, 16, 16}, [](Vec3i) { return 1.0; });
  return f;
}

/// The cloud under one sun, in few pixels.
inline CloudScene cloud_scene() {
  CloudScene s;
  s.camera.position = {5, 8, 60};
  s.camera.target = {0, 0, 0};
  s.camera.fov = 24;
  s.medium.extinction = 0.6;
  s.medium.albedo = Rgb(0.9f, 0.95f, 0.99f);
  s.medium.g = 0.7;
  s.lights = {Sun{{0.6, 0.8, 0.35}, Rgb(3.0f), 0}};
  s.options.width = 12;
  s.options.height = 12;
  s.options.samples = 64;
  s.options.threads = 2;
  return s;
}

inline RenderResult run(const Field& field, const CloudScene& scene) {
  return render(make_volume(field.grid, build_pyramid(field.grid), scene), scene);
}

}  // namespace pvol::test
