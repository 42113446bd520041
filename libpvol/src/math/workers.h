// The threads that a call brings along.
#pragma once

#include <tbb/global_control.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <cstddef>

namespace pvol::detail {

/// An arena of so many threads; 0: one for each hardware thread. The control is the process's: it
/// may only raise the limit, for more threads than there are cores.
struct Workers {
  static constexpr auto kLimit = tbb::global_control::max_allowed_parallelism;
  int threads;
  tbb::global_control allow;
  tbb::task_arena arena;

  explicit Workers(int given)
      : threads(given > 0 ? given : tbb::this_task_arena::max_concurrency()),
        allow(kLimit, std::max(std::size_t(threads), tbb::global_control::active_value(kLimit))),
        arena(threads) {}
};

}  // namespace pvol::detail
