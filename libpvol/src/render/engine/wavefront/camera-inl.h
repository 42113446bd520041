// The samples of a tile, and the rays of the camera that they begin with: loops over rays side by
// side, of which the compiler makes vectors, with the bits of camera_ray().

#if defined(PVOL_LANE_CAMERA_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef PVOL_LANE_CAMERA_INL_H
#undef PVOL_LANE_CAMERA_INL_H
#else
#define PVOL_LANE_CAMERA_INL_H
#endif

#include "render/engine/wavefront/wavefront.h"
#include "render/path/camera_rays.h"
#include "volume/simd/enter-inl.h"

HWY_BEFORE_NAMESPACE();
namespace pvol::detail::HWY_NAMESPACE {

/// The samples of a tile, in the order of their slots: pixels by rows, each with those that it
/// lacks.
class Samples {
 public:
  Samples(const ImagePart& tile, const SampleTargets& targets, const Film& film)
      : tile_(tile), targets_(targets), film_(film) {
    find();
  }

  [[nodiscard]] bool any() const { return y_ < tile_.height; }
  [[nodiscard]] PixelSample next() {
    const PixelSample s{film_.x + tile_.x + x_, film_.y + tile_.y + y_,
                        film_.first_sample + number_};
    if (++number_ == end_) ++x_, find();
    return s;
  }

 private:
  const ImagePart& tile_;
  const SampleTargets& targets_;
  const Film& film_;
  int x_ = 0, y_ = 0;
  std::uint32_t number_ = 0, end_ = 0;

  /// Goes to the first pixel from here on that lacks any.
  void find() {
    for (; y_ < tile_.height; x_ = 0, ++y_) {
      for (; x_ < tile_.width; ++x_) {
        const std::size_t pixel = film_.index(tile_.x + x_, tile_.y + y_);
        number_ = film_.pixels[pixel].samples, end_ = targets_.of(pixel);
        if (number_ < end_) return;
      }
    }
  }
};

[[nodiscard]] inline std::uint32_t count_samples(const ImagePart& tile,
                                                 const SampleTargets& targets, const Film& film) {
  std::uint32_t n = 0;
  for (Samples all(tile, targets, film); all.any(); (void)all.next()) ++n;
  return n;
}

/// Where the samples are on the picture, in pixels.
HWY_NOINLINE void find_places(const PathSetup& s, CameraRays& r) {
  std::array<std::uint32_t, 3> seeds{};
  for (std::size_t k = 0; k < r.rays.n; ++k) {
    const PixelSample& sample = r.sample[k];
    if (k == 0 || s.halves || sample.x != r.sample[k - 1].x || sample.y != r.sample[k - 1].y) {
      seeds = seeds_of_points(s, sample, Aside::pixel);
    }
    r.number[k] = number_in_sequence(s, sample);
    for (std::size_t i = 0; i < 3; ++i) r.seeds[i][k] = seeds[i];
  }
  for (std::size_t k = 0; k < r.rays.n; ++k) {
    const auto [u, v] = point_of_square(r.number[k], {r.seeds[0][k], r.seeds[1][k], r.seeds[2][k]});
    r.u[k] = u, r.v[k] = v;
  }
  for (std::size_t k = 0; k < r.rays.n; ++k) {
    r.x[k] = r.sample[k].x + 0.5 + double(s.view.filter(r.u[k]));
    r.y[k] = r.sample[k].y + 0.5 + double(s.view.filter(r.v[k]));
  }
}

/// Rays of a pinhole camera that stands still.
HWY_NOINLINE void find_pinhole_rays(const Projection& projection, CameraRays& r) {
  const Projection p = projection;
  const Vec3d o = p.origin();
  EnteringRays& e = r.rays;
  for (std::size_t k = 0; k < e.n; ++k) {
    const Vec3d d = p.towards(r.x[k], r.y[k]);
    e.o[0][k] = o.x, e.o[1][k] = o.y, e.o[2][k] = o.z;
    e.d[0][k] = d.x, e.d[1][k] = d.y, e.d[2][k] = d.z;
  }
  normalize_directions(e);
}

/// Those of any other.
HWY_NOINLINE void find_rays_one_by_one(const PathSetup& s, CameraRays& r) {
  EnteringRays& e = r.rays;
  for (std::size_t k = 0; k < e.n; ++k) {
    const Ray ray = camera_ray(s, r.sample[k]);
    for (int axis = 0; axis < 3; ++axis) {
      e.o[std::size_t(axis)][k] = ray.o[axis], e.d[std::size_t(axis)][k] = ray.d[axis];
    }
  }
}

/// Takes samples, as many as fit or there are, and makes their rays. `ray` is the slot.
inline void take_samples(const PathSetup& s, Samples& from, CameraRays& r) {
  EnteringRays& e = r.rays;
  r.next = 0;
  for (e.n = 0; e.n < EnteringRays::kMost && from.any(); ++e.n) {
    r.sample[e.n] = from.next();
    e.ray[e.n] = r.slots++;
    e.t0[e.n] = 0, e.t1[e.n] = kEndless;
  }
  if (s.view.projection.is_pinhole() && !s.view.motion) {
    find_places(s, r);
    find_pinhole_rays(s.view.projection, r);
  } else {
    find_rays_one_by_one(s, r);
  }
}

}  // namespace pvol::detail::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif  // per-target include guard
