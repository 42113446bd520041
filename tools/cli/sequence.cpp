#include "cli/sequence.h"

#include <fmt/format.h>

#include <algorithm>
#include <atomic>
#include <iostream>
#include <set>

#include "cli/cli.h"
#include "cli/interrupt.h"
#include "pvol/error.h"

namespace pvol::cli {

void check_frames(const FramesGiven& given) {
  if (!given.any() && (given.lock_frame || given.skip_existing)) {
    throw UsageError(fmt::format("{} needs --frames or --frame",
                                 given.lock_frame ? "--lock-frame" : "--skip-existing"));
  }
  const std::vector<int> all = given.all();
  if (given.frame && std::find(all.begin(), all.end(), *given.frame) == all.end()) {
    throw UsageError(
        fmt::format("--frame {} is not among the {} frames of --frames", *given.frame, all.size()));
  }
}

void refuse_pattern(const std::filesystem::path& file) {
  std::error_code ignored;
  if (!has_pattern(file) || std::filesystem::exists(file, ignored)) return;
  throw UsageError(fmt::format(
      "{} is a pattern for frames; choose some with --frames A-B or --frame N", file.string()));
}

void require_pattern(const std::vector<std::filesystem::path>& inputs) {
  if (std::any_of(inputs.begin(), inputs.end(), has_pattern)) return;
  throw UsageError(fmt::format(
      "{}: --frames and --frame need an input whose name has a place for the number, such as {}",
      inputs.back().string(), with_pattern(inputs.back()).string()));
}

void require_output_pattern(const FramesGiven& given, const std::filesystem::path& output) {
  const std::size_t count = given.all().size();
  if (count < 2 || output.empty() || has_pattern(output)) return;
  throw UsageError(fmt::format("{}: {} frames would be written to this one file; write {}",
                               output.string(), count, with_pattern(output).string()));
}

void require_files(const std::vector<FrameFile>& files) {
  std::vector<FrameFile> missing;
  std::set<int> frames;
  for (const FrameFile& f : files) {
    std::error_code ignored;
    if (std::filesystem::exists(f.file, ignored)) continue;
    missing.push_back(f);
    frames.insert(f.frame);
  }
  if (missing.empty()) return;
  const FrameFile& first = missing.front();
  frames.erase(first.frame);
  std::vector<int> others(frames.begin(), frames.end());
  std::string more = others.empty() ? "" : "; files of other frames are missing as well: ";
  constexpr std::size_t kMostNamed = 8;
  const std::string unnamed =
      others.size() > kMostNamed ? fmt::format(" and {} more", others.size() - kMostNamed) : "";
  others.resize(std::min(others.size(), kMostNamed));
  more += fmt::format("{}{}", fmt::join(others, ", "), unnamed);
  throw Error(
      fmt::format("frame {}: {}: there is no such file{}", first.frame, first.file.string(), more));
}

void print_skipped(const SequenceTool& tool, std::size_t skipped, std::size_t of) {
  if (skipped == 0 || tool.quiet) return;
  std::cerr << fmt::format("{}: {} of {} frames exist and are skipped\n", tool.name, skipped, of);
}

std::string frame_label(int number, std::size_t index, std::size_t count) {
  if (count == 1) return fmt::format("frame {}", number);
  return fmt::format("frame {} ({} of {})", number, index + 1, count);
}

int for_each_frame(const SequenceTool& tool, const std::vector<int>& frames,
                   const std::function<int(std::size_t)>& work) {
  std::atomic<std::size_t> done = 0;
  const TellsOnInterrupt tells([&] {
    if (tool.quiet || frames.size() == 1) return;
    std::cerr << fmt::format("{}: {} of {} frames are done\n", tool.name, done.load(),
                             frames.size());
  });
  int worst = kSuccess;
  for (std::size_t i = 0; i < frames.size(); ++i, ++done) {
    const std::string name = fmt::format("frame {}", frames[i]);
    const int code = run_guarded(fmt::format("{}: {}", tool.name, name), [&] {
      if (interrupted()) throw Error("interrupted before it began");
      return work(i);
    });
    if (worst == kSuccess) worst = code;
    if (code != kSuccess && (!tool.goes_on || interrupted())) break;
  }
  return worst;
}

int for_each_file(const SequenceTool& tool, const FramesGiven& given,
                  const std::filesystem::path& input, const std::filesystem::path& output,
                  const FrameWork& work) {
  require_output_pattern(given, output);
  std::vector<int> frames = given.now();
  leave_out_existing(tool, given, frames, [&](int frame) {
    return std::filesystem::exists(file_of_frame(output, frame));
  });
  std::vector<FrameFile> inputs;
  for (const int frame : frames) inputs.push_back({frame, file_of_frame(input, frame)});
  require_files(inputs);
  return for_each_frame(tool, frames, [&](std::size_t i) {
    return work(frames[i], frame_label(frames[i], i, frames.size()));
  });
}

}  // namespace pvol::cli
