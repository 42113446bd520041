#include "cli/cli.h"

#include <fmt/format.h>
#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <exception>
#include <filesystem>
#include <iostream>
#include <new>
#include <string_view>
#include <system_error>
#include <utility>

#include "cli/escaped_output.h"
#include "cli/interrupt.h"
#include "cli/root_folder.h"
#include "pvol/error.h"
#include "pvol/formats/atomic_file.h"
#include "pvol/formats/cloud.h"

namespace pvol::cli {
namespace {

/// "not enough memory for this input within 500 MB; ...", where there is a limit. In a buffer,
/// since there may be no memory for a text.
using Text = std::array<char, 256>;
Text no_memory_text() {
  Text text{};
  rlimit limit{};
  constexpr const char* kWhat = "not enough memory for this input";
  if (getrlimit(RLIMIT_AS, &limit) != 0 || limit.rlim_cur == RLIM_INFINITY) {
    fmt::format_to_n(text.data(), text.size() - 1, "{}", kWhat);
  } else {
    fmt::format_to_n(text.data(), text.size() - 1,
                     "{} within {}; raise the limit (--memory-limit, ulimit -v)", kWhat,
                     readable_bytes(limit.rlim_cur));
  }
  return text;
}

std::array<char, 32> tool_now{};  // for end_without_memory, which has no caller

/// Where memory ends in a thread that can tell nobody, or there is none for a thread.
[[noreturn]] void end_without_memory() {
  bool is_memory = false;
  try {
    if (const auto now = std::current_exception()) std::rethrow_exception(now);
  } catch (const std::bad_alloc&) {
    is_memory = true;
  } catch (const std::exception& e) {
    is_memory = std::string_view(e.what()).find("pthread_create") != std::string_view::npos;
  } catch (...) {  // something else
  }
  if (!is_memory) std::abort();
  formats::abandon_writes();
  std::array<char, 512> line;
  const auto end = fmt::format_to_n(line.data(), line.size(), "{}: error: {}\n", tool_now.data(),
                                    no_memory_text().data());
  [[maybe_unused]] const auto written = ::write(STDERR_FILENO, line.data(), end.size);
  ::_exit(kFailure);
}

/// Draws a line on the terminal over the last one, of this width.
void redraw(const std::string& line, std::size_t& width) {
  // Whoever writes over it, in between too, covers what stands there.
  note_line(std::max(width, line.size()));
  // Blanks cover what a longer line left behind.
  std::cerr << '\r' << line << std::string(width > line.size() ? width - line.size() : 0, ' ')
            << std::flush;
  width = line.size();
  note_line(width);
}

}  // namespace

int run_guarded(const std::string& tool, const std::function<int()>& body) {
  const auto complain = [&](const char* what) {
    give_way_to_signal();
    std::cout.flush();
    std::cerr << tool << ": error: " << what << '\n';
    if (kept_below().empty()) return;
    std::cerr << "Only files below " << kept_below().string() << " can be used (--root).\n";
  };
  std::copy_n(tool.begin(), std::min(tool.size(), tool_now.size() - 1), tool_now.begin());
  std::set_terminate(end_without_memory);
  const EscapedOutput out(std::cout), err(std::cerr);
  try {
    const int code = body();
    std::cout.flush();
    give_way_to_signal();
    if (std::cout) return code;
    end_if_reader_left();
    complain("cannot write to standard output");
  } catch (const UsageError& e) {
    complain(e.what());
    std::cerr << "Run with --help for the options.\n";
    return kUsage;
  } catch (const std::bad_alloc&) {
    complain(no_memory_text().data());
  } catch (const std::filesystem::filesystem_error& e) {
    complain((e.path1().string() + ": cannot be read or written: " + e.code().message()).c_str());
  } catch (const std::system_error& e) {
    const bool no_thread = e.code() == std::errc::resource_unavailable_try_again;
    complain(no_thread ? no_memory_text().data() : e.what());
  } catch (const std::exception& e) {
    complain(e.what());
  }
  return kFailure;
}

void print_warnings(const std::string& tool, const std::vector<std::string>& warnings) {
  for (const std::string& w : warnings) std::cerr << tool << ": warning: " << w << '\n';
}

void check_output(const std::filesystem::path& file, const std::vector<std::string>& endings) {
  const std::string found = formats::ending(file);
  if (std::find(endings.begin(), endings.end(), found) == endings.end()) {
    std::string expected;
    for (const std::string& e : endings) expected += (expected.empty() ? "" : " or ") + e;
    throw UsageError("the output " + file.string() + " ends in '" + found + "', expected " +
                     expected);
  }
  std::error_code failed, ignored;
  const std::filesystem::file_status now = std::filesystem::status(file, failed);
  if (failed && failed != std::errc::no_such_file_or_directory &&
      failed != std::errc::not_a_directory && failed != std::errc::permission_denied) {
    throw Error(fmt::format("{}: cannot be written ({}); choose another name", file.string(),
                            failed.message()));
  }
  if (std::filesystem::is_directory(now)) {
    throw Error(file.string() + ": is a folder, expected the name of a file to write");
  }
  if (std::filesystem::exists(now) && !std::filesystem::is_regular_file(now)) {
    throw Error(file.string() + ": is a device or a pipe, expected the name of a file to write");
  }
  if (!is_kept(file)) throw Error(file.string() + ": lies outside the folder of --root");
  const std::filesystem::path folder = file.has_parent_path() ? file.parent_path() : ".";
  if (!std::filesystem::is_directory(folder, ignored)) {
    throw Error(file.string() + ": there is no folder " + folder.string() + "; create it first");
  }
  if (access(folder.c_str(), W_OK) != 0) {
    throw Error(file.string() + ": the folder " + folder.string() + " is not writable");
  }
}

bool same_file(const std::filesystem::path& a, const std::filesystem::path& b) {
  std::error_code missing;
  return std::filesystem::equivalent(a, b, missing);
}

std::string readable_bytes(std::uint64_t bytes) {
  static constexpr const char* kUnits[] = {"B", "kB", "MB", "GB", "TB"};
  double value = double(bytes);
  std::size_t unit = 0;
  while (value >= 999.5 && unit + 1 < std::size(kUnits)) value /= 1000, ++unit;
  return fmt::format("{:.{}f} {}", value, unit == 0 || value >= 99.5 ? 0 : 1, kUnits[unit]);
}

std::string readable_count(std::uint64_t count) {
  const std::string digits = fmt::to_string(count);
  std::string text;
  for (std::size_t i = 0; i < digits.size(); ++i) {
    if (i > 0 && (digits.size() - i) % 3 == 0) text += ' ';
    text += digits[i];
  }
  return text;
}

std::string readable_seconds(double seconds) {
  if (seconds < 0.9995) return fmt::format("{:.0f} ms", seconds * 1000);
  if (seconds < 99.5) return fmt::format("{:.1f} s", seconds);
  const auto whole = std::uint64_t(std::min(seconds, 1e15));
  const std::uint64_t hours = whole / 3600, minutes = whole / 60 % 60;
  if (hours > 0) return fmt::format("{} h {} min", readable_count(hours), minutes);
  return fmt::format("{} min {} s", minutes, whole % 60);
}

std::string readable(double value) { return fmt::format("{:.4g}", value); }

std::optional<double> parse_bytes(const std::string& text) {
  constexpr std::string_view kUnits = "kMGT";
  char* end = nullptr;
  double bytes = std::strtod(text.c_str(), &end);
  if (end == text.c_str() || !(bytes > 0) || !std::isfinite(bytes)) return std::nullopt;
  std::string_view unit = end;
  if (unit.ends_with('B')) unit.remove_suffix(1);
  if (unit.empty()) return bytes;
  const std::size_t power = kUnits.find(unit == "K" ? 'k' : unit.front());
  if (unit.size() > 1 || power == std::string_view::npos) return std::nullopt;
  return bytes * std::pow(1000.0, double(power + 1));
}

void limit_memory(double bytes) {
  rlimit limit{};
  getrlimit(RLIMIT_AS, &limit);
  limit.rlim_cur = std::min(limit.rlim_max, rlim_t(std::min(bytes, 1e18)));
  setrlimit(RLIMIT_AS, &limit);
}

bool on_terminal() { return isatty(STDERR_FILENO) != 0; }

double Stopwatch::seconds() const {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - last_).count();
}

