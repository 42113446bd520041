#include "support/reference_tracer.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <optional>
#include <span>
#include <stdexcept>
#include <utility>
#include <variant>
#include <vector>

#include "support/bodies.h"
#include "support/oracle.h"

namespace pvol::test {
namespace {

constexpr double kPi = std::numbers::pi, kNowhere = std::numeric_limits<double>::infinity();

/// A point of the unit sphere, evenly.
Vec3d any_direction(Rng& rng) {
  const auto [u, v] = rng.uniform2();
  const double z = 1 - 2 * double(u), r = std::sqrt(1 - z * z), azimuth = 2 * kPi * double(v);
  return {r * std::cos(azimuth), r * std::sin(azimuth), z};
}

// --- Media ---

/// A volume at one of its places, at one time.
struct Placed {
  const ReferenceVolume* volume;
  Affine to_object;
};

/// What there is at a place, in one channel.
struct Local {
  struct Lobe {
    const PhaseFunction* phase;
    double scattering;
  };
  double extinction = 0, emission = 0;  ///< both per world unit

  void add(const Lobe& lobe) { lobes_.at(count_++) = lobe; }
  [[nodiscard]] std::span<const Lobe> lobes() const { return {lobes_.data(), count_}; }
  [[nodiscard]] double scattering() const {
    double sum = 0;
    for (const Lobe& l : lobes()) sum += l.scattering;
    return sum;
  }

 private:
  std::array<Lobe, 16> lobes_;  // one is made at each tentative collision: without an allocation
  std::size_t count_ = 0;
};

/// All volumes at one time, in one channel.
class Media {
 public:
  Media(const ReferenceScene& scene, double time, int channel)
      : look_up_(scene.scene.options.look_up), time_(time), channel_(channel) {
    for (const ReferenceVolume& v : scene.volumes) {
      for (const MovingPlace& place : v.places) {
        all_.push_back({&v, inverse(place.at(time))});
        box_ = join(box_, transform(place.at(time), reach(v)));
      }
      const double largest = std::max(mapped(v, 0), mapped(v, double(v.field->largest)));
      majorant_ +=
          (v.medium.extinction * largest + (v.fire ? kOfFires : 0)) * double(v.places.size());
    }
  }

  [[nodiscard]] double majorant() const { return majorant_; }
  [[nodiscard]] const Box& box() const { return box_; }

  [[nodiscard]] double extinction_at(Vec3d world) const {
    double sum = 0;
    for (const Placed& p : all_) {
      sum += extinction(*p.volume, moved(*p.volume, p.to_object.point(world)));
    }
    return sum;
  }

  [[nodiscard]] Local at(Vec3d world) const {
    Local sum;
    for (const Placed& p : all_) {
      const ReferenceVolume& v = *p.volume;
      const Vec3d source = moved(v, p.to_object.point(world));
      if (v.fire) {
        sum.emission += v.fire->intensity * double(v.fire->color[channel_]) *
                        density_at(*v.fire->field, LookUp::trilinear, source);
      }
      const double mu = extinction(v, source);
      if (mu == 0) continue;
      sum.extinction += mu;
      const double color = v.albedo ? v.albedo(source)[channel_] : 1;
      for (const Component& c : v.medium.components) {
        const double albedo = color * double(c.albedo[channel_]);
        sum.add({&c.phase, mu * c.share * albedo});
        sum.emission += mu * c.share * (1 - albedo) * double(c.emission[channel_]);
      }
    }
    return sum;
  }

 private:
  static constexpr double kOfFires = 0.2;  // tentative collisions per world unit, for emission

  LookUp look_up_;
  double time_;
  int channel_;
  std::vector<Placed> all_{};
  Box box_{Vec3d(kNowhere), Vec3d(-kNowhere)};
  double majorant_ = 0;

