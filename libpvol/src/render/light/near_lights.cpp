#include "pvol/render/near_lights.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "pvol/math/direction.h"
#include "render/light/disc_on_plane.h"

namespace pvol {
namespace {

using std::numbers::pi;

constexpr LightSample kDark{Vec3f(0, 0, 1), Rgb(0.0f)};

Box around(Vec3d centre, double radius) { return {centre - Vec3d(radius), centre + Vec3d(radius)}; }

/// The largest of f(direction) over the directions from a place to the corners and the centre of a
/// box, but no less than `most`.
template <class F>
double largest_over(const Box& box, Vec3d from, double most, const F& f) {
  const auto look = [&](Vec3d at) {
    const Vec3d way = at - from;
    if (length(way) > 0) most = std::max(most, f(normalize(way)));
  };
  look(box.centre());
  for (unsigned k = 0; k < 8 && box.lo != box.hi; ++k) look(corner(box, k));
  return most;
}

}  // namespace

LightSample PointSource::arriving_at(Vec3d place) const {
  const Vec3d way = position - place;
  const double distance = length(way);
  const Rgb irradiance(Vec3d(intensity) / (distance * distance));
  // At the light, or nearer than sqrt(I / 3e38), a float does not hold what arrives.
  if (!(distance > 0) || !is_finite(irradiance)) return kDark;
  return {Vec3f(way / distance), irradiance, 0, distance};
}

Rgb PointSource::irradiance_on(const Box& box) const {
  const Vec3d way = position - box.centre(), rim = box.extent() * 0.5;
  return Rgb(Vec3d(intensity) / std::max(dot(way, way), dot(rim, rim)));
}

Rgb PointSource::on_plane(Vec3d place, Vec3d normal) const {
  const LightSample l = arriving_at(place);
  return l.radiance * float(std::max(0.0, dot(Vec3d(l.direction), normal)));
}

BallSource::BallSource(const PointLight& light)
    : centre_{light.position, light.intensity},
      radius_(light.radius),
      radiance_(Vec3d(light.intensity) / (pi * light.radius * light.radius)),
      visible_(light.visible_camera) {}

/// 1 - cosine of its radius as seen from a distance to its centre; 0 for a point that floats do not
/// tell from one, and in the ball.
double BallSource::cap(double distance) const {
  const double sine = radius_ / distance;
  if (!(sine < 1 && sine > 1e-12)) return 0;
  return sine * sine / (1 + std::sqrt(1 - sine * sine));
}

LightSample BallSource::sample_from(Vec3d place, Rng& rng) const {
  const Vec3d way = centre_.position - place;
  const double distance = length(way), c = cap(distance);
  if (!(distance > radius_)) return kDark;
  if (c == 0) return centre_.arriving_at(place);
  if (!is_finite(radiance_)) return kDark;
  const auto [u, azimuth] = rng.uniform2();
  const double own = c * double(u), sine = distance * std::sqrt(own * (2 - own));
  // Up to its surface, as the ray meets it.
  const double near =
      distance * (1 - own) - std::sqrt(std::max(0.0, radius_ * radius_ - sine * sine));
  return {turn(Vec3f(way / distance), float(own), azimuth), radiance_, float(1 / (2 * pi * c)),
          near};
}

Box BallSource::met_within() const { return around(centre_.position, radius_); }

LightMet BallSource::met(const Ray& ray, double distance) const {
  const Vec3d way = centre_.position - ray.o, d = normalize(ray.d);
  const double apart = dot(way, way), along = dot(way, d);
  const Vec3d beside = way - d * along;
  const double square = radius_ * radius_ - dot(beside, beside);
  if (!(apart > radius_ * radius_ && along > 0 && square > 0)) return {};
  const double c = cap(std::sqrt(apart)), near = along - std::sqrt(square);
  if (!(near < distance && c > 0)) return {};
  return {radiance_, float(1 / (2 * pi * c)), visible_, near};
}

Rgb BallSource::on_plane(Vec3d place, Vec3d normal) const {
  const LightSample l = centre_.arriving_at(place);
  if (!(l.distance > radius_)) return Rgb(0.0f);
  const double angle = std::acos(std::clamp(dot(Vec3d(l.direction), normal), -1.0, 1.0));
  return l.radiance * float(detail::disc_on_plane(angle, std::asin(radius_ / l.distance)));
}

SpotSource::SpotSource(const SpotLight& light)
    : point_{light.position, light.intensity}, axis_(normalize(light.direction)) {
  const auto one_minus_cos = [](double degrees) {
    const double half = std::sin(degrees / 2 * pi / 180);
    return 2 * half * half;
  };
  one_minus_rim_ = one_minus_cos(light.angle / 2);
  one_minus_full_ = one_minus_cos(light.angle / 2 * (1 - light.blend));
}

double SpotSource::share(Vec3d d) const {
  const Vec3d apart = d - axis_;
  const double c = 0.5 * dot(apart, apart);
  if (c >= one_minus_rim_) return 0;
  if (c <= one_minus_full_) return 1;
  const double x = (one_minus_rim_ - c) / (one_minus_rim_ - one_minus_full_);
  return x * x * (3 - 2 * x);
}

LightSample SpotSource::arriving_at(Vec3d place) const {
  LightSample l = point_.arriving_at(place);
  l.radiance *= float(share(-Vec3d(l.direction)));
  return l;
}

Rgb SpotSource::irradiance_on(const Box& box) const {
  const double along_axis = intersect(box, {point_.position, axis_}, 0, 1e300) ? 1 : 0;
  const double most =
      largest_over(box, point_.position, along_axis, [&](Vec3d d) { return share(d); });
  return point_.irradiance_on(box) * float(most);
}

Rgb SpotSource::on_plane(Vec3d place, Vec3d normal) const {
  const LightSample l = arriving_at(place);
  return l.radiance * float(std::max(0.0, dot(Vec3d(l.direction), normal)));
}

AreaSource::AreaSource(const AreaLight& light)
    : centre_{light.position, light.radiance * float(light.size[0] * light.size[1])},
      normal_(normalize(light.direction)),
      width_(light.size[0]),
      height_(light.size[1]),
      radiance_(light.radiance),
      visible_(light.visible_camera) {
  // Its height lies along `up`, or one of the axes where that is its direction.
  constexpr double kParallel = 1e-6;
  for (const Vec3d up : {light.up, Vec3d(0, 0, 1), Vec3d(0, 1, 0)}) {
    const Vec3d across = cross(normalize(up), normal_);
    if (!(length(across) > kParallel)) continue;
    x_ = normalize(across);
    break;
  }
  y_ = cross(normal_, x_);
}

/// The rectangle from a place before it: x and y of its edges and z along its normal from there,
/// and what is needed of the spherical rectangle that it covers.
struct AreaSource::View {
  /// An angle by its cosine and sine.
  struct Angle {
    double c, s;
    friend Angle operator+(Angle a, Angle b) {
      return {a.c * b.c - a.s * b.s, a.c * b.s + a.s * b.c};
    }
  };