double Stopwatch::lap() {
  const double took = seconds();
  last_ = std::chrono::steady_clock::now();
  return took;
}

StageLine::StageLine(const std::string& stage, bool quiet) : shown_(!quiet && on_terminal()) {
  show(stage);
}

StageLine::~StageLine() { erase(); }

void StageLine::show(const std::string& next) {
  note_stage(next);
  if (shown_) redraw(next, width_);
}

void StageLine::erase() {
  note_stage("");
  if (width_ == 0) return;
  redraw("", width_);
  std::cerr << '\r' << std::flush;
}

ProgressBar::ProgressBar(std::string label, std::string unit, bool quiet)
    : label_(std::move(label)),
      unit_(std::move(unit)),
      quiet_(quiet),
      terminal_(on_terminal()),
      start_(std::chrono::steady_clock::now()),
      next_(start_ + std::chrono::seconds(terminal_ ? 0 : 1)) {
  note_stage(label_);
}

ProgressBar::~ProgressBar() {
  note_stage("");
  if (!terminal_ || width_ == 0) return;
  std::cerr << '\n';
  note_line(0);
}

double ProgressBar::seconds() const {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start_).count();
}

void ProgressBar::begin(std::uint64_t done, double unit_seconds) {
  const std::scoped_lock lock(mutex_);
  left_.begin(seconds(), done, unit_seconds);
}