  [[nodiscard]] double extinction(const ReferenceVolume& v, Vec3d source) const {
    return v.medium.extinction * double(v.medium.extinction_color[channel_]) *
           mapped(v, density_at(*v.field, look_up_, source));
  }
  [[nodiscard]] static double mapped(const ReferenceVolume& v, double density) {
    double y = v.map.scale * density + v.map.offset;
    if (v.map.clamp) y = std::clamp(y, (*v.map.clamp)[0], (*v.map.clamp)[1]);
    return std::max(0.0, v.map.power == 1 ? y : std::pow(std::max(y, 0.0), v.map.power));
  }
  /// Where the density at x was at the time of the samples.
  [[nodiscard]] Vec3d moved(const ReferenceVolume& v, Vec3d x) const {
    return v.velocity ? x - v.velocity(x) * time_ : x;
  }
  /// Beyond which there is nothing of a volume, in its object's space: the box of all that is told.
  [[nodiscard]] static Box reach(const ReferenceVolume& v) {
    const Box samples{Vec3d(v.field->origin) - Vec3d(2),
                      Vec3d(v.field->origin + v.field->size) + Vec3d(2)};
    if (!v.velocity && !v.fire) return samples;
    return {Vec3d(kToldFrom), Vec3d(kToldFrom + kToldSize)};
  }
};

// --- Surfaces ---

struct Hit {
  double t = kNowhere;
  Vec3d normal{};  ///< unit, on the ray's side
  const Material* material = nullptr;
};

/// What is nearer counts as the start itself.
constexpr double kClearance = 1e-6;

void take_nearer(Hit& hit, const Ray& ray, double t, Vec3d normal, const Material& material) {
  if (t <= kClearance || t >= hit.t) return;
  normal = normalize(normal);
  hit = {t, dot(normal, ray.d) < 0 ? normal : -normal, &material};
}
void meet(const PlaneSurface& plane, const Ray& ray, Hit& hit) {
  const double t = dot(plane.point - ray.o, plane.normal) / dot(ray.d, plane.normal);
  take_nearer(hit, ray, t, plane.normal, plane.material);
}
void meet(const BallSurface& ball, const Ray& ray, Hit& hit) {
  const Vec3d o = ray.o - ball.centre;
  const double b = dot(o, ray.d), root = b * b - dot(o, o) + ball.radius * ball.radius;
  if (root <= 0) return;
  for (const double t : {-b - std::sqrt(root), -b + std::sqrt(root)}) {
    take_nearer(hit, ray, t, o + ray.d * t, ball.material);
  }
}
void meet(const MeshSurface& surface, const Ray& ray, Hit& hit) {
  const Affine place = surface.place.map();
  for (const auto& triangle : surface.mesh->triangles) {
    const auto corner = [&](int i) {
      return place.point(surface.mesh->vertices[triangle[std::size_t(i)]]);
    };
    const Vec3d a = corner(0), e1 = corner(1) - a, e2 = corner(2) - a, normal = cross(e1, e2);
    const double t = dot(a - ray.o, normal) / dot(ray.d, normal);
    if (!std::isfinite(t)) continue;
    const Vec3d p = ray.at(t) - a;  // inside, where its share of each edge is
    const double u = dot(cross(p, e2), normal), v = dot(cross(e1, p), normal);
    const double all = dot(normal, normal);
    if (u >= 0 && v >= 0 && u + v <= all) take_nearer(hit, ray, t, normal, surface.material);
  }
}
template <class Other>
void meet(const Other&, const Ray&, Hit&) {
  throw std::logic_error("the reference tracer does not know this surface");
}

/// Among those that rays of a kind meet.
Hit nearest(const std::vector<Surface>& surfaces, const Ray& ray, bool Material::*met) {
  Hit hit;
  for (const Surface& s : surfaces) {
    std::visit(
        [&](const auto& kind) {
          if (kind.material.*met) meet(kind, ray, hit);
        },
        s);
  }
  return hit;
}

/// Where surfaces are at a time. Turns are about one axis.
Surface at_time(Surface surface, double t) {
  const auto between = [t](const auto& a, const auto& b) { return a + (b - a) * t; };
  if (auto* ball = std::get_if<BallSurface>(&surface); ball && ball->to) {
    ball->centre = between(ball->centre, ball->to->centre);
  }
  if (auto* mesh = std::get_if<MeshSurface>(&surface); mesh && mesh->to) {
    Placement& place = mesh->place;
    place.translate = between(place.translate.value(), mesh->to->translate.value());
    double& degrees = place.rotate.at(0).degrees;
    degrees = between(degrees, mesh->to->rotate.at(0).degrees);
  }
  return surface;
}

// --- Lights ---

/// A direction to a light from a place, and what comes from there over its probability density.
struct Towards {
  Vec3d direction{};
  double distance = kNowhere;
  double radiance = 0;
};

/// Of a surface that shines, seen at a point of it that was chosen evenly over an area.
Towards from_surface(Vec3d way, Vec3d normal, double radiance, double area) {
  const double square = dot(way, way), cosine = -dot(way, normal) / std::sqrt(square);
  return {normalize(way), std::sqrt(square), cosine <= 0 ? 0 : radiance * cosine * area / square};
}
Towards from(const Arriving& light, int c) {
  return {light.towards, light.distance, light.irradiance[c]};
}
double half_angle(const Sun& sun) { return sun.angle / 2 * kPi / 180; }
double radiance_of(const Sun& sun, int c) {
  return double(sun.irradiance[c]) / (kPi * std::pow(std::sin(half_angle(sun)), 2));
}
double radiance_of(const PointLight& ball, int c) {
  return double(ball.intensity[c]) / (kPi * ball.radius * ball.radius);
}

Towards towards(const Sun& sun, Vec3d, int c, Rng& rng) {
  const Vec3d axis = normalize(sun.direction);
  if (sun.angle == 0) return {axis, kNowhere, double(sun.irradiance[c])};
  const auto [u, v] = rng.uniform2();
  const double cap = 1 - std::cos(half_angle(sun)), cosine = 1 - cap * double(u);
  const double sine = std::sqrt(1 - cosine * cosine), azimuth = 2 * kPi * double(v);
  Vec3d s, t;
  orthonormal_basis(axis, s, t);
  const Vec3d d = axis * cosine + (s * std::cos(azimuth) + t * std::sin(azimuth)) * sine;
  return {d, kNowhere, radiance_of(sun, c) * 2 * kPi * cap};
}
Towards towards(const PointLight& light, Vec3d place, int c, Rng& rng) {
  const Vec3d way = light.position - place;
  if (light.radius == 0) return from(from_point(way, Vec3d(light.intensity)), c);
  const Vec3d normal = any_direction(rng);
  return from_surface(way + normal * light.radius, normal, radiance_of(light, c),
                      4 * kPi * light.radius * light.radius);
}
Towards towards(const SpotLight& light, Vec3d place, int c, Rng&) {
  return from(from_spot(light, place), c);
}
Towards towards(const AreaLight& light, Vec3d place, int c, Rng& rng) {
  const auto [u, v] = rng.uniform2();
  const Sides s = sides_of(light);
  const Vec3d at = light.position + s.across * (double(u) - 0.5) + s.up * (double(v) - 0.5);
  return from_surface(at - place, s.normal, double(light.radiance[c]),
                      light.size[0] * light.size[1]);
}

template <class Other>
Towards towards(const Other&, Vec3d, int, Rng&) {
  throw std::logic_error("the reference tracer does not know this light");
}

/// What a camera ray sees of a light that lets light through, if nothing stops it before `end`.
double seen(const Sun& sun, const Ray& ray, double end, int c) {
  const bool met = sun.angle > 0 && end == kNowhere &&
                   dot(ray.d, normalize(sun.direction)) > std::cos(half_angle(sun));
  return met ? radiance_of(sun, c) : 0;
}
double seen(const PointLight& light, const Ray& ray, double end, int c) {
  if (light.radius == 0) return 0;
  Hit hit;
  meet(BallSurface{light.position, light.radius, {}}, ray, hit);
  return hit.t < end ? radiance_of(light, c) : 0;
}
double seen(const AreaLight& light, const Ray& ray, double end, int c) {
  const Sides s = sides_of(light);
  const double t = dot(light.position - ray.o, s.normal) / dot(ray.d, s.normal);
  if (!(t > 0 && t < end && dot(ray.d, s.normal) < 0)) return 0;
  const Vec3d p = ray.at(t) - light.position;
  const auto within = [&](Vec3d side) { return 2 * std::abs(dot(p, side)) <= dot(side, side); };
  return within(s.across) && within(s.up) ? double(light.radiance[c]) : 0;
}

template <class OfNoExtent>
double seen(const OfNoExtent&, const Ray&, double, int) {
  return 0;
}

double radiance_of(const ConstantSky& sky, Vec3d, int c) { return double(sky.radiance[c]); }
double radiance_of(const GradientSky& sky, Vec3d d, int c) {
  const double up = dot(d, normalize(sky.up));
  const double end = double(up >= 0 ? sky.zenith[c] : sky.ground[c]);
  return double(sky.horizon[c]) + std::abs(up) * (end - double(sky.horizon[c]));
}
/// Of one that is neither turned nor scaled.
double radiance_of(const ImageSky& sky, Vec3d d, int c) {
  const double turn = std::atan2(d.z, d.x) / (2 * kPi), down = std::acos(d.y) / kPi;
  const int x = std::min(int((turn - std::floor(turn)) * sky.width), sky.width - 1);
  const int y = std::min(int(down * sky.height), sky.height - 1);
  return double(sky.pixels[std::size_t(y * sky.width + x)][c]);
}
template <class Other>
double radiance_of(const Other&, Vec3d, int) {
  throw std::logic_error("the reference tracer does not know this sky");
}

// --- Shadow catchers ---

/// Irradiance of a plane that nothing shades, over pi.
double open(const Sun& sun, Vec3d, Vec3d normal, int c) {
  return double(sun.irradiance[c]) * dot(normalize(sun.direction), normal) / kPi;
}
double open(const PointLight& light, Vec3d place, Vec3d normal, int c) {
  const Vec3d way = light.position - place;
  return double(light.intensity[c]) * dot(way, normal) / std::pow(dot(way, way), 1.5) / kPi;
}
double open(const SpotLight& light, Vec3d place, Vec3d normal, int c) {
  const Towards to = from(from_spot(light, place), c);
  return to.radiance * dot(to.direction, normal) / kPi;
}
double open(const AreaLight& light, Vec3d place, Vec3d normal, int c) {
  constexpr int kParts = 16;  // along each side
  const Sides s = sides_of(light);
  const double area = light.size[0] * light.size[1] / (kParts * kParts);
  double sum = 0;
  for (int i = 0; i < kParts; ++i) {
    for (int k = 0; k < kParts; ++k) {
      const Vec3d at = light.position + s.across * ((i + 0.5) / kParts - 0.5) +
                       s.up * ((k + 0.5) / kParts - 0.5);
      const Towards to = from_surface(at - place, s.normal, double(light.radiance[c]), area);
      sum += to.radiance * dot(to.direction, normal) / kPi;
    }
  }
  return sum;
}
template <class Other>
double open(const Other&, Vec3d, Vec3d, int) {
  throw std::logic_error("the reference tracer does not know this light on a shadow catcher");
}

double radiance_of(const Environment& sky, Vec3d d, int c) {
  return std::visit([&](const auto& kind) { return radiance_of(kind, d, c); }, sky);
}
double open(const Environment& sky, Vec3d normal, int c) {
  constexpr int kParts = 256;
  Vec3d s, t;
  orthonormal_basis(normal, s, t);
  double sum = 0;
  for (int i = 0; i < kParts; ++i) {
    for (int k = 0; k < kParts; ++k) {  // directions as often as the cosine is large
      const double square = (i + 0.5) / kParts, azimuth = 2 * kPi * (k + 0.5) / kParts;
      const Vec3d across = s * std::cos(azimuth) + t * std::sin(azimuth);
      sum += radiance_of(sky, normal * std::sqrt(1 - square) + across * std::sqrt(square), c);
    }
  }
  return sum / (kParts * kParts);
}

/// By channel, of the scene's shadow catcher; 0 where there is none.
Vec3d open_sky(const CloudScene& scene) {
  Vec3d all;
  for (const Surface& s : scene.surfaces) {
    const auto* const plane = std::get_if<PlaneSurface>(&s);
    if (plane == nullptr || plane->material.visibility != Visibility::shadow_catcher) continue;
    for (int c = 0; c < 3; ++c) all[c] = open(scene.environment, normalize(plane->normal), c);
  }
  return all;
}

// --- Paths ---

class Tracer {
 public:
  Tracer(const ReferenceScene& scene, Vec3d open_sky, double time, int channel, Rng& rng)
      : scene_(scene.scene),
        open_sky_(open_sky),
        medium_(scene, time, channel),
        c_(channel),
        rng_(rng) {
    for (const Surface& s : scene_.surfaces) surfaces_.push_back(at_time(s, time));
  }

