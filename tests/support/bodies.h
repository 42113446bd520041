// Homogeneous cubes whose pictures are integrals along one ray, for tests of media and estimators.
#pragma once

#include <algorithm>
#include <cmath>
#include <numbers>
#include <span>
#include <string>
#include <vector>

#include "pvol/bounds/pyramid.h"
#include "pvol/math/box.h"
#include "pvol/render/render.h"
#include "support/cloud_scene.h"
#include "support/fields.h"
#include "support/pictures.h"

namespace pvol::test {

/// With the nearest interpolation, density 1 in [-0.5, 12.5]^3: the faces lie amid leaves.
inline const Field& cube() {
  static const Field f = make_field("cube", {0, 0, 0}, {13, 13, 13}, [](Vec3i) { return 1.0; });
  return f;
}
inline const Box kCube{Vec3d(-0.5), Vec3d(12.5)};

/// A medium of one component.
[[nodiscard]] inline Body component(double extinction, Rgb albedo, double g, Rgb emission = {},
                                    const Affine& place = {}) {
  return {extinction, albedo, g, emission, {}, place};
}

/// The field filled with each of the media, ready for the scene's options.
[[nodiscard]] inline std::vector<Volume> make_volumes(const Field& field,
                                                      std::span<const Body> media,
                                                      CloudScene scene) {
  const Pyramid pyramid = build_pyramid(field.grid);
  std::vector<Volume> volumes;
  for (const Body& m : media) {
    scene.medium = m;
    volumes.push_back(make_volume(field.grid, pyramid, scene));
  }
  return volumes;
}

/// One pixel, so small that its rays are one, in which cubes of these media lie before a sky.
struct OneRay {
  std::vector<Body> bodies;
  CloudScene scene;
  Ray ray;

