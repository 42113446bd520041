// Walks of the C API: segments, look-ups along them, and flights that go on.
#include <cmath>
#include <new>

#include "capi/rays.h"

namespace pvol::detail {
namespace {

/// A pvol_walk's contents. Walks are copied as bytes, which trivially copyable contents allow.
[[nodiscard]] CapiWalk& in(pvol_walk* walk) {
  return *std::launder(reinterpret_cast<CapiWalk*>(walk));
}
[[nodiscard]] const CapiWalk& in(const pvol_walk* walk) {
  return *std::launder(reinterpret_cast<const CapiWalk*>(walk));
}

[[nodiscard]] const VolumeField& field_of(const CapiWalk& w) { return w.volume->volume->density; }

[[nodiscard]] float extinction(const CapiWalk& w, double t) {
  return w.volume->kernels.extinction(field_of(w), w.walk, w.leaf, t);
}

}  // namespace
}  // namespace pvol::detail

using namespace pvol;
using namespace pvol::detail;

extern "C" {

int pvol_enter(const pvol_volume* volume, const pvol_ray* ray, pvol_walk* walk) {
  if (walk == nullptr) return PVOL_BAD_RAY;
  CapiWalk& w = *new (static_cast<void*>(walk)) CapiWalk;
  w.volume = committed(volume);
  const Entry entry = ray == nullptr ? Entry::bad : enter(w.volume, *ray, w.walk);
  if (entry != Entry::enters) w.volume = nullptr;  // no segments, and nowhere to go on from
  if (entry == Entry::bad) return PVOL_BAD_RAY;
  return entry == Entry::enters ? 1 : 0;
}

int pvol_next(pvol_walk* walk, pvol_segment* segment) {
  CapiWalk& w = in(walk);
  Segment s;
  if (w.volume == nullptr || !w.volume->kernels.next(w.walk, s)) return 0;
  w.leaf = s.leaf;
  *segment = {s.t0, s.t1, s.lo, s.hi};
  return 1;
}

float pvol_walk_density(const pvol_walk* walk, double t) {
  const CapiWalk& w = in(walk);
  if (w.volume == nullptr) return 0;
  const float scale = field_of(w).scale;
  return scale > 0 ? extinction(w, t) / scale : 0;
}

float pvol_walk_extinction(const pvol_walk* walk, double t) {
  const CapiWalk& w = in(walk);
  return w.volume == nullptr ? 0 : extinction(w, t);
}

int pvol_walk_exceeds(const pvol_walk* walk, double t, float mu) {
  const CapiWalk& w = in(walk);
  if (w.volume == nullptr) return 0;
  return w.volume->kernels.exceeds(field_of(w), w.walk, w.leaf, t, mu) ? 1 : 0;
}

int pvol_walk_flight(pvol_walk* walk, pvol_random* random, double* t) {
  CapiWalk& w = in(walk);
  if (w.volume == nullptr) return 0;
  const Flight flight = fly(*w.volume, w.walk, *random);
  if (!flight.collided) return 0;
  w.leaf = w.walk.handle();
  *t = flight.t;
  return 1;
}

float pvol_walk_transmittance(pvol_walk* walk, pvol_estimator estimator, pvol_random* random) {
  CapiWalk& w = in(walk);
  return w.volume == nullptr ? 1 : estimate_transmittance(*w.volume, estimator, w.walk, *random);
}

double pvol_walk_optical_depth(pvol_walk* walk) {
  CapiWalk& w = in(walk);
  if (w.volume == nullptr) return 0;
  if (w.volume->kernels.depth == nullptr) return std::nan("");
  return w.volume->kernels.depth(field_of(w), w.walk);
}

int pvol_resume(pvol_walk* walk, double t, const double direction[3], double t_max) {
  CapiWalk& w = in(walk);
  if (w.volume == nullptr || direction == nullptr || !std::isfinite(t)) return PVOL_BAD_RAY;
  const Cursor from = w.walk.cursor_at(t);
  const Entry entry = resume_ray(*w.volume->volume, from, vec(direction), t_max, w.walk);
  return entry == Entry::enters ? 1 : PVOL_BAD_RAY;
}

void pvol_walk_place(const pvol_walk* walk, double t, double place[3]) {
  const CapiWalk& w = in(walk);
  const Vec3d at = w.volume == nullptr ? Vec3d(std::nan(""))
                                       : w.volume->cells_to_world.point(position(w.walk.point(t)));
  for (int axis = 0; axis < 3; ++axis) place[axis] = at[axis];
}

int pvol_walk_flight_rgb(pvol_walk* walk, const float throughput[3], pvol_random* random, double* t,
                         float weight[3]) {
  CapiWalk& w = in(walk);
  ChromaticFlight flight;
  if (w.volume != nullptr) {
    CallerNumbers numbers(*random);
    const Rgb carried(throughput[0], throughput[1], throughput[2]);
    flight = w.volume->kernels.fly_rgb(field_of(w), w.volume->share, carried, w.walk, numbers);
  }
  for (int c = 0; c < 3; ++c) weight[c] = flight.weight[c];
  if (!flight.collided) return 0;
  w.leaf = w.walk.handle();
  *t = flight.t;
  return 1;
}

void pvol_walk_transmittance_rgb(pvol_walk* walk, pvol_random* random, float transmittance[3]) {
  CapiWalk& w = in(walk);
  Rgb passed(1.0f);
  if (w.volume != nullptr) {
    CallerNumbers numbers(*random);
    passed = w.volume->kernels.transmittance_rgb(field_of(w), w.volume->share, w.walk, numbers);
  }
  for (int c = 0; c < 3; ++c) transmittance[c] = passed[c];
}

}  // extern "C"
