#include "render/engine/time_paths.h"

#include <tbb/parallel_for.h>
#include <tbb/partitioner.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <ctime>
#include <mutex>

#include "render/engine/passes.h"
#include "render/engine/tiles/tile_renderer.h"
#include "render/path/film_layers.h"
#include "render/scene/small_picture.h"

namespace pvol::detail {
namespace {

constexpr double kLeastSeconds = 0.02;  // of each thread
constexpr double kColdShare = 0.5;      // of those, before the clock counts
constexpr double kShare = 0.01;         // of the render
constexpr int kPaths = 8192;            // of the small picture at most, for each thread

/// Samples that a pixel of the small picture gets at once, as in the last pass of the render: they
/// share what is in the caches.
int samples_at_once(const RenderOptions& o) {
  return int(std::clamp(samples_of_part(o) / 2, 1.0, double(kMostOfEqualPass)));
}

/// The setup for a picture of so many pixels in place of the large one.
PathSetup small_setup(const RenderPlan& plan, const PathSetup& setup, int pixels) {
  Scene scene;
  scene.camera = plan.scene.camera;
  scene.options = in_small(setup.options, pixels);
  PathSetup small = setup;
  small.options = scene.options;
  small.view = CameraSetup(scene);
  return small;
}

/// A small picture, rendered in passes, whose samples are timed.
class SmallRender {
 public:
  SmallRender(const RenderPlan& plan, const PathSetup& setup, Paths paths, int most_paths,
              const Clock& clock)
      : setup_(small_setup(plan, setup, most_paths / samples_at_once(setup.options))),
        tiles_(plan, setup_, paths),
        at_once_(samples_at_once(setup_.options)),
        clock_(clock),
        film_(make_film(setup_.options)) {
    // Kernels in lanes want many paths at once; tracers want more than their own making costs.
    const bool in_lanes = plan.kernel.kind != KernelKind::scalar;
    tile_width_ = in_lanes ? film_.crop_width : std::min(film_.crop_width, 8);
    tile_height_ = in_lanes ? parts(2048, tile_width_ * at_once_) : 1;
  }

  /// Gives pixels their samples, as long as goes_on(what is done). Begins anew each time.
  template <class GoesOn>
  [[nodiscard]] TimedPaths run_pass(const GoesOn& goes_on) {
    clear();
    constexpr int kStride = 514229;  // a prime: tasks far from each other, and all of them
    const SampleTargets targets{.all = std::uint32_t(at_once_)};
    const int tasks = columns() * parts(film_.crop_height, tile_height_);
    TimedPaths all;
    std::mutex mutex;  // of the sum
    const auto run_task = [&](int i) {
      {
        const std::scoped_lock lock(mutex);
        if (setup_.stopped() || (all.paths > 0 && !goes_on(all))) return;
      }
      const TimedPaths t = time(tile_of(int(std::int64_t(i) * kStride % tasks)), targets);
      const std::scoped_lock lock(mutex);
      all += t;
    };
    tbb::parallel_for(0, tasks, run_task, tbb::simple_partitioner());
    return all;
  }

 private:
  void clear() {
    film_ = make_film(setup_.options);
    film_.layers = make_layers(setup_, film_.pixels.size());
    film_.deep = make_deep(setup_, film_.pixels.size());
    start_sums(film_);
  }

  static int parts(int whole, int part) { return (whole + part - 1) / part; }

  [[nodiscard]] int columns() const { return parts(film_.crop_width, tile_width_); }

  [[nodiscard]] ImagePart tile_of(int task) const {
    const int x = task % columns() * tile_width_, y = task / columns() * tile_height_;
    return {x, y, std::min(tile_width_, film_.crop_width - x),
            std::min(tile_height_, film_.crop_height - y)};
  }

  TimedPaths time(const ImagePart& tile, const SampleTargets& targets) {
    TimedPaths t;
    const std::uint64_t before = count_samples(film_, tile);
    const double begin = clock_();
    (void)tiles_.render(tile, targets, film_, t.counts);
    t.seconds = clock_() - begin;
    t.paths = count_samples(film_, tile) - before;
    return t;
  }

  PathSetup setup_;
  TileRenderer tiles_;
  int at_once_;
  int tile_width_, tile_height_;
  const Clock& clock_;
  Film film_;
};

}  // namespace

double thread_seconds() {
#ifdef CLOCK_THREAD_CPUTIME_ID
  timespec t{};
  if (clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t) == 0)
    return double(t.tv_sec) + 1e-9 * double(t.tv_nsec);
#endif
  return double(std::clock()) / CLOCKS_PER_SEC;
}

TimedPaths& TimedPaths::operator+=(const TimedPaths& t) {
  paths += t.paths;
  seconds += t.seconds;
  counts += t.counts;
  return *this;
}

TimedPaths time_paths(const RenderPlan& plan, const PathSetup& setup, Paths paths, double samples,
                      const Clock& clock) {
  const int threads = tbb::this_task_arena::max_concurrency();
  SmallRender small(plan, setup, paths, kPaths * threads, clock);
  const double least = kLeastSeconds * threads;
  // The first paths wait for memory that later ones find in the caches.
  const TimedPaths cold =
      small.run_pass([&](const TimedPaths& t) { return t.seconds < kColdShare * least; });
  TimedPaths all = small.run_pass([&](const TimedPaths& t) {
    return t.seconds < std::max(least, kShare * samples * t.seconds_of_path());
  });
  all.cold_seconds = cold.seconds;
  return all;
}

}  // namespace pvol::detail
