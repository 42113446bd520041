// Work that is done frame by frame: which frames, which files, and what is said about it.
#pragma once

#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "cli/frames.h"

namespace pvol::cli {

/// What the command line says of frames.
struct FramesGiven {
  std::vector<int> frames{};   ///< --frames
  std::optional<int> frame{};  ///< --frame: that one alone, of `frames` where those are given, too
  std::optional<int> lock_frame{};  ///< that open choices are made for
  bool skip_existing = false;

  /// Whether the tool works by frames at all.
  [[nodiscard]] bool any() const { return !frames.empty() || frame.has_value(); }
  /// Those to do now, and all of the sequence, here and elsewhere.
  [[nodiscard]] std::vector<int> now() const { return frame ? std::vector{*frame} : frames; }
  [[nodiscard]] std::vector<int> all() const { return frames.empty() ? now() : frames; }
};

/// Throws UsageError for options that do not go together.
void check_frames(const FramesGiven& given);

/// Throws UsageError for a file that is none but a pattern, where no frames are given.
void refuse_pattern(const std::filesystem::path& file);

/// Throws UsageError unless one of the inputs has a pattern.
void require_pattern(const std::vector<std::filesystem::path>& inputs);

/// Throws UsageError where several frames would be written to one file.
void require_output_pattern(const FramesGiven& given, const std::filesystem::path& output);

/// A file that a frame needs.
struct FrameFile {
  int frame = 0;
  std::filesystem::path file;
};

/// Throws Error for the first of the files that is not there, and says what others are not.
void require_files(const std::vector<FrameFile>& files);

/// Who works on a sequence, and whether it tells no more than errors and warnings.
struct SequenceTool {
  std::string name;
  bool quiet = false;
  bool goes_on = false;  ///< to other frames after one that failed
};

/// Tells how many frames are left out, if any.
void print_skipped(const SequenceTool& tool, std::size_t skipped, std::size_t of);

/// Leaves out the frames for which is_there(frame) holds, where those are to be skipped. A frame is
/// its number, or whatever a tool has resolved for it.
template <class Frame, class IsThere>
void leave_out_existing(const SequenceTool& tool, const FramesGiven& given,
                        std::vector<Frame>& frames, const IsThere& is_there) {
  if (!given.skip_existing) return;
  const std::size_t skipped = std::erase_if(frames, is_there);
  print_skipped(tool, skipped, skipped + frames.size());
}

/// "frame 17 (5 of 24)" for number 17 at index 4 of 24, or "frame 17" of one alone.
[[nodiscard]] std::string frame_label(int number, std::size_t index, std::size_t count);

/// Does the frames one after another, work(index) for each, and returns the exit code: that of the
/// first that fails, after which no other is begun unless the tool goes on. None is once it is
/// interrupted.
[[nodiscard]] int for_each_frame(const SequenceTool& tool, const std::vector<int>& frames,
                                 const std::function<int(std::size_t index)>& work);

/// Works on a frame under its label; returns an exit code.
using FrameWork = std::function<int(int frame, const std::string& label)>;

/// All of this for a tool that makes one file of one file, which has a pattern, or of one that has
/// all frames.
[[nodiscard]] int for_each_file(const SequenceTool& tool, const FramesGiven& given,
                                const std::filesystem::path& input,
                                const std::filesystem::path& output, const FrameWork& work);

}  // namespace pvol::cli
