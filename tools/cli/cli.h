// What every tool does alike: exit codes, messages, progress, readable numbers.
#pragma once

#include <chrono>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <mutex>
#include <optional>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

#include "cli/time_left.h"
#include "pvol/error.h"

namespace pvol::cli {

inline constexpr int kSuccess = 0;
inline constexpr int kFailure = 1;  ///< the input or the machine is to blame
inline constexpr int kUsage = 2;    ///< the command line is

/// Options that several tools share.
struct Common {
  bool quiet = false;
};

/// A command line that parses but asks for what cannot be: ends the tool with kUsage.
struct UsageError : std::runtime_error {
  using std::runtime_error::runtime_error;
};

/// Runs the tool's body and returns the exit code; whatever it throws becomes one line on stderr,
/// "pvol-fit: error: ...".
[[nodiscard]] int run_guarded(const std::string& tool, const std::function<int()>& body);

/// The result of `work`; the file's name goes in front of the message of an Error that it throws,
/// unless that names it.
template <class Work>
[[nodiscard]] auto naming(const std::filesystem::path& file, const Work& work) {
  try {
    return work();
  } catch (const Error& e) {
    if (std::string_view(e.what()).find(file.string()) != std::string_view::npos) throw;
    throw Error(file.string() + ": " + e.what());
  }
}

/// "pvol-fit: warning: ..." on stderr, one line for each.
void print_warnings(const std::string& tool, const std::vector<std::string>& warnings);

/// Throws UsageError where the name lacks one of the endings (".vdb"), or Error where its folder is
/// missing or cannot be written to: before the work is done, not after.
void check_output(const std::filesystem::path& file, const std::vector<std::string>& endings);

/// Whether two names mean the same existing file.
[[nodiscard]] bool same_file(const std::filesystem::path& a, const std::filesystem::path& b);

/// 1234567 -> "1.2 MB" (powers of 1000), "1 234 567", and 0.0123 -> "12 ms".
[[nodiscard]] std::string readable_bytes(std::uint64_t bytes);
[[nodiscard]] std::string readable_count(std::uint64_t count);
[[nodiscard]] std::string readable_seconds(double seconds);

/// Four significant digits.
[[nodiscard]] std::string readable(double value);

/// Bytes as people write them: "500M", "1.5G" (powers of 1000) or plain; nothing for other text.
[[nodiscard]] std::optional<double> parse_bytes(const std::string& text);

/// From here on the process gets no more address space than this: what needs more fails with a
/// message instead of taking the machine's memory.
void limit_memory(double bytes);

/// Whether stderr is a terminal.
[[nodiscard]] bool on_terminal();

/// Seconds since its making or the last lap.
class Stopwatch {
 public:
  [[nodiscard]] double lap();
  /// The same, and the lap goes on.
  [[nodiscard]] double seconds() const;

 private:
  std::chrono::steady_clock::time_point last_ = std::chrono::steady_clock::now();
};

/// Names a long step in a line on the terminal that is there as long as the step takes: "reading
/// cloud.vdb". Nothing where stderr is no terminal, or when quiet; interruptions name it always.
class StageLine {
 public:
  StageLine(const std::string& stage, bool quiet);
  ~StageLine();
  StageLine(const StageLine&) = delete;
  StageLine& operator=(const StageLine&) = delete;

  void show(const std::string& next);
  void erase();

 private:
  bool shown_;
  std::size_t width_ = 0;  // of the line on the terminal
};

/// How far a long step has come, on stderr: a bar that is redrawn on a terminal, otherwise a plain
/// line every tenth of the way, after the first second and after ten without one; both with rate
/// and remaining time. Draws nothing when quiet.
class ProgressBar {
 public:
  /// `unit` is what is counted, e.g. "samples".
  ProgressBar(std::string label, std::string unit, bool quiet);
  ~ProgressBar();
  ProgressBar(const ProgressBar&) = delete;
  ProgressBar& operator=(const ProgressBar&) = delete;

  /// The work begins now, with `done` units from an earlier run. By forecast a unit takes so many
  /// seconds; 0: nobody knows. Without a call it begins with the bar.
  void begin(std::uint64_t done, double unit_seconds);

  /// `total` is 0 where it is not known yet.
  void show(std::uint64_t done, std::uint64_t total);

  /// What lines to come end with.
  void note(std::string text);

  /// Prints a line of its own, whether quiet or not; on a terminal the bar goes on below it.
  void print(const std::string& line);

 private:
  [[nodiscard]] double seconds() const;  // since the bar is there
  void draw(const std::string& line);

  std::string label_, unit_, note_;
  std::mutex mutex_;  // of all below: `show` is called from other threads
  bool quiet_, terminal_;
  std::chrono::steady_clock::time_point start_, next_;
  TimeLeft left_;
  bool total_unknown_ = false;  // when it was shown last
  int tenths_ = 0;              // last tenth that got a line
  std::size_t width_ = 0;       // of the line on the terminal
};

}  // namespace pvol::cli
