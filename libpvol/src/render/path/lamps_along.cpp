#include "render/path/lamps_along.h"

#include <algorithm>
#include <cmath>

#include "render/path/local_medium.h"
#include "volume/cell_look_up.h"

namespace pvol::detail {
namespace {

/// Places that are looked at for each lamp, and how much more than a collision one of them counts
/// (THEORY.md, T5.25).
constexpr int kPlaces = 4;
constexpr double kMore = 8;

/// The share of light from a place that collisions there bring, of this extinction, where flights
/// look at places with this density.
double share_of_collisions(double extinction, double pdf) {
  return extinction / (extinction + kMore * pdf);
}

/// The luminance of what a lamp brings to a place, about; 0 only where it brings nothing.
double brought_to(Vec3d place, const LightSource& light) {
  return double(luminance(std::visit(
      [&](const auto& l) {
        return l.irradiance_on({place, place});
      },
      light)));
}

/// Whether a flight certainly ends before this share of the angles at which a lamp sees its ray: by
/// an angle's sine, which is not above it, and by its arc. Most flights in dense volumes do, and
/// angles take long.
bool ends_before(double share, const FlightThrough& f, Vec3d lamp) {
  if (!(f.length < f.box.t1)) return false;
  const Vec3d from = f.world.at(f.box.t0) - lamp, end = f.world.at(f.box.t1) - lamp;
  const double flown = f.length - f.box.t0;
  const double sine = length(cross(from, end)) / (length(from) * length(end));
  return flown < share * sine * (length(from) - flown);
}

/// The density of a phase function for choices: never 0, since lamps have an extent.
float likely(const PhaseFunction& phase, Vec3f from, Vec3f to) {
  constexpr float kLeast = 1e-3f;
  return pdf_phase(phase, from, to) + kLeast;
}

}  // namespace

EvenAngles::EvenAngles(Vec3d lamp, const Ray& ray, Span span) {
  const Vec3d way = lamp - ray.o;
  nearest_ = dot(way, ray.d);
  // Of a ray through the lamp nearly any distance will do.
  apart_ = std::max(length(way - ray.d * nearest_), 1e-6 * (span.t1 - span.t0));
  begin_ = span.t0;
  all_ = angle_up_to(span.t1);
}

/// Not by a difference of arcs, which would be 0 for a lamp far before or behind the span.
double EvenAngles::angle_up_to(double t) const {
  return std::atan2(apart_ * (t - begin_), apart_ * apart_ + (begin_ - nearest_) * (t - nearest_));
}

EvenAngles::Turn EvenAngles::turn(double share) const {
  return {std::cos(share * all_), std::sin(share * all_)};
}

double EvenAngles::at(Turn angle) const {
  const double first = (begin_ - nearest_) / apart_;
  return begin_ + apart_ * (1 + first * first) * angle.sine / (angle.cosine - first * angle.sine);
}

double EvenAngles::share_up_to(double t) const { return angle_up_to(t) / all_; }

double EvenAngles::pdf(double t) const {
  const double along = t - nearest_;
  return apart_ / (all_ * (apart_ * apart_ + along * along));
}

CollidingFlight::CollidingFlight(const FlightThrough& f)
    : flight(f),
      extinction(f.enters()
                     ? double(extinction_in_cells(f.volume.volume, f.cells.at(f.length), f.time))
                     : 0) {}

float share_of_collision(const CollidingFlight& f, const Lamp& lamp) {
  if (lamp.power == 0 || !(f.extinction > 0)) return 1;
  const FlightThrough& flight = f.flight;
  const double pdf = EvenAngles(lamp.position, flight.world, flight.box).pdf(flight.length);
  return float(share_of_collisions(f.extinction, pdf));
}

std::optional<LampPoint> draw_lamp_point(const FlightThrough& f, const LightSource& light,
                                         const Lamp& lamp, Rng& rng) {
  const double u = double(rng.uniform());
  if (ends_before(u / kPlaces, f, lamp.position)) return std::nullopt;
  const EvenAngles angles(lamp.position, f.world, f.box);
  const MediumComponent& component = f.volume.choose_component(rng);
  const Vec3f d(f.world.d);
  double sum = 0, chosen = 0, factor = 0, collided = 0;
  EvenAngles::Turn angle = angles.turn(u / kPlaces);
  const EvenAngles::Turn step = angles.turn(1.0 / kPlaces);
  for (int k = 0; k < kPlaces; ++k, angle = angle * step) {
    const double t = angles.at(angle);
    if (!(t < f.length)) break;
    const double mu = double(extinction_in_cells(f.volume.volume, f.cells.at(t), f.time));
    if (!(mu > 0)) continue;
    const Vec3d place = f.world.at(t);
    const double pdf = angles.pdf(t);
    const double share = share_of_collisions(mu, pdf);
    const double scattered = mu / (kPlaces * pdf) * (1 - share);
    const double seen = brought_to(place, light) *
                        double(likely(component.phase, d, Vec3f(normalize(lamp.position - place))));
    if (!(scattered * seen > 0) || !std::isfinite(seen)) continue;
    sum += scattered * seen;
    if (double(rng.uniform()) * sum < scattered * seen) {
      chosen = t, factor = 1 / seen, collided = share;
    }
  }
  if (!(sum > 0)) return std::nullopt;
  const Vec3d place = f.world.at(chosen);
  const LightSample l = sample_light(light, place, rng);
  const float p = pdf_phase(component.phase, d, l.direction);
  const float share = l.pdf > 0 ? balance(p, l.pdf) : p;
  const Rgb color = local_color({&f.volume, f.cells.at(chosen)}, f.time);
  const Rgb albedo = component.albedo * color * f.volume.volume.medium.extinction_color;
  return LampPoint{place, l, albedo * (share * float(sum * factor)), float(sum * factor),
                   float(collided)};
}

}  // namespace pvol::detail
