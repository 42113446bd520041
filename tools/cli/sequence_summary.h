// What became of the frames of a sequence.
#pragma once

#include <optional>
#include <string>
#include <vector>

namespace pvol::cli {

enum class FrameState {
  waiting,   ///< it was not begun
  failed,    ///< or interrupted: its error was printed
  finished,  ///< by an earlier run
  rendered,  ///< by this one
};

struct FrameOutcome {
  int frame = 0;
  FrameState state = FrameState::waiting;
  double wall_seconds = 0, cpu_seconds = 0;
  std::optional<double> noise{};  ///< pixel_noise of the picture
};

/// A line for each frame, with its time and noise, and one for all: which failed, and what times
/// and noise are on average and at most.
[[nodiscard]] std::string summary_text(const std::vector<FrameOutcome>& frames);

/// The same as JSON.
[[nodiscard]] std::string summary_json(const std::vector<FrameOutcome>& frames);

}  // namespace pvol::cli
