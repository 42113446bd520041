// Many rays at once, by the C API.
#include <limits>
#include <new>

#include "capi/rays.h"
#include "pvol/volume/batch.h"
#include "volume/batch_rays.h"

namespace pvol::detail {
namespace {

[[nodiscard]] VectorArray vectors_of(const pvol_vectors& v) {
  const bool doubles = v.type == PVOL_DOUBLE;
  const std::int64_t size = doubles ? 8 : 4;
  const bool packed = v.stride == 0 && v.component_stride == 0;
  return {v.values, doubles, packed ? 3 * size : v.stride, packed ? size : v.component_stride};
}

[[nodiscard]] NumberArray numbers_of(const pvol_vectors& v) {
  const bool doubles = v.type == PVOL_DOUBLE;
  return {v.values, doubles, v.stride == 0 ? (doubles ? 8 : 4) : v.stride};
}

[[nodiscard]] RayBatch batch_of(const pvol_rays& rays) {
  return {rays.count, vectors_of(rays.origins), vectors_of(rays.directions),
          numbers_of(rays.t_max)};
}

[[nodiscard]] BatchNumbers streams_of(const pvol_streams& s) {
  return {s.seed, s.first, s.sample, s.streams};
}

/// Calls of a batch through a volume that was not committed, or of rays that are not there.
template <class Number>
[[nodiscard]] std::size_t refuse_all(const pvol_rays& rays, Number* results) {
  for (std::size_t i = 0; results != nullptr && i < rays.count; ++i) {
    results[i] = std::numeric_limits<Number>::quiet_NaN();
  }
  return rays.count;
}

/// What run() returns, which fails for want of memory alone.
template <class Number, class Run>
[[nodiscard]] std::size_t or_refuse(const pvol_rays& rays, Number* results, const Run& run) {
  try {
    return run();
  } catch (const std::bad_alloc&) {
    return refuse_all(rays, results);
  }
}

[[nodiscard]] bool has_numbers(const pvol_vectors& v) {
  return v.type == PVOL_FLOAT || v.type == PVOL_DOUBLE;
}

[[nodiscard]] bool usable(const Committed* c, const pvol_rays& rays) {
  return c != nullptr && rays.origins.values != nullptr && rays.directions.values != nullptr &&
         has_numbers(rays.origins) && has_numbers(rays.directions) && has_numbers(rays.t_max);
}

[[nodiscard]] std::size_t optical_depths(const Committed& c, const RayBatch& rays, double* depth) {
  std::size_t bad = 0;
  for (std::size_t i = 0; i < rays.size; ++i) {
    const auto ray = read_ray(rays, i);
    RayWalk walk;
    const Entry entry = ray ? enter_ray(*c.volume, ray->world, ray->t_max, walk) : Entry::bad;
    bad += entry == Entry::bad;
    depth[i] = entry == Entry::bad      ? std::numeric_limits<double>::quiet_NaN()
               : entry == Entry::misses ? 0
                                        : c.kernels.depth(c.volume->density, walk);
  }
  return bad;
}

}  // namespace
}  // namespace pvol::detail

using namespace pvol;
using namespace pvol::detail;

extern "C" {

size_t pvol_flights(const pvol_volume* volume, const pvol_rays* rays, const pvol_streams* streams,
                    double* t) {
  if (rays == nullptr) return 0;
  const Committed* const c = committed(volume);
  if (!usable(c, *rays) || streams == nullptr || t == nullptr) return refuse_all(*rays, t);
  return or_refuse(*rays, t, [&] {
    return sample_flights(*c->batch, batch_of(*rays), streams_of(*streams), t);
  });
}

size_t pvol_transmittances(const pvol_volume* volume, const pvol_rays* rays,
                           pvol_estimator estimator, const pvol_streams* streams,
                           float* transmittance) {
  if (rays == nullptr) return 0;
  const Committed* const c = committed(volume);
  const bool closed = c != nullptr && c->kernels.depth != nullptr;
  if (!usable(c, *rays) || streams == nullptr || transmittance == nullptr ||
      !is_estimator(estimator) || (estimator == PVOL_EXACT && !closed)) {
    return refuse_all(*rays, transmittance);
  }
  return or_refuse(*rays, transmittance, [&] {
    return sample_transmittances(*c->batch, batch_of(*rays), streams_of(*streams),
                                 estimator_of(estimator), transmittance);
  });
}

size_t pvol_optical_depths(const pvol_volume* volume, const pvol_rays* rays, double* depth) {
  if (rays == nullptr) return 0;
  const Committed* const c = committed(volume);
  if (!usable(c, *rays) || depth == nullptr || c->kernels.depth == nullptr) {
    return refuse_all(*rays, depth);
  }
  return optical_depths(*c, batch_of(*rays), depth);
}

}  // extern "C"
