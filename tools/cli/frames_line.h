// The options about frames, for tools that work on sequences.
#pragma once

#include <fmt/format.h>

#include <string>

#include "cli/command_line.h"
#include "cli/sequence.h"

namespace pvol::cli {

/// One frame's number; what parse_frames says where it is none.
[[nodiscard]] inline int parse_frame(const std::string& text) {
  const std::vector<int> frames = parse_frames(text);
  if (frames.size() == 1) return frames.front();
  throw UsageError(fmt::format("found '{}', expected one frame, such as 17", text));
}

/// Accepts what a parser takes without an exception.
template <class Parser>
[[nodiscard]] Check parses(Parser parser) {
  return {[parser](const std::string& text) -> std::string {
    try {
      static_cast<void>(parser(text));
      return {};
    } catch (const UsageError& e) {
      return e.what();
    }
  }};
}

inline void add_frames(const CommandLine& app, FramesGiven& given) {
  app.add_option_function(
         "--frames", [&given](const std::string& text) { given.frames = parse_frames(text); },
         "Process a sequence, one frame after another: 1-240, every tenth 1-240x10, or a list with "
         "commas. File names contain ####, %04d or $F4 in place of the number, which is padded "
         "with "
         "zeros to that width")
      .type_name("A-B[xN]")
      .check(parses(parse_frames));
  app.add_option_function(
         "--frame", [&given](const std::string& text) { given.frame = parse_frame(text); },
         "Process this frame alone; with --frames, one frame of that sequence")
      .type_name("N")
      .check(parses(parse_frame));
  app.add_flag("--skip-existing", given.skip_existing,
               "Skip frames whose files exist, except unfinished pictures; files are always "
               "written completely or not at all");
}

inline void add_lock_frame(const CommandLine& app, FramesGiven& given) {
  app.add_option_function(
         "--lock-frame",
         [&given](const std::string& text) { given.lock_frame = parse_frame(text); },
         "Frame for which extinction and camera are chosen if the scene has none; all frames use "
         "them [the first of --frames]")
      .type_name("N")
      .check(parses(parse_frame));
}

}  // namespace pvol::cli
