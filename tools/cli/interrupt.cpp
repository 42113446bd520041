// Signals are blocked in all threads but taken by one that does nothing else: it may do what no
// handler may, and never waits for what the others are doing.
#include "cli/interrupt.h"

#include <fmt/format.h>
#include <poll.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <chrono>
#include <csignal>
#include <initializer_list>
#include <mutex>
#include <system_error>
#include <thread>
#include <utility>

#include "cli/cli.h"
#include "pvol/formats/atomic_file.h"

namespace pvol::cli {
namespace {

/// What a signal does next: end the tool, ask it to save, end it though it was asked to save; last,
/// one is at it.
enum class Phase { plain, saving, stopping, ending };

// A signal is the process's, and so is this. All of it may be used until the process is gone:
// nothing has a destructor that does anything.
std::atomic<Phase> phase = Phase::plain;
std::atomic<bool> checkpoint_requested = false;
std::atomic<bool> outlives_readers = false;  // whoever began the tool ignores SIGPIPE
std::atomic<std::size_t> line_width = 0;
std::mutex notes;  // of what follows; nobody waits for anything while holding it
std::array<char, 256> stage_now{};
const std::function<void()>* tell_now = nullptr;

[[nodiscard]] bool becomes(Phase from, Phase to) { return phase.compare_exchange_strong(from, to); }

[[nodiscard]] bool is_ignored(int signal) {
  struct sigaction action {};
  return sigaction(signal, nullptr, &action) == 0 && action.sa_handler == SIG_IGN;
}

/// Those that end a tool: wishes of users and of schedulers (SIGUSR2 announces the end of a job
/// under Grid Engine), and the limit of CPU time.
constexpr std::initializer_list<int> kEndingSignals = {SIGINT, SIGTERM, SIGHUP, SIGUSR2, SIGXCPU};

/// Those of them that are not ignored: nohup and shells in the background mean it.
[[nodiscard]] sigset_t set_of(std::initializer_list<int> signals) {
  sigset_t set;
  sigemptyset(&set);
  for (const int s : signals) {
    if (!is_ignored(s)) sigaddset(&set, s);
  }
  return set;
}

/// One line, without memory of its own, which there may be none of. It covers the line that stands
/// on the terminal.
void say(const char* tool, const char* what, const char* more) {
  std::array<char, 1024> text;
  const std::size_t width = on_terminal() ? std::min<std::size_t>(line_width, 400) : 0;
  const char* home = width > 0 ? "\r" : "";
  const auto end = fmt::format_to_n(text.data(), text.size(), "{}{:{}}{}{}: {}{}\n", home, "",
                                    width, home, tool, what, more);
  // Nobody could be told that nobody can be told.
  [[maybe_unused]] const auto written =
      ::write(STDERR_FILENO, text.data(), std::min(end.size, text.size()));
}

[[noreturn]] void end_by(int signal, const char* tool) {
  const bool again = phase.exchange(Phase::ending) == Phase::stopping;
  // From here on a further signal ends the process by itself, should a disk or the reader of stderr
  // be stuck.
  const sigset_t all = set_of(kEndingSignals);
  pthread_sigmask(SIG_UNBLOCK, &all, nullptr);
  formats::abandon_writes();
  const std::scoped_lock lock(notes);
  if (again) {
    say(tool, "interrupted again; unsaved work is lost", "");
  } else {
    const char* stage = stage_now.data();
    say(tool, *stage == '\0' ? "interrupted" : "interrupted while ", stage);
  }
  try {
    if (tell_now != nullptr) (*tell_now)();
  } catch (...) {  // it has no caller
  }
  ::raise(signal);
  ::_exit(128 + signal);  // not reached: none of them has a handler
}

/// Signals so soon after the first one are the same wish: `timeout` and some schedulers signal the
/// process and then its group.
constexpr auto kOneWish = std::chrono::seconds(1);

[[noreturn]] void watch(const sigset_t& set, const std::string& tool) {
  std::chrono::steady_clock::time_point first{};
  for (;;) {
    int signal = 0;
    if (sigwait(&set, &signal) != 0) continue;
    if (signal == SIGUSR1) {
      if (phase == Phase::saving) checkpoint_requested = true;
    } else if (signal == SIGXCPU && phase == Phase::stopping) {
      continue;  // the kernel repeats it each second of CPU time, until its harder limit kills
    } else if (becomes(Phase::saving, Phase::stopping)) {
      first = std::chrono::steady_clock::now();
    } else if (phase != Phase::stopping || std::chrono::steady_clock::now() - first > kOneWish) {
      end_by(signal, tool.c_str());
    }
  }
}

}  // namespace

void watch_signals(const std::string& tool) {
  // A reader of the log that is gone ends no render: writing fails instead, here and in children.
  outlives_readers = is_ignored(SIGPIPE);
  std::signal(SIGPIPE, SIG_IGN);
  sigset_t set = set_of(kEndingSignals);
  if (!is_ignored(SIGUSR1)) sigaddset(&set, SIGUSR1);
  sigset_t before;
  pthread_sigmask(SIG_BLOCK, &set, &before);
  try {
    std::thread([set, tool] { watch(set, tool); }).detach();
  } catch (const std::system_error&) {  // no thread to be had: then signals end the process
    pthread_sigmask(SIG_SETMASK, &before, nullptr);
  }
}

SavesOnInterrupt::SavesOnInterrupt() : outermost_(becomes(Phase::plain, Phase::saving)) {
  if (outermost_) checkpoint_requested = false;
}

SavesOnInterrupt::~SavesOnInterrupt() {
  if (outermost_) (void)becomes(Phase::saving, Phase::plain);
}

bool interrupted() { return phase >= Phase::stopping; }

bool take_checkpoint_request() { return checkpoint_requested.exchange(false); }

TellsOnInterrupt::TellsOnInterrupt(std::function<void()> tell) : tell_(std::move(tell)) {
  const std::scoped_lock lock(notes);
  tell_now = &tell_;
}

TellsOnInterrupt::~TellsOnInterrupt() {
  const std::scoped_lock lock(notes);
  tell_now = nullptr;
}

void note_stage(const std::string& stage) {
  const std::scoped_lock lock(notes);
  const std::size_t size = std::min(stage.size(), stage_now.size() - 1);
  // Names may hold control characters, which are not for terminals.
  std::transform(stage.begin(), stage.begin() + std::ptrdiff_t(size), stage_now.begin(),
                 [](char c) { return (c >= 0 && c < ' ') || c == 0x7f ? '?' : c; });
  stage_now[size] = '\0';
}

void note_line(std::size_t width) { line_width = width; }

void end_if_reader_left() {
  pollfd out{STDOUT_FILENO, 0, 0};
  if (outlives_readers || ::poll(&out, 1, 0) != 1 || (out.revents & POLLERR) == 0) return;
  std::signal(SIGPIPE, SIG_DFL);
  ::raise(SIGPIPE);
}

void give_way_to_signal() {
  while (phase == Phase::ending) std::this_thread::sleep_for(std::chrono::milliseconds(10));
}

}  // namespace pvol::cli