void ProgressBar::note(std::string text) {
  const std::scoped_lock lock(mutex_);
  note_ = std::move(text);
}

void ProgressBar::print(const std::string& line) {
  const std::scoped_lock lock(mutex_);
  if (width_ > 0) redraw("", width_);
  std::cerr << (terminal_ ? "\r" : "") << line << '\n';
}

void ProgressBar::show(std::uint64_t done, std::uint64_t total) {
  if (quiet_) return;
  const std::scoped_lock lock(mutex_);
  const auto now = std::chrono::steady_clock::now();
  const double part = total > 0 ? std::min(double(done) / double(total), 1.0) : 0;
  const int tenths = int(part * 10);
  const double time = seconds();
  // The units that were unknown so far may cost more than those before: what they cost counts anew.
  if (std::exchange(total_unknown_, total == 0) && total > 0) {
    const double rate = left_.rate(time, done);
    left_.begin(time, done, rate > 0 ? 1 / rate : 0);
  }
  // Ten times a second is smooth enough for eyes; files want ten lines, not thousands, and a sign
  // of life where those are far apart.
  const bool due = now >= next_ || (terminal_ ? done >= total : tenths > tenths_);
  if (!due) return;
  next_ = now + (terminal_ ? std::chrono::milliseconds(100) : std::chrono::seconds(10));
  tenths_ = tenths;

  std::string line = total > 0 ? fmt::format("{} {:3.0f} %", label_, std::floor(part * 100))
                               : label_ + ": " + readable_count(done) + ' ' + unit_;
  if (terminal_ && total > 0) {
    const auto full = std::size_t(part * 30);
    line += " [" + std::string(full, '#') + std::string(30 - full, '.') + "]";
  }
  if (const auto rate = std::uint64_t(left_.rate(time, done)); rate > 0) {
    line += ", " + readable_count(rate) + ' ' + unit_ + "/s";
  }
  if (done < total) {
    if (const auto left = left_.at(time, done, total)) {
      line += ", " + readable_seconds(*left) + " left";
    }
  }
  if (!note_.empty()) line += ", " + note_;
  draw(line);
}

void ProgressBar::draw(const std::string& line) {
  if (terminal_) {
    redraw(line, width_);
  } else {
    std::cerr << line << '\n';
  }
}

}  // namespace pvol::cli
