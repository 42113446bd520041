// The loops of ray_kernels.h for one way of look-up.
#pragma once

#include "capi/ray_kernels.h"
#include "pvol/track/transmittance.h"
#include "pvol/volume/extinction_source.h"

namespace pvol::detail {

/// A segment of which look-ups ask for the handle alone.
[[nodiscard]] inline Segment segment_with(LeafHandle leaf) {
  Segment s{};
  s.leaf = leaf;
  return s;
}

/// Transmittances by other than flights. Not inlined: they are the same whatever decides
/// collisions.
template <class Field>
[[nodiscard, gnu::noinline]] float transmittance_by_look_ups(Transmittance estimator,
                                                             const Field& field, RayWalk& walk,
                                                             CallerNumbers& numbers) {
  NoTally none;
  return estimator == Transmittance::residual_ratio
             ? transmittance<Transmittance::residual_ratio, Tracker::delta>(walk, field, numbers,
                                                                            none)
             : transmittance<Transmittance::ratio, Tracker::delta>(walk, field, numbers, none);
}

/// Sets the loops that ask whether the extinction exceeds a number.
template <LookUp kLookUp, Squeeze kSqueeze, bool kShared>
void set_decisions(RayKernels& k) {
  k.exceeds = [](const VolumeField& f, const RayWalk& walk, LeafHandle leaf, double t, float mu) {
    NoTally none;
    return make_field<kLookUp, kSqueeze, kShared>(f).exceeds(segment_with(leaf), walk.point(t), mu,
                                                             none);
  };
  k.fly = [](const VolumeField& f, RayWalk& walk, CallerNumbers& numbers) {
    NoTally none;
    return free_flight<Tracker::decomposition>(walk, make_field<kLookUp, kSqueeze, kShared>(f),
                                               numbers, none);
  };
  k.transmittance = [](const VolumeField& f, Transmittance estimator, RayWalk& walk,
                       CallerNumbers& numbers) {
    NoTally none;
    const auto field = make_field<kLookUp, kSqueeze, kShared>(f);
    return estimator == Transmittance::analog
               ? transmittance<Transmittance::analog, Tracker::decomposition>(walk, field, numbers,
                                                                              none)
               : transmittance_by_look_ups(estimator, PlainField{field.source}, walk, numbers);
  };
}

/// Those that need the extinction itself.
template <LookUp kLookUp, bool kShared>
[[nodiscard]] RayKernels look_up_kernels() {
  RayKernels k{};
  k.next = [](RayWalk& walk, Segment& segment) {
    const auto s = walk.next();
    if (s) segment = *s;
    return s.has_value();
  };
  k.extinction = [](const VolumeField& f, const RayWalk& walk, LeafHandle leaf, double t) {
    return extinction_source<kLookUp, kShared>(f)(segment_with(leaf), walk.point(t));
  };
  if constexpr (has_closed_form(kLookUp)) {
    k.depth = [](const VolumeField& f, RayWalk& walk) {
      NoTally none;
      return optical_depth(walk, make_field<kLookUp, Squeeze::none, kShared>(f), none);
    };
  }
  k.fly_rgb = [](const VolumeField& f, Rgb share, Rgb throughput, RayWalk& walk,
                 CallerNumbers& numbers) {
    NoTally none;
    ChromaticFlight flight =
        chromatic_flight(walk.local(), make_field<kLookUp, Squeeze::none, kShared>(f), share,
                         throughput, numbers, none);
    if (flight.collided) flight.t = walk.world(flight.t);
    return flight;
  };
  k.transmittance_rgb = [](const VolumeField& f, Rgb share, RayWalk& walk, CallerNumbers& numbers) {
    NoTally none;
    return chromatic_transmittance(walk.local(), make_field<kLookUp, Squeeze::none, kShared>(f),
                                   share, numbers, none);
  };
  return k;
}

template <LookUp kLookUp, bool kShared>
[[nodiscard]] RayKernels find_ray_kernels_with(Squeeze squeeze) {
  RayKernels k = look_up_kernels<kLookUp, kShared>();
  visit_squeeze<kLookUp>(squeeze, [&](auto kind) { set_decisions<kLookUp, kind, kShared>(k); });
  return k;
}

template <LookUp kLookUp>
RayKernels find_ray_kernels_of(const RayKind& kind) {
  if constexpr (has_closed_form(kLookUp)) {
    if (kind.shared) return find_ray_kernels_with<kLookUp, true>(kind.squeeze);
  }
  return find_ray_kernels_with<kLookUp, false>(kind.squeeze);
}

}  // namespace pvol::detail
