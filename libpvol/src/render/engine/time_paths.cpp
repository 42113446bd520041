#include "render/engine/time_paths.h"

#include <tbb/task_arena.h>

#include <algorithm>
#include <ctime>
#include <mutex>

#include "pvol/math/parallel.h"
#include "render/engine/passes.h"
#include "render/engine/tiles/tile_renderer.h"
#include "render/path/film_layers.h"

namespace pvol::detail {
namespace {

constexpr double kLeastSeconds = 0.02;  // of each thread
constexpr double kColdShare = 0.5;      // of those, before the clock counts
constexpr double kShareOfTime = 0.01;   // of the render
constexpr int kMostPaths = 8192;        // of the small picture at most, for each thread
constexpr int kPathsOfTile = 2048;      // kernels want many at once

/// Samples that a pixel of the small picture gets at once, as in the last pass of the render: they
/// share what is in the caches.
int samples_at_once(const RenderOptions& o) {
  return int(std::clamp(samples_of_part(o) / 2, 1.0, double(kMostOfEqualPass)));
}

/// A small picture, rendered in passes, whose samples are timed.
class SmallRender {
 public:
  SmallRender(const PathSetup& setup, int most_paths, const Clock& clock)
      : setup_(setup.in_small(most_paths / samples_at_once(setup.options))),
        tiles_(setup_),
        at_once_(samples_at_once(setup.options)),
        clock_(clock),
        film_(make_film(setup_.options)),
        tile_height_(parts(kPathsOfTile, film_.crop_width * at_once_)) {}

  /// Gives pixels their samples, as long as goes_on(what is done). Begins anew each time.
  template <class GoesOn>
  [[nodiscard]] TimedPaths run_pass(const GoesOn& goes_on) {
    film_ = make_film(setup_);
    constexpr int kStride = 514229;  // a prime: tasks far from each other, and all of them
    const SampleTargets targets{.all = std::uint32_t(at_once_)};
    const int tasks = parts(film_.crop_height, tile_height_);
    TimedPaths all;
    std::mutex mutex;  // of the sum
    const auto run_task = [&](std::size_t i) {
      {
        const std::scoped_lock lock(mutex);
        if (setup_.stopped() || (all.paths > 0 && !goes_on(all))) return;
      }
      const TimedPaths t = time(tile_of(int(std::int64_t(i) * kStride % tasks)), targets);
      const std::scoped_lock lock(mutex);
      all += t;
    };
    parallel_for(0, std::size_t(tasks), run_task);
    return all;
  }

 private:
  static int parts(int whole, int part) { return (whole + part - 1) / part; }

  [[nodiscard]] ImagePart tile_of(int task) const {
    const int y = task * tile_height_;
    return {0, y, film_.crop_width, std::min(tile_height_, film_.crop_height - y)};
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
  const Clock& clock_;
  Film film_;
  int tile_height_;
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

TimedPaths time_paths(const PathSetup& setup, double samples, const Clock& clock) {
  const int threads = tbb::this_task_arena::max_concurrency();
  SmallRender small(setup, kMostPaths * threads, clock);
  const double least = kLeastSeconds * threads;
  // The first paths wait for memory that later ones find in the caches.
  const TimedPaths cold =
      small.run_pass([&](const TimedPaths& t) { return t.seconds < kColdShare * least; });
  TimedPaths all = small.run_pass([&](const TimedPaths& t) {
    return t.seconds < std::max(least, kShareOfTime * samples * t.seconds_of_path());
  });
  all.cold_seconds = cold.seconds;
  return all;
}

}  // namespace pvol::detail
