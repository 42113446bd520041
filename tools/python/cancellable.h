// Work that takes long, beside the interpreter.
#pragma once

#include <atomic>
#include <functional>

namespace pvol::python {

/// What work asks from time to time: whether it is to end soon, its result unwanted.
using Stop = std::atomic<bool>;

/// Runs work(stop) on a thread of its own, without the interpreter's lock, while the caller's
/// thread looks after signals, some twenty times a second. Once Ctrl-C (or any handler of Python's)
/// raises, `stop` is true; what the handler raised goes on when the work has ended. What the work
/// throws, this throws. To be called with the lock; the work may not touch Python.
void run_cancellable(const std::function<void(const Stop& stop)>& work);

/// The result of work(stop), run so.
template <class Work>
[[nodiscard]] auto cancellable(const Work& work) {
  decltype(work(std::declval<const Stop&>())) result{};
  run_cancellable([&](const Stop& stop) { result = work(stop); });
  return result;
}

}  // namespace pvol::python
