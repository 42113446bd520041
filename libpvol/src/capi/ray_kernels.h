// The loops behind the C API for one kind of field, compiled once for each kind and processor.
#pragma once

#include "capi/caller_numbers.h"
#include "pvol/track/chromatic.h"
#include "pvol/trackers.h"

namespace pvol::detail {

/// Of walks through the field's octree. `leaf` is a handle of the current segment.
struct RayKernels {
  bool (*next)(RayWalk&, Segment&);
  /// mu_t at t of the current segment.
  float (*extinction)(const VolumeField&, const RayWalk&, LeafHandle leaf, double t);
  /// Whether mu < mu_t there; `hi` is the segment's majorant.
  bool (*exceeds)(const VolumeField&, const RayWalk&, LeafHandle leaf, double t, float mu);
  Flight (*fly)(const VolumeField&, RayWalk&, CallerNumbers&);
  float (*transmittance)(const VolumeField&, Transmittance, RayWalk&, CallerNumbers&);
  /// The optical depth; null where there is no closed form.
  double (*depth)(const VolumeField&, RayWalk&);
  ChromaticFlight (*fly_rgb)(const VolumeField&, Rgb share, Rgb throughput, RayWalk&,
                             CallerNumbers&);
  Rgb (*transmittance_rgb)(const VolumeField&, Rgb share, RayWalk&, CallerNumbers&);
};

/// What chooses the loops: a field of samples without a map that stands still.
struct RayKind {
  LookUp look_up;
  Squeeze squeeze;
  bool shared;  ///< it shares samples: nearest or trilinear
};

/// On the processor that the program runs on.
[[nodiscard]] RayKernels find_ray_kernels(const RayKind& kind);

/// The same for the processor that all is compiled for, and for x86-64-v3.
[[nodiscard]] RayKernels find_baseline_ray_kernels(const RayKind& kind);
[[nodiscard]] RayKernels find_v3_ray_kernels(const RayKind& kind);

/// The same for one way of look-up (ray_kernels_of.h), each in a source of its own.
template <LookUp kLookUp>
[[nodiscard]] RayKernels find_ray_kernels_of(const RayKind& kind);

}  // namespace pvol::detail
