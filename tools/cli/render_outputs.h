// Writing the outputs of pvol-render.
#pragma once

#include <filesystem>
#include <string>

#include "cli/frame_job.h"
#include "cli/render_report.h"

namespace pvol::cli {

/// Writes a picture of the film, such as it is.
void save_png(const RenderOptionsGiven& o, const std::filesystem::path& file, const RenderJob& job,
              const Film& film);

/// Writes a text as a whole; "-" is stdout.
void write_text(const std::filesystem::path& file, const std::string& text);

/// Writes the pictures of a frame. Of a render that goes on, `t` is what is there by then.
void save_pictures(const FrameJob& frame, const RenderJob& job, const TimedRender& t);

/// Writes all outputs and the statistics, and says what they are.
void save(const FrameJob& frame, const RenderJob& job, const TimedRender& t);

}  // namespace pvol::cli
