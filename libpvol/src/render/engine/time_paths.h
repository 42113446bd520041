// What camera paths cost, by following some of them before a render.
#pragma once

#include <cstdint>
#include <functional>

#include "pvol/render/counts.h"
#include "render/path/path_setup.h"

namespace pvol::detail {

/// Seconds since some moment; from any thread.
using Clock = std::function<double()>;

/// CPU seconds of the calling thread, where the system tells them, else of the process.
[[nodiscard]] double thread_seconds();

/// Paths that were followed and thrown away.
struct TimedPaths {
  std::uint64_t paths = 0;
  double seconds = 0;       ///< of all threads together
  double cold_seconds = 0;  ///< of paths before them, which do not count
  Counts counts{};          ///< where the setup counts

  [[nodiscard]] double seconds_of_path() const { return paths > 0 ? seconds / double(paths) : 0; }
  TimedPaths& operator+=(const TimedPaths& t);
};

/// Times paths that are spread over the picture and traced as in a render of so many samples:
/// guided where the setup is, on all threads of the arena that it is called in. They take 20 ms on
/// each thread or 1 % of the render, whichever is more, and a tile beyond, and are some thousand at
/// most; others before them warm the caches for half as long. Ends early once the setup says stop.
/// Throws what kernels throw.
[[nodiscard]] TimedPaths time_paths(const PathSetup& setup, double samples,
                                    const Clock& clock = thread_seconds);

}  // namespace pvol::detail
