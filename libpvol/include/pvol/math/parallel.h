// Loops in parallel. oneTBB behind them takes half a second to compile in each source that sees it;
// so few do.
#pragma once

#include <algorithm>
#include <atomic>
#include <cstddef>
#include <optional>

namespace pvol {

/// Thrown by loops whose task group, one around them, was cancelled: parts are missing.
struct LoopCancelled {};

/// Throws LoopCancelled where the task group that this is called in was cancelled: for bodies whose
/// steps take long.
void throw_if_cancelled();

/// A part of a loop, begin to end, and what it is a part of.
using PartFunction = void (*)(const void* body, std::size_t begin, std::size_t end);
void parallel_parts(std::size_t begin, std::size_t end, std::size_t grain, const void* body,
                    PartFunction part);

/// Calls body(begin, end) for parts that together are [begin, end), in any order, on the threads of
/// the caller's arena; a part is divided further only where it has more than `grain` steps. What a
/// body throws, the call throws; where a task group around it was cancelled, LoopCancelled.
template <class Body>
void parallel_parts(std::size_t begin, std::size_t end, std::size_t grain, const Body& body) {
  parallel_parts(begin, end, grain, &body, [](const void* b, std::size_t first, std::size_t last) {
    (*static_cast<const Body*>(b))(first, last);
  });
}

/// Calls body(i) for each i of [begin, end).
template <class Body>
void parallel_for(std::size_t begin, std::size_t end, const Body& body) {
  parallel_parts(begin, end, 1, [&](std::size_t first, std::size_t last) {
    for (std::size_t i = first; i != last; ++i) body(i);
  });
}

/// The least i of [0, end) for which wanted(i) is true, if there is one.
template <class Wanted>
[[nodiscard]] std::optional<std::size_t> parallel_find(std::size_t end, std::size_t grain,
                                                       const Wanted& wanted) {
  std::atomic<std::size_t> found = end;
  parallel_parts(0, end, grain, [&](std::size_t first, std::size_t last) {
    for (std::size_t i = first; i < std::min(last, found.load()); ++i) {
      if (!wanted(i)) continue;
      for (std::size_t known = found; i < known && !found.compare_exchange_weak(known, i);) {
      }
      return;
    }
  });
  return found < end ? std::optional(found.load()) : std::nullopt;
}

}  // namespace pvol
