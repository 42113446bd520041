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
#include <cinttypes>
#include <csignal>
#include <cstdio>
#include <fstream>
#include <initializer_list>
#include <mutex>
#include <string>
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
std::atomic<const void*> lost_page = nullptr;
std::mutex notes;  // of what follows; nobody waits for anything while holding it
std::array<char, 256> stage_now{};
const std::function<void()>* tell_now = nullptr;

[[nodiscard]] bool becomes(Phase from, Phase to) { return phase.compare_exchange_strong(from, to); }

[[nodiscard]] bool is_ignored(int signal) {
  struct sigaction action {};
  return sigaction(signal, nullptr, &action) == 0 && action.sa_handler == SIG_IGN;
}

/// How a thread that lost a page of a mapped file tells the one that takes signals. Nobody else
/// sends it: by default it is ignored.
constexpr int kLostPage = SIGURG;

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

/// The file that is mapped at an address, or an empty name.
std::string file_at(const void* address) {
  const auto wanted = reinterpret_cast<std::uintptr_t>(address);
  std::ifstream maps("/proc/self/maps");
  for (std::string line; std::getline(maps, line);) {
    // begin-end access offset device inode   name
    std::uintptr_t begin = 0, end = 0;
    int name = 0;
    if (std::sscanf(line.c_str(), "%" SCNxPTR "-%" SCNxPTR " %*s %*s %*s %*s %n", &begin, &end,
                    &name) == 2 &&
        begin <= wanted && wanted < end) {
      return line.substr(std::min(std::size_t(name), line.size()));
    }
  }
  return {};
}

/// Ends the tool because a page of a mapped file is gone.
[[noreturn]] void end_by_lost_page(const char* tool) {
  formats::abandon_writes();
  const std::string file = file_at(lost_page);
  const std::string what = "error: " + (file.empty() ? "a mapped file" : file);
  const std::scoped_lock lock(notes);
  say(tool, what.c_str(),
      ": became shorter, or its disk failed, while it was in use. Render again; to replace a file "
      "that is in use, write the new one aside and rename it");
  ::_exit(1);
}

/// Of the thread that asked for the page, which cannot go on: the one that takes signals ends the
/// tool.
extern "C" void on_bus_error(int signal, siginfo_t* info, void*) {
  if (info->si_code != BUS_ADRERR) {
    std::signal(signal, SIG_DFL);  // and fail again, as no file is to blame
    return;
  }
  lost_page = info->si_addr;
  ::kill(::getpid(), kLostPage);
  for (;;) ::pause();
}

void catch_bus_errors() {
  struct sigaction action {};
  action.sa_sigaction = on_bus_error;
  action.sa_flags = SA_SIGINFO;
  sigaction(SIGBUS, &action, nullptr);
}

[[noreturn]] void watch(const sigset_t& set, const std::string& tool) {
  std::chrono::steady_clock::time_point first{};
  for (;;) {
    int signal = 0;
    if (sigwait(&set, &signal) != 0) continue;
    if (signal == kLostPage) end_by_lost_page(tool.c_str());
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
  std::signal(SIGXFSZ, SIG_IGN);  // likewise of files beyond a limit
  sigset_t set = set_of(kEndingSignals);
  if (!is_ignored(SIGUSR1)) sigaddset(&set, SIGUSR1);
  sigaddset(&set, kLostPage);
  sigset_t before;
  pthread_sigmask(SIG_BLOCK, &set, &before);
  try {
    std::thread([set, tool] { watch(set, tool); }).detach();
    catch_bus_errors();
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