  struct Result {
    double radiance = 0;
    double passed = 0;  ///< this channel's part of 1 - alpha
  };
  [[nodiscard]] Result trace(Ray ray) {
    Result result;
    double weight = 1;
    std::optional<Caught> caught;  // where the path comes from a shadow catcher
    const std::uint32_t most = scene_.options.max_bounces.value_or(1'000'000);
    for (std::uint32_t bounce = 0;; ++bounce) {
      const bool of_camera = bounce == 0;
      const Hit hit =
          nearest(surfaces_, ray, of_camera ? &Material::visible_camera : &Material::visible_light);
      // Emission and what is behind it all come up to here.
      const double shade = of_camera ? hit.t : nearest(surfaces_, ray, &Material::visible_shadow).t;
      double emitted = 0;
      const std::optional<Collision> collision = fly(ray, std::max(hit.t, shade), shade, emitted);
      const double free = collision ? collision->t : kNowhere, end = std::min(free, hit.t);
      result.radiance += weight * emitted;
      const double light = behind(ray, std::min(free, shade), of_camera);
      if (caught) {
        caught->add(light, result);
        caught = {};
      } else if (!of_camera || scene_.options.background) {
        result.radiance += weight * light;
      }
      const bool collides = free < hit.t;
      const auto sees = [&](Visibility looks) {
        return of_camera && !collides && end < kNowhere && hit.material->visibility == looks;
      };
      if (of_camera && (end == kNowhere || sees(Visibility::holdout))) result.passed = 1.0 / 3;
      if (end == kNowhere || bounce == most || sees(Visibility::holdout)) return result;
      const Vec3d place = ray.at(end);
      if (sees(Visibility::shadow_catcher)) {
        caught = shadow_at(ray, hit, place);
        caught->add(lit(hit, place), result);
        weight = double(hit.material->albedo[c_]);
        ray = {place, normalize(hit.normal + any_direction(rng_))};
        continue;
      }
      if (collides) {
        weight *= collision->medium.scattering() / collision->medium.extinction;
        result.radiance += weight * lit(collision->medium, ray.d, place);
        ray = {place, scatter(collision->medium, ray.d)};
      } else {
        weight *= double(hit.material->albedo[c_]);
        result.radiance += weight * lit(hit, place);
        ray = {place, normalize(hit.normal + any_direction(rng_))};
      }
      if (weight < 0.3) {
        if (double(rng_.uniform()) >= weight) return result;
        weight = 1;
      }
    }
  }

