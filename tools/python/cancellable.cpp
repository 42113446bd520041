#include "python/cancellable.h"

#include <pybind11/pybind11.h>

#include <chrono>
#include <future>
#include <optional>

namespace pvol::python {
namespace {

constexpr auto kPause = std::chrono::milliseconds(50);

bool is_done_soon(const std::future<void>& done) {
  const pybind11::gil_scoped_release unlocked;
  return done.wait_for(kPause) == std::future_status::ready;
}

}  // namespace

void run_cancellable(const std::function<void(const Stop& stop)>& work) {
  Stop stop = false;
  std::future<void> done = std::async(std::launch::async, [&] { work(stop); });
  std::optional<pybind11::error_already_set> raised;
  const auto look = [&] {
    if (!raised && PyErr_CheckSignals() != 0) raised.emplace();  // takes what was raised
    if (raised) stop = true;
  };
  while (!is_done_soon(done)) look();  // signals reach the main thread alone
  look();
  if (raised) throw *raised;
  done.get();
}

}  // namespace pvol::python
