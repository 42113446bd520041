#include "cli/sequence_summary.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>

#include "cli/cli.h"
#include "cli/json.h"

namespace pvol::cli {
namespace {

const char* name_of(FrameState state) {
  switch (state) {
    case FrameState::waiting:
      return "waiting";
    case FrameState::failed:
      return "failed";
    case FrameState::finished:
      return "finished";
    case FrameState::rendered:
      return "rendered";
  }
  return "";
}

std::string line_of(const FrameOutcome& f) {
  std::string line = fmt::format("  {:>6}  {:<8}", f.frame, name_of(f.state));
  if (f.state == FrameState::rendered) {
    line += fmt::format("  {:>12}", readable_seconds(f.wall_seconds));
    if (f.noise) line += fmt::format("  noise {:>6} %", readable(100 * *f.noise));
  }
  return line + '\n';
}

/// "3 failed: 7, 9, 12", or nothing.
std::string count_of(const std::vector<FrameOutcome>& frames, FrameState state) {
  constexpr std::size_t kMostNamed = 20;
  std::vector<int> numbers;
  for (const FrameOutcome& f : frames) {
    if (f.state == state) numbers.push_back(f.frame);
  }
  if (numbers.empty()) return "";
  std::string text = fmt::format(", {} {}", numbers.size(), name_of(state));
  if (state == FrameState::rendered || state == FrameState::finished) return text;
  const std::size_t named = std::min(kMostNamed, numbers.size());
  text += fmt::format(": {}",
                      fmt::join(numbers.begin(), numbers.begin() + std::ptrdiff_t(named), ", "));
  return text + (named < numbers.size() ? ", ..." : "");
}

}  // namespace

std::string summary_text(const std::vector<FrameOutcome>& frames) {
  std::string text;
  for (const FrameOutcome& f : frames) text += line_of(f);
  double seconds = 0, longest = 0, noisiest = 0;
  std::size_t rendered = 0;
  for (const FrameOutcome& f : frames) {
    if (f.state != FrameState::rendered) continue;
    ++rendered;
    seconds += f.wall_seconds;
    longest = std::max(longest, f.wall_seconds);
    noisiest = std::max(noisiest, f.noise.value_or(0));
  }
  text += fmt::format("  {} frames", frames.size());
  for (const FrameState s :
       {FrameState::rendered, FrameState::finished, FrameState::failed, FrameState::waiting}) {
    text += count_of(frames, s);
  }
  if (rendered > 0) {
    text += fmt::format("; {} per frame, {} at most, {} in all; noise {} % at most",
                        readable_seconds(seconds / double(rendered)), readable_seconds(longest),
                        readable_seconds(seconds), readable(100 * noisiest));
  }
  return text + '\n';
}

std::string summary_json(const std::vector<FrameOutcome>& frames) {
  Json all = Json::array();
  for (const FrameOutcome& f : frames) {
    Json j = {{"frame", f.frame}, {"state", name_of(f.state)}};
    if (f.state == FrameState::rendered) {
      j["wall_seconds"] = f.wall_seconds;
      j["cpu_seconds"] = f.cpu_seconds;
      j["pixel_noise"] = f.noise ? Json(*f.noise) : Json();
    }
    all.push_back(std::move(j));
  }
  return to_text(all);
}

}  // namespace pvol::cli