  double x0, x1, y0, y1, z;
  Angle left{};            ///< the sum of those at x0
  double b0 = 0, b1 = 0;   ///< z of the normals of the planes through its edges at y0 and y1
  double solid_angle = 0;  ///< 0: too small for what is computed of angles

  View(const AreaSource& light, Vec3d place) {
    const Vec3d way = light.centre_.position - place;
    x0 = dot(way, light.x_) - light.width_ / 2, x1 = x0 + light.width_;
    y0 = dot(way, light.y_) - light.height_ / 2, y1 = y0 + light.height_;
    z = dot(way, light.normal_);
    if (!is_before()) return;
    const auto inverse = [this](double edge) { return 1 / std::sqrt(edge * edge + z * z); };
    const double to_x0 = inverse(x0), to_x1 = inverse(x1);
    const double to_y0 = inverse(y0), to_y1 = inverse(y1);
    b0 = -y0 * to_y0, b1 = y1 * to_y1;
    // The angle between the planes through two edges that meet at (x, y).
    const auto corner = [this](double x, double y, double across, double inverses) -> Angle {
      return {across * inverses, -z * std::sqrt(x * x + y * y + z * z) * inverses};
    };
    const Angle right =
        corner(x1, y0, x1 * y0, to_x1 * to_y0) + corner(x1, y1, -x1 * y1, to_x1 * to_y1);
    left = corner(x0, y1, x0 * y1, to_x0 * to_y1) + corner(x0, y0, -x0 * y0, to_x0 * to_y0);
    // The sum of all four, less a whole turn.
    const Angle all = left + right;
    const double whole = std::atan2(all.s, all.c);
    constexpr double kLeast = 1e-5;
    if (-z < std::min({-x0, x1, -y0, y1})) {  // from so near it is above 2, and may be all of 2 pi
      solid_angle = whole < 1 ? whole + 2 * pi : whole;
    } else if (std::abs(whole) > kLeast) {
      solid_angle = whole < 0 ? whole + 2 * pi : whole;
    }
  }

  [[nodiscard]] bool is_before() const { return z < 0; }