 private:
  const CloudScene& scene_;
  Vec3d open_sky_;  // irradiance over pi, by channel
  std::vector<Surface> surfaces_{};
  Media medium_;
  int c_;
  Rng& rng_;

  struct Collision {
    double t;
    Local medium;
  };

  /// What unscattered light on a shadow catcher counts, instead of what the catcher scatters of it.
  struct Caught {
    double shown, passed;

    void add(double light, Result& to) const {
      to.radiance += light * shown, to.passed += light * passed;
    }
  };
  [[nodiscard]] Caught shadow_at(const Ray& ray, const Hit& hit, Vec3d place) const {
    Vec3d all = open_sky_;
    for (int c = 0; c < 3; ++c) {
      for (const Light& light : scene_.lights) {
        all[c] += std::visit([&](const auto& l) { return open(l, place, hit.normal, c); }, light);
      }
    }
    Rgb own(0.0f);
    own[c_] = 1;
    const double seen = scene_.options.background ? radiance_of(scene_.environment, ray.d, c_) : 0;
    return {seen / all[c_], double(luminance(own)) / double(luminance(Rgb(Vec3f(all))))};
  }

  /// f(t, place) at tentative collisions before `end` until it returns false.
  template <class F>
  void tentative_collisions(const Ray& ray, double end, const F& f) {
    const auto span = intersect(medium_.box(), ray, 0, std::min(end, 1e9));
    if (!span) return;
    for (double t = span->t0;;) {
      t += double(to_exponential(rng_.block().lo)) / medium_.majorant();
      if (t >= span->t1 || !f(t, ray.at(t))) return;
    }
  }

