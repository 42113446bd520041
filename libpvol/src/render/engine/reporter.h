// Progress of a render, and the wish to stop it.
#pragma once

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <exception>
#include <mutex>
#include <stop_token>
#include <thread>

#include "pvol/render/render.h"

namespace pvol::detail {

/// Reports when work is added and, however long single paths are, ten times a second; remembers
/// wishes to stop and to see the film.
class Reporter {
 public:
  Reporter(const RenderCallbacks& by, std::uint64_t total)
      : progress_(by.progress), wants_film_(by.wants_film), total_(total) {
    if (progress_) watch_ = std::jthread([this](const std::stop_token& ended) { watch(ended); });
  }

  /// Samples of the whole render, as far as known.
  void expect(std::uint64_t total) { total_ = total; }

  void add(std::uint64_t samples) {
    done_ += samples;
    if (progress_) report();
  }

  /// The last report, when no thread is at work. Throws what `progress` threw.
  void finish() {
    if (watch_.joinable()) {
      watch_.request_stop();
      watch_.join();
    }
    if (thrown_) std::rethrow_exception(thrown_);
    if (progress_) (void)progress_(done_, total_);
  }

  [[nodiscard]] const std::atomic<bool>& stop() const { return stop_; }

  /// Whether no tile is to be begun: to stop, or for somebody to see the film.
  [[nodiscard]] bool pause() const { return stop_ || pause_; }

  /// Whether somebody wanted to see the film, who now does.
  [[nodiscard]] bool take_pause() { return pause_.exchange(false); }

 private:
  void report() {
    const std::unique_lock lock(mutex_, std::try_to_lock);
    if (!lock) return;
    if (!progress_(done_, total_)) stop_ = true;
    if (wants_film_ && wants_film_()) pause_ = true;
  }

  void watch(const std::stop_token& ended) {
    std::mutex mutex;
    std::condition_variable_any never;
    std::unique_lock lock(mutex);
    while (!ended.stop_requested()) {
      never.wait_for(lock, ended, std::chrono::milliseconds(100), [] { return false; });
      try {
        if (!ended.stop_requested()) report();
      } catch (...) {  // has no caller on this thread
        thrown_ = std::current_exception();
        stop_ = true;
        return;
      }
    }
  }

  const Progress& progress_;
  const std::function<bool()>& wants_film_;
  std::atomic<std::uint64_t> total_, done_ = 0;
  std::atomic<bool> stop_ = false, pause_ = false;
  std::mutex mutex_;
  std::exception_ptr thrown_;
  std::jthread watch_;  // last: it uses all others
};

}  // namespace pvol::detail
