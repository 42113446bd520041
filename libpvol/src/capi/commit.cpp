// Commits of the C API: in whose threads they work, how far they are, and how they end early.
#include <tbb/info.h>
#include <tbb/task_arena.h>
#include <tbb/task_group.h>

#include <algorithm>

#include "capi/build.h"
#include "capi/guard.h"
#include "pvol/math/parallel.h"

namespace pvol::detail {
namespace {

/// Makes a commit known to pvol_cancel as long as it runs.
class Running {
 public:
  Running(pvol_volume& volume, tbb::task_group_context& context) : volume_(volume) {
    const std::scoped_lock lock(volume_.cancelling);
    volume_.cancel = [&context] { context.cancel_group_execution(); };
  }
  ~Running() {
    const std::scoped_lock lock(volume_.cancelling);
    volume_.cancel = nullptr;
  }
  Running(const Running&) = delete;
  Running& operator=(const Running&) = delete;

 private:
  pvol_volume& volume_;
};

/// Calls work() as a task of the context, on this thread or one of the arena; whether it was
/// cancelled meanwhile.
template <class Work>
[[nodiscard]] bool run_in(tbb::task_group_context& context, const pvol_commit_options& o,
                          const Work& work) {
  bool cancelled = false;
  const auto in_group = [&] {
    tbb::task_group group(context);
    cancelled = group.run_and_wait(work) == tbb::canceled;
  };
  if (o.threads > 0) {
    tbb::task_arena(std::min(o.threads, tbb::info::default_concurrency())).execute(in_group);
  } else if (o.arena != nullptr) {
    static_cast<tbb::task_arena*>(o.arena)->execute(in_group);
  } else {
    in_group();
  }
  return cancelled;
}

/// Refuses boxes of changes where nobody set the samples that changed: those of before may be gone.
void check_changes(const Settings& settings) {
  for (const FieldSamples& f : settings.fields) {
    if (f.changed.empty() || !std::holds_alternative<FieldSamples::Same>(f.from)) continue;
    throw Error(
        "pvol_set_changed describes new samples, but none were set since the last commit; set the "
        "samples first, also where the same memory holds them");
  }
}

void check(const pvol_commit_options& o) {
  require_cleared(o.reserved);
  if (o.threads < 0) {
    throw Error("found a commit with " + std::to_string(o.threads) +
                " threads, expected 0 or more; 0 uses all of the machine's");
  }
}

void commit(pvol_volume& volume, const pvol_commit_options& o) {
  check(o);
  check_changes(volume.settings);
  tbb::task_group_context context;
  const Progress progress = [&](double done) {
    const bool goes_on = o.progress == nullptr || o.progress(o.user, done) == 0;
    if (!goes_on || context.is_group_execution_cancelled()) throw Cancelled{};
  };
  std::unique_ptr<const Committed> made;
  // A task group passes on what its work throws, but not once it was cancelled.
  std::exception_ptr thrown;
  bool cancelled = false;
  {
    const Running running(volume, context);
    cancelled = run_in(context, o, [&] {
      try {
        made = build(volume.settings, volume.committed.get(), progress);
      } catch (...) {
        thrown = std::current_exception();
      }
    });
  }
  if (cancelled) throw Cancelled{};
  if (thrown) std::rethrow_exception(thrown);
  volume.committed = std::move(made);
  for (FieldSamples& f : volume.settings.fields) {
    if (!std::holds_alternative<FieldSamples::None>(f.from)) f.from = FieldSamples::Same{};
    f.changed.clear();
  }
}

}  // namespace
}  // namespace pvol::detail

extern "C" {

pvol_status pvol_commit(pvol_volume* volume, const pvol_commit_options* options) {
  return pvol::detail::guarded(volume, [&] {
    pvol::detail::commit(*volume, options == nullptr ? pvol_commit_options{} : *options);
  });
}

void pvol_cancel(pvol_volume* volume) {
  if (volume == nullptr) return;
  const std::scoped_lock lock(volume->cancelling);
  if (volume->cancel) volume->cancel();
}

}  // extern "C"
