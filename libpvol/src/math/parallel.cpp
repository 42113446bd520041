#include "pvol/math/parallel.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>
#include <tbb/task_group.h>

#include <atomic>

namespace pvol {
namespace {

/// Orders parts of a loop after what was before it, and before what follows. oneTBB does so by
/// itself, but ThreadSanitizer, for which it is not compiled, sees this alone.
class Order {
 public:
  Order() { steps_.fetch_add(1, std::memory_order_release); }
  void see() const { (void)steps_.load(std::memory_order_acquire); }

  /// Of a part, while it lasts.
  class Part {
   public:
    explicit Part(Order& order) : order_(order) { order_.see(); }
    ~Part() { order_.steps_.fetch_add(1, std::memory_order_release); }
    Part(const Part&) = delete;
    Part& operator=(const Part&) = delete;

   private:
    Order& order_;
  };

 private:
  std::atomic<unsigned> steps_{0};
};

}  // namespace

void parallel_parts(std::size_t begin, std::size_t end, std::size_t grain, const void* body,
                    PartFunction part) {
  if (begin >= end) return;
  // Parts of long loops are long; a cancelled one ends sooner.
  const std::size_t step = 64 * grain;
  Order order;
  tbb::parallel_for(tbb::blocked_range<std::size_t>(begin, end, grain), [&](const auto& range) {
    const Order::Part ordered(order);
    std::size_t at = range.begin();
    for (; range.end() - at > step; at += step) {
      part(body, at, at + step);
      if (tbb::is_current_task_group_canceling()) return;
    }
    part(body, at, range.end());
  });
  order.see();
  throw_if_cancelled();
}

void throw_if_cancelled() {
  if (tbb::is_current_task_group_canceling()) throw LoopCancelled{};
}

}  // namespace pvol