  /// Where a share of the solid angle is.
  [[nodiscard]] Vec3d point(double u, double v) const {
    const double share = u * solid_angle, cosine = std::cos(share), sine = std::sin(share);
    const double f =
        ((cosine * left.c + sine * left.s) * b0 - b1) / (sine * left.c - cosine * left.s);
    const double steep = std::sqrt(std::max(f * f + b0 * b0 - 1, 1e-300));
    const double x = std::clamp(std::copysign(z / steep, f), x0, x1);
    const double d2 = x * x + z * z;
    const double h0 = y0 / std::sqrt(d2 + y0 * y0), h1 = y1 / std::sqrt(d2 + y1 * y1);
    const double h = h0 + v * (h1 - h0);
    const double y = std::clamp(h * std::sqrt(d2 / std::max(1 - h * h, 1e-300)), y0, y1);
    return {x, y, z};
  }

  /// Density of a point of it, in the same coordinates.
  [[nodiscard]] double pdf(Vec3d at) const {
    if (solid_angle > 0) return 1 / solid_angle;
    const double d2 = dot(at, at);
    return d2 * std::sqrt(d2) / (-z * (x1 - x0) * (y1 - y0));
  }
};

LightSample AreaSource::sample_from(Vec3d place, Rng& rng) const {
  const View view(*this, place);
  if (!view.is_before()) return kDark;
  const auto [u, v] = rng.uniform2();
  const Vec3d at = view.solid_angle > 0
                       ? view.point(double(u), double(v))
                       : Vec3d(view.x0 + width_ * double(u), view.y0 + height_ * double(v), view.z);
  const double distance = length(at), pdf = view.pdf(at);
  if (!(distance > 0 && std::isfinite(float(pdf)))) return kDark;
  const Vec3d way = x_ * at.x + y_ * at.y + normal_ * at.z;
  return {Vec3f(way / distance), radiance_, float(pdf), distance};
}

Box AreaSource::met_within() const {
  return around(centre_.position, std::hypot(width_, height_) / 2);
}

LightMet AreaSource::met(const Ray& ray, double distance) const {
  const double towards = -dot(ray.d, normal_);
  const Vec3d way = centre_.position - ray.o;
  const double before = -dot(way, normal_);
  if (!(towards > 0 && before > 0)) return {};
  const double t = before / towards;
  const Vec3d at = ray.d * t, off = at - way;
  if (!(t < distance && std::abs(dot(off, x_)) <= width_ / 2 &&
        std::abs(dot(off, y_)) <= height_ / 2)) {
    return {};
  }
  const double pdf = View(*this, ray.o).pdf(at);
  return std::isfinite(float(pdf)) ? LightMet{radiance_, float(pdf), visible_, t} : LightMet{};
}

Rgb AreaSource::irradiance_on(const Box& box) const {
  double most = largest_over(box, centre_.position, 0, [&](Vec3d d) { return dot(d, normal_); });
  const Vec3d way = centre_.position - box.centre(), rim = box.extent() * 0.5;
  const double area = width_ * height_;
  const double square = std::max({dot(way, way), dot(rim, rim), area / pi});
  // Near its plane a lamp of that size still fills much of the view: it is not as faint there as
  // its centre's cosine says, and what is drawn by this must not be.
  if (most > 0) most = std::max(most, 0.5 * std::min(1.0, std::sqrt(area / square)));
  return centre_.intensity * float(most / square);
}

/// Lambert's formula for polygons, over the part of the rectangle above the plane.
Rgb AreaSource::on_plane(Vec3d place, Vec3d normal) const {
  const Vec3d way = centre_.position - place;
  if (!(dot(way, normal_) < 0)) return Rgb(0.0f);
  const Vec3d x = x_ * (width_ / 2), y = y_ * (height_ / 2);
  const std::array<Vec3d, 4> corners{way - x - y, way + x - y, way + x + y, way - x + y};
  std::array<Vec3d, 8> above;
  std::size_t count = 0;
  for (std::size_t i = 0; i < 4; ++i) {
    const Vec3d a = corners[i], b = corners[(i + 1) % 4];
    const double ha = dot(a, normal), hb = dot(b, normal);
    if (ha >= 0) above[count++] = a;
    if ((ha < 0) != (hb < 0)) above[count++] = a + (b - a) * (ha / (ha - hb));
  }
  double sum = 0;
  for (std::size_t i = 0; i < count; ++i) {
    const Vec3d a = above[i], b = above[(i + 1) % count], across = cross(a, b);
    const double sine = length(across);
    if (sine > 0) sum += std::atan2(sine, dot(a, b)) * dot(across / sine, normal);
  }
  return radiance_ * float(0.5 * std::abs(sum));
}

}  // namespace pvol