  /// Adds what is emitted on the way before `shade`.
  std::optional<Collision> fly(const Ray& ray, double end, double shade, double& emitted) {
    std::optional<Collision> found;
    tentative_collisions(ray, end, [&](double t, Vec3d place) {
      const Local medium = medium_.at(place);
      if (t < shade) emitted += medium.emission / medium_.majorant();
      if (double(rng_.uniform()) * medium_.majorant() >= medium.extinction) return true;
      found = {t, medium};
      return false;
    });
    return found;
  }

  double transmittance(const Ray& ray, double end) {
    if (nearest(surfaces_, ray, &Material::visible_shadow).t < end) return 0;
    double passed = 1;
    tentative_collisions(ray, end, [&](double, Vec3d place) {
      passed *= 1 - medium_.extinction_at(place) / medium_.majorant();
      return passed > 0;
    });
    return passed;
  }

  double behind(const Ray& ray, double end, bool of_camera) {
    double sum = 0;
    if (end == kNowhere) {
      sum += radiance_of(scene_.environment, ray.d, c_);
    }
    for (const Light& light : scene_.lights) {
      if (of_camera) sum += std::visit([&](const auto& l) { return seen(l, ray, end, c_); }, light);
    }
    return sum;
  }

  /// f(direction) is the share of what comes from there that goes on along the path. Of many lights
  /// one in each quarter of them is asked.
  template <class F>
  double lit_by_lights(Vec3d place, const F& f) {
    const auto lit_by = [&](const Light& light) {
      const Towards to =
          std::visit([&](const auto& l) { return towards(l, place, c_, rng_); }, light);
      const double share = to.radiance > 0 ? f(to.direction) : 0;
      return share > 0 ? share * to.radiance * transmittance({place, to.direction}, to.distance)
                       : 0;
    };
    const std::size_t lights = scene_.lights.size(), parts = std::min<std::size_t>(lights, 4);
    double sum = 0;
    for (std::size_t part = 0; part < parts; ++part) {
      const std::size_t first = lights * part / parts, n = lights * (part + 1) / parts - first;
      const auto chosen = n == 1 ? 0 : std::size_t(double(rng_.uniform()) * double(n));
      sum += double(n) * lit_by(scene_.lights[first + chosen]);
    }
    return sum;
  }
  double lit(const Local& medium, Vec3d from, Vec3d place) {
    return lit_by_lights(place, [&](Vec3d to) {
      double sum = 0;
      for (const Local::Lobe& l : medium.lobes()) {
        sum += l.scattering * double(pdf_phase(*l.phase, Vec3f(from), Vec3f(to)));
      }
      return sum / medium.scattering();
    });
  }
  double lit(const Hit& hit, Vec3d place) {
    return lit_by_lights(place, [&](Vec3d to) { return std::max(0.0, dot(hit.normal, to)) / kPi; });
  }