  OneRay(std::vector<Body> media, Vec3d from, Vec3d to) : bodies(std::move(media)) {
    scene.camera.position = from;
    scene.camera.target = to;
    scene.camera.fov = 1e-4;
    scene.environment = ConstantSky{Rgb(0.0f)};
    scene.medium = bodies.front();
    scene.options.width = scene.options.height = 1;
    scene.options.samples = 20'000;
    scene.options.max_bounces = 1;
    scene.options.look_up = LookUp::nearest;
    scene.options.threads = 1;
    ray = {from, normalize(to - from)};
  }
};

/// The part of a ray, up to a distance, in a body.
[[nodiscard]] inline std::optional<Span> inside(const Body& body, const Ray& ray,
                                                double distance = 1e9) {
  const Affine back = inverse(body.object_to_world);
  return intersect(kCube, {back.point(ray.o), back.vector(ray.d)}, 0, distance);
}

[[nodiscard]] inline double optical_depth(std::span<const Body> bodies, const Ray& ray,
                                          double distance = 1e9) {
  double sum = 0;
  for (const Body& body : bodies) {
    if (const auto s = inside(body, ray, distance)) sum += body.extinction * (s->t1 - s->t0);
  }
  return sum;
}

[[nodiscard]] inline double phase(double g, double cosine) {
  return (1 - g * g) / (4 * std::numbers::pi * std::pow(1 + g * g - 2 * g * cosine, 1.5));
}

/// Light from one direction as it arrives at a place in the absence of any medium: of a delta sun,
/// a point or a spot, or one of many pieces of a ball or an area.
struct Arriving {
  Vec3d towards;  ///< the light
  double distance;
  Vec3d irradiance;
};
inline void add_arriving(const Sun& sun, Vec3d, std::vector<Arriving>& all) {
  all.push_back({normalize(sun.direction), 1e9, Vec3d(sun.irradiance)});
}
[[nodiscard]] inline Arriving from_point(Vec3d way, Vec3d intensity) {
  return {normalize(way), length(way), intensity / dot(way, way)};
}
/// Steps along either axis of what a light is divided into.
inline constexpr int kLightSteps = 16;

inline void add_arriving(const PointLight& light, Vec3d place, std::vector<Arriving>& all) {
  const Vec3d way = light.position - place, intensity(light.intensity);
  const double r = light.radius, pi = std::numbers::pi;
  if (r == 0) return all.push_back(from_point(way, intensity));
  // Pieces of the cap in which the ball lies, of equal solid angles.
  const double d = length(way), cap = 1 - std::sqrt(1 - r * r / (d * d));
  const Vec3d axis = way / d;
  Vec3d s, t;
  orthonormal_basis(axis, s, t);
  for (int i = 0; i < kLightSteps * kLightSteps; ++i) {
    const double c = 1 - cap * (i / kLightSteps + 0.5) / kLightSteps;
    const double azimuth = 2 * pi * (i % kLightSteps + 0.5) / kLightSteps,
                 sine = std::sqrt(1 - c * c);
    const Vec3d to = axis * c + (s * std::cos(azimuth) + t * std::sin(azimuth)) * sine;
    const double near = d * c - std::sqrt(std::max(0.0, r * r - d * d * sine * sine));
    all.push_back(
        {to, near, intensity / (pi * r * r) * (2 * pi * cap / (kLightSteps * kLightSteps))});
  }
}
[[nodiscard]] inline Arriving from_spot(const SpotLight& light, Vec3d place) {
  const Vec3d way = light.position - place;
  const double degrees = std::numbers::pi / 180;
  const double cosine = -dot(normalize(way), normalize(light.direction));
  const double rim = std::cos(light.angle / 2 * degrees);
  const double full = std::cos(light.angle / 2 * (1 - light.blend) * degrees);
  const double x = std::clamp((cosine - rim) / (full - rim), 0.0, 1.0);
  return from_point(way, Vec3d(light.intensity) * (x * x * (3 - 2 * x)));
}
inline void add_arriving(const SpotLight& light, Vec3d place, std::vector<Arriving>& all) {
  all.push_back(from_spot(light, place));
}
/// The sides of an area, and its normal.
struct Sides {
  Vec3d across, up, normal;
};
[[nodiscard]] inline Sides sides_of(const AreaLight& light) {
  const Vec3d normal = normalize(light.direction), across = normalize(cross(light.up, normal));
  return {across * light.size[0], cross(normal, across) * light.size[1], normal};
}
inline void add_arriving(const AreaLight& light, Vec3d place, std::vector<Arriving>& all) {
  const auto [across, up, normal] = sides_of(light);
  for (int i = 0; i < kLightSteps * kLightSteps; ++i) {
    const double u = (i / kLightSteps + 0.5) / kLightSteps - 0.5;
    const double v = (i % kLightSteps + 0.5) / kLightSteps - 0.5;
    const Vec3d way = light.position + across * u + up * v - place;
    const double cosine = -dot(normalize(way), normal);
    if (cosine <= 0) continue;
    const double area = light.size[0] * light.size[1] / (kLightSteps * kLightSteps);
    all.push_back(from_point(way, Vec3d(light.radiance) * (area * cosine)));
  }
}
[[nodiscard]] inline std::vector<Arriving> arriving(const CloudScene& scene, Vec3d place) {
  std::vector<Arriving> all;
  if (scene.options.max_bounces == 0u) return all;
  for (const Light& light : scene.lights) {
    std::visit([&](const auto& l) { add_arriving(l, place, all); }, light);
  }
  return all;
}

/// What collisions in a body send back along a ray, for each of them: the scattered light of each
/// light, and emission as the last.
[[nodiscard]] inline std::vector<Vec3d> sources(const Medium& medium, Vec3d ray,
                                                std::span<const Arriving> lights) {
  std::vector<Vec3d> all(lights.size() + 1);
  for (const Component& c : medium.components) {
    const Vec3d albedo(c.albedo);
    all.back() += (Vec3d(1.0) - albedo) * Vec3d(c.emission) * c.share;
    for (std::size_t i = 0; i < lights.size(); ++i) {
      const double p = phase(mean_cosine(c.phase), dot(ray, lights[i].towards));
      all[i] += albedo * lights[i].irradiance * (c.share * p);
    }
  }
  return all;
}

/// The radiance of the pixel: sky behind, emission and single scattering, with the light in the
/// middle of each step. Not for emission and scattering together, where light that was scattered
/// once is emitted, too.
[[nodiscard]] inline Vec3d radiance(const OneRay& r) {
  std::vector<double> ends;
  for (const Body& body : r.bodies) {
    if (const auto s = inside(body, r.ray)) ends.insert(ends.end(), {s->t0, s->t1});
  }
  std::sort(ends.begin(), ends.end());
  Vec3d sum;
  double depth = 0;
  for (std::size_t i = 1; i < ends.size(); ++i) {
    const double middle = 0.5 * (ends[i - 1] + ends[i]);
    double mu = 0;
    std::vector<Medium> media;  // of bodies that are here
    for (const Body& body : r.bodies) {
      const auto s = inside(body, r.ray);
      if (!s || middle < s->t0 || middle > s->t1) continue;
      mu += body.extinction;
      media.push_back(body.medium());
    }
    constexpr int kSteps = 1000;
    const double dt = (ends[i] - ends[i - 1]) / kSteps;
    const double met = mu > 0 ? -std::expm1(-mu * dt) / mu : dt;  // int exp(-mu t) of a step
    for (int k = 0; k < kSteps; ++k, depth += mu * dt) {
      const Vec3d p = r.ray.at(ends[i - 1] + (k + 0.5) * dt);
      const std::vector<Arriving> lights = arriving(r.scene, p);
      std::vector<double> seen;  // of each light, and of emission
      for (const Arriving& l : lights) {
        seen.push_back(std::exp(-optical_depth(r.bodies, {p, l.towards}, l.distance)));
      }
      seen.push_back(1);
      for (const Medium& medium : media) {
        const std::vector<Vec3d> source = sources(medium, r.ray.d, lights);
        for (std::size_t j = 0; j < source.size(); ++j) {
          sum += source[j] * (medium.extinction * seen[j] * std::exp(-depth) * met);
        }
      }
    }
  }
  return sum + Vec3d(std::get<ConstantSky>(r.scene.environment).radiance) * std::exp(-depth);
}

/// Adds the test of a rendered pixel against its radiance; returns its excess as for averages.
inline double compare(const Film& film, const Vec3d& expected, const std::string& name,
                      proof::Family& family) {
  constexpr double kRoundingOfMeans =
      2e-5;  // of float directions, the pixel's extent and the integral
  return compare(average(film), {expected, Vec3d(0.0)}, name, family,
                 kRoundingOfMeans * min_component(expected));
}
inline double compare(const OneRay& r, const Film& film, const std::string& name,
                      proof::Family& family) {
  return compare(film, radiance(r), name, family);
}
inline double compare(const OneRay& r, const std::string& name, proof::Family& family) {
  return compare(r, render(make_volumes(cube(), r.bodies, r.scene), r.scene).film, name, family);
}

}  // namespace pvol::test
