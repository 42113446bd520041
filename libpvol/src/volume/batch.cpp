// Batches of rays: by lanes where they serve, else ray by ray.
#include "pvol/volume/batch.h"

#include <optional>
#include <utility>

#include "pvol/embed.h"
#include "volume/batch_rays.h"
#include "volume/check_estimator.h"
#include "volume/simd/batch_kernels.h"
#include "volume/simd/choose_batch_kernels.h"

namespace pvol {

/// What kernels read. Neither moves nor is copied: its parts refer to each other.
struct detail::BatchFieldData {
  std::shared_ptr<const Volume> owner;
  const Volume& volume;
  KernelChoice choice;
  BatchKernels kernels;               // null where the choice is scalar
  std::optional<DenseBounds> bounds;  // likewise
  std::optional<SimdField> field;

  BatchFieldData(std::shared_ptr<const Volume> v, KernelKind kernel)
      : owner(std::move(v)), volume(*owner) {
    const char* const obstacle =
        volume.moving_places != nullptr    ? "the volume moves as a whole"
        : volume.density.motion != nullptr ? "the volume moves"
        // Bounds of every small cube would take what sharing saves.
        : volume.density.shares_samples() ? "the samples are shared"
                                          : simd_obstacle(volume);
    choice = choose_kernel(kernel, obstacle, {.rays = "rays", .subject = "volume"});
    if (choice.kernel == KernelKind::scalar) return;
    kernels = find_batch_kernels(choice.kernel);
    bounds.emplace(make_dense_bounds(volume.density));
    field.emplace(volume.density, *bounds);
  }
  BatchFieldData(const BatchFieldData&) = delete;
  BatchFieldData& operator=(const BatchFieldData&) = delete;
};

namespace {

[[nodiscard]] std::size_t run(detail::BatchKernel kernel, const detail::BatchTask& task) {
  thread_local const std::unique_ptr<detail::BatchMemory> memory =
      std::make_unique<detail::BatchMemory>();
  return kernel(task, *memory);
}

/// Calls set(i, sample(ray, t_max, rng)), or set(i, NaN) for bad rays, which it counts.
template <class T, class Sample>
[[nodiscard]] std::size_t run_scalar(const Volume& volume, const RayBatch& rays,
                                     const BatchNumbers& numbers, T* to, const Sample& sample) {
  std::size_t bad = 0;
  for (std::size_t i = 0; i < rays.size; ++i) {
    const auto ray = detail::read_ray(rays, i);
    if (!ray || !is_finite(volume.density.world_to_cells.point(ray->world.o))) {
      to[i] = std::numeric_limits<T>::quiet_NaN();
      ++bad;
      continue;
    }
    Rng rng = detail::numbers_of(numbers, i);
    to[i] = sample(ray->world, ray->t_max, rng);
  }
  return bad;
}

}  // namespace

BatchField::BatchField(const Volume& volume, KernelKind kernel)
    : BatchField(std::make_shared<const Volume>(volume), kernel) {}

BatchField::BatchField(std::shared_ptr<const Volume> volume, KernelKind kernel)
    : data_(std::make_shared<const detail::BatchFieldData>(std::move(volume), kernel)) {}

std::uint64_t BatchField::bytes() const { return data_->bounds ? data_->bounds->bytes() : 0; }

KernelKind BatchField::kernel() const { return data_->choice.kernel; }
const std::string& BatchField::reason() const { return data_->choice.reason; }

std::size_t sample_flights(const BatchField& field, const RayBatch& rays,
                           const BatchNumbers& numbers, double* t) {
  const detail::BatchFieldData& d = field.data();
  if (d.field) return run(d.kernels.flights, {*d.field, d.volume.density, rays, numbers, t});
  return run_scalar(d.volume, rays, numbers, t, [&](const Ray& ray, double t_max, Rng& rng) {
    return sample_flight(d.volume, ray, t_max, rng).t;
  });
}

std::size_t sample_transmittances(const BatchField& field, const RayBatch& rays,
                                  const BatchNumbers& numbers, Transmittance estimator,
                                  float* through) {
  const detail::BatchFieldData& d = field.data();
  const bool analog = estimator == Transmittance::analog;
  if (d.field && (analog || estimator == Transmittance::ratio)) {
    return run(analog ? d.kernels.analog : d.kernels.ratio,
               {*d.field, d.volume.density, rays, numbers, nullptr, through});
  }
  detail::check_estimator(d.volume, estimator);
  return run_scalar(d.volume, rays, numbers, through, [&](const Ray& ray, double t_max, Rng& rng) {
    return sample_transmittance(d.volume, ray, t_max, rng, estimator);
  });
}

}  // namespace pvol
