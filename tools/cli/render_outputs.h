// What pvol-render writes, and under which names.
#pragma once

#include <filesystem>
#include <string>

#include "cli/render_options.h"
#include "cli/render_report.h"

namespace pvol::cli {

/// Names of the files to write; empty for those that are not wanted.
struct Outputs {
  std::filesystem::path exr, png, deep;
};

/// The outputs that the options ask for, none where the scene is printed. Throws UsageError where
/// they do not go together, and Error for names that cannot be written to: before any work is done.
[[nodiscard]] Outputs choose_outputs(const RenderOptionsGiven& o);

/// Whether all of them are there, and the statistics.
[[nodiscard]] bool all_there(const RenderOptionsGiven& o, const Outputs& out);

/// Throws UsageError for layers that cannot be written as the options say, before anything is
/// rendered for them.
void check_layout(const RenderOptionsGiven& o, const Scene& scene);

/// Writes a picture of the film, such as it is.
void save_png(const RenderOptionsGiven& o, const std::filesystem::path& file, const RenderJob& job,
              const Film& film);

/// Writes a text as a whole; "-" is stdout.
void write_text(const std::filesystem::path& file, const std::string& text);

/// Writes the pictures. Of a render that goes on, `t` is what is there by then.
void save_pictures(const RenderOptionsGiven& o, const Outputs& out, const RenderJob& job,
                   const TimedRender& t);

/// Writes all outputs and the statistics, and says what they are.
void save(const RenderOptionsGiven& o, const Outputs& out, const RenderJob& job,
          const TimedRender& t);

}  // namespace pvol::cli
