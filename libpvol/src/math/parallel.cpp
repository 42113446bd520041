#include "math/parallel.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>
#include <tbb/task_group.h>

namespace pvol {

void parallel_parts(std::size_t begin, std::size_t end, std::size_t grain, const void* body,
                    PartFunction part) {
  if (begin >= end) return;
  tbb::parallel_for(tbb::blocked_range<std::size_t>(begin, end, grain),
                    [=](const auto& range) { part(body, range.begin(), range.end()); });
  if (tbb::is_current_task_group_canceling()) throw LoopCancelled{};
}

}  // namespace pvol