  Vec3d scatter(const Local& medium, Vec3d from) {
    double left = double(rng_.uniform()) * medium.scattering();
    const PhaseFunction* phase = medium.lobes().back().phase;
    for (const Local::Lobe& l : medium.lobes()) {
      if (left < l.scattering) {
        phase = l.phase;
        break;
      }
      left -= l.scattering;
    }
    return normalize(Vec3d(sample_phase(*phase, Vec3f(from), rng_)));
  }
};

/// The camera ray of a place in the picture, in pixels from its upper left corner, at a time. The
/// camera moves without turning.
Ray camera_ray(const CloudScene& scene, double x, double y, double time) {
  const Camera& c = scene.camera;
  const Vec3d way = c.to ? c.to->position - c.position : Vec3d{};
  const Vec3d ahead = normalize(c.target - c.position), right = normalize(cross(ahead, c.up));
  const double half = std::tan(c.fov / 2 * kPi / 180), height = scene.options.height;
  const Vec3d up = cross(right, ahead);
  const double across = (2 * x - scene.options.width) / height, above = 1 - 2 * y / height;
  return {c.position + way * time,
          normalize(ahead + right * (half * across) + up * (half * above))};
}

}  // namespace

Film reference_film(const ReferenceScene& scene, std::uint32_t samples, std::uint64_t seed) {
  Film film;
  film.width = film.crop_width = scene.scene.options.width;
  film.height = film.crop_height = scene.scene.options.height;
  film.pixels.resize(std::size_t(film.width) * std::size_t(film.height));
  const Shutter shutter = scene.scene.camera.shutter;
  const Vec3d sky = open_sky(scene.scene);
  for (std::size_t i = 0; i < film.pixels.size(); ++i) {
    PixelSums& pixel = film.pixels[i];
    const double px = double(i % std::size_t(film.width)), py = double(i / std::size_t(film.width));
    for (std::uint32_t sample = 0; sample < samples; ++sample) {
      Rng rng(seed, i, sample);
      double passed = 0;
      for (int c = 0; c < 3; ++c) {  // each a picture by itself
        const auto [u, v] = rng.uniform2();
        const double time = shutter.at(double(rng.uniform()));
        Tracer tracer(scene, sky, time, c, rng);
        const auto [radiance, of_channel] =
            tracer.trace(camera_ray(scene.scene, px + double(u), py + double(v), time));
        pixel.sum[c] += radiance;
        pixel.sum_squares[c] += radiance * radiance;
        passed += of_channel;
      }
      pixel.alpha += 1 - passed;
      ++pixel.samples;
    }
  }
  return film;
}

}  // namespace pvol::test
