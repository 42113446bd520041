// Lights at places in the scene made ready for sampling.
#pragma once

#include "pvol/math/box.h"
#include "pvol/math/rng.h"
#include "pvol/render/area_light.h"
#include "pvol/render/light_sample.h"
#include "pvol/render/point_light.h"
#include "pvol/render/spot_light.h"

namespace pvol {

// Each answers the questions of `SunLight` in lights.h, but for those about what lies infinitely
// far, and is dark beyond what a float holds.

/// A point light.
struct PointSource {
  Vec3d position;
  Rgb intensity;

  template <class Where>
  [[nodiscard]] LightSample sample(const Where& where, Rng&) const {
    return arriving_at(where());
  }
  [[nodiscard]] static Box met_within() { return {}; }
  [[nodiscard]] static LightMet met(const Ray&, double) { return {}; }
  /// That at the centre of the box or, where the light is nearer to it than the corners are, that
  /// at the corners' distance.
  [[nodiscard]] Rgb irradiance_on(const Box& box) const;
  [[nodiscard]] Rgb on_plane(Vec3d place, Vec3d normal) const;
  [[nodiscard]] LightSample arriving_at(Vec3d place) const;
  /// To which all that comes from the light is proportional.
  [[nodiscard]] Rgb color() const { return intensity; }
};

/// A ball that shines outwards; in it it is dark. Sampled evenly over the directions in which it
/// lies.
class BallSource {
 public:
  explicit BallSource(const PointLight& light);

  [[nodiscard]] const PointSource& centre() const { return centre_; }
  [[nodiscard]] Rgb color() const { return centre_.intensity; }
  template <class Where>
  [[nodiscard]] LightSample sample(const Where& where, Rng& rng) const {
    return sample_from(where(), rng);
  }
  [[nodiscard]] Box met_within() const;
  [[nodiscard]] LightMet met(const Ray& ray, double distance) const;
  [[nodiscard]] Rgb irradiance_on(const Box& box) const { return centre_.irradiance_on(box); }
  [[nodiscard]] Rgb on_plane(Vec3d place, Vec3d normal) const;

 private:
  [[nodiscard]] LightSample sample_from(Vec3d place, Rng& rng) const;
  [[nodiscard]] double cap(double distance) const;

  PointSource centre_;
  double radius_;
  Rgb radiance_;
  bool visible_;
};

/// A point light within a cone.
class SpotSource {
 public:
  explicit SpotSource(const SpotLight& light);

  [[nodiscard]] const PointSource& point() const { return point_; }
  [[nodiscard]] Rgb color() const { return point_.intensity; }
  /// Share of the intensity in a direction, unit, from the light.
  [[nodiscard]] double share(Vec3d direction) const;
  template <class Where>
  [[nodiscard]] LightSample sample(const Where& where, Rng&) const {
    return arriving_at(where());
  }
  [[nodiscard]] static Box met_within() { return {}; }
  [[nodiscard]] static LightMet met(const Ray&, double) { return {}; }
  [[nodiscard]] Rgb irradiance_on(const Box& box) const;
  [[nodiscard]] Rgb on_plane(Vec3d place, Vec3d normal) const;

 private:
  [[nodiscard]] LightSample arriving_at(Vec3d place) const;

  PointSource point_;
  Vec3d axis_;                             // unit
  double one_minus_rim_, one_minus_full_;  // 1 - cosines: dark beyond, undimmed within
};

/// A rectangle. Sampled evenly over the directions in which it lies, or over its area where it is
/// so far away that this is the same. Based on: Urena, Fajardo, King. An Area-Preserving
/// Parametrization for Spherical Rectangles. 2013.
class AreaSource {
 public:
  explicit AreaSource(const AreaLight& light);

  /// As a point in its middle that shines this much along its direction.
  [[nodiscard]] const PointSource& centre() const { return centre_; }
  [[nodiscard]] Rgb color() const { return centre_.intensity; }
  [[nodiscard]] Vec3d normal() const { return normal_; }
  template <class Where>
  [[nodiscard]] LightSample sample(const Where& where, Rng& rng) const {
    return sample_from(where(), rng);
  }
  [[nodiscard]] Box met_within() const;
  [[nodiscard]] LightMet met(const Ray& ray, double distance) const;
  [[nodiscard]] Rgb irradiance_on(const Box& box) const;
  [[nodiscard]] Rgb on_plane(Vec3d place, Vec3d normal) const;

 private:
  struct View;  // of the rectangle from a place
  [[nodiscard]] LightSample sample_from(Vec3d place, Rng& rng) const;

  PointSource centre_;
  Vec3d x_, y_, normal_;  // unit
  double width_, height_;
  Rgb radiance_;
  bool visible_;
};

}  // namespace pvol
