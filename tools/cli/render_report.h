// What a render leaves on record besides the picture: its options, counts, times and errors.
#pragma once

#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "cli/filter_picture.h"
#include "cli/mapped_inputs.h"
#include "pvol/formats/scene_file.h"
#include "pvol/render/render.h"

namespace pvol::cli {

/// What a volume's density lost before it was made.
struct VolumeReport {
  std::filesystem::path file;
  Quantisation density{};  ///< that it is rendered with
  QuantisationError density_error{};
};

/// Which frame of a sequence.
struct FrameReport {
  int number = 0;
  std::optional<int> locked_to;  ///< the frame that extinction or camera was chosen for
  std::string label;             ///< "frame 17 (5 of 24)"
};

/// What is rendered: the scene with nothing left to choose, and its clouds made ready.
struct RenderJob {
  std::filesystem::path input;       ///< as given on the command line
  std::vector<std::string> sets;     ///< likewise
  std::optional<FrameReport> frame;  ///< nothing for a picture by itself
  formats::SceneFile file;
  std::vector<Volume> volumes;
  std::vector<VolumeReport> reports;  ///< one for each volume
  std::vector<VolumeFacts> facts;     ///< likewise
  RenderPlan plan;                    ///< refers to `volumes`
  bool chose_transmittance = false;   ///< it was left to choose
  std::string key;                    ///< picture_key of `file`; empty where nothing is rendered
  bool denoise = false;               ///< the whole picture is to be filtered
  std::vector<FileState> mapped;      ///< files of `volumes` as they were before they were read
};

struct TimedRender {
  RenderResult result;
  const Film* under_way = nullptr;  ///< of a render that goes on; `result` then has no film yet
  double cpu_seconds = 0, wall_seconds = 0;  ///< of this run
  TimeForecast forecast{};                   ///< of this run; no samples where nobody asked
  std::uint64_t samples = 0;                 ///< of the camera, over all pixels
  std::uint64_t samples_wanted = 0;          ///< 0 where that was not known yet
  std::optional<FilteredPicture> filtered;   ///< where it was asked for

  [[nodiscard]] const Film& film() const { return under_way ? *under_way : result.film; }
  /// What is written.
  [[nodiscard]] const Film& picture() const { return filtered ? filtered->film : film(); }
};

/// "none", "2^3 from the file", "2^3 built at load" or "single voxels, built at load".
[[nodiscard]] std::string micro_bounds_text(const Volume& volume);

/// "no", or "yes: " and what makes the picture biased.
[[nodiscard]] std::string describe_bias(const RenderJob& job, const TimedRender& t);

/// "1200 of 4000": samples of those wanted, as far as known.
[[nodiscard]] std::string progress_text(const TimedRender& t);

/// For the header of the picture: all that is needed to make it again.
[[nodiscard]] std::map<std::string, std::string> describe_picture(const RenderJob& job,
                                                                  const TimedRender& t);

/// The JSON of --stats. mean_rgb is the mean over pixels, variance_rgb the mean over pixels of the
/// variance of a pixel's mean, both before any filter; counts are totals.
[[nodiscard]] std::string stats_text(const RenderJob& job, const TimedRender& t);

}  // namespace pvol::cli
