#include "math/parallel.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>
#include <tbb/task_group.h>

namespace pvol {

void parallel_parts(std::size_t begin, std::size_t end, std::size_t grain, const void* body,
                    PartFunction part) {
  if (begin >= end) return;
  // Parts of long loops are long; a cancelled one ends sooner.
  const std::size_t step = 64 * grain;
  tbb::parallel_for(tbb::blocked_range<std::size_t>(begin, end, grain), [=](const auto& range) {
    std::size_t at = range.begin();
    for (; range.end() - at > step; at += step) {
      part(body, at, at + step);
      if (tbb::is_current_task_group_canceling()) return;
    }
    part(body, at, range.end());
  });
  throw_if_cancelled();
}

void throw_if_cancelled() {
  if (tbb::is_current_task_group_canceling()) throw LoopCancelled{};
}

}  // namespace pvol
