#include "cli/filter_frames.h"

#include <fmt/format.h>

#include <algorithm>
#include <iostream>
#include <iterator>
#include <map>

#include "cli/filter_picture.h"
#include "cli/instructions.h"
#include "cli/interrupt.h"
#include "cli/picture_facts.h"
#include "pvol/error.h"
#include "pvol/formats/film_file.h"
#include "pvol/formats/scene_file.h"
#include "pvol/render/denoise.h"

namespace pvol::cli {
namespace {

/// A rendered picture, ready for the filter.
struct Picture {
  std::filesystem::path file;
  formats::PictureHeader header;
  formats::SceneFile scene;
  std::optional<FilterFrame> frame;
};

/// Throws Error for pictures that cannot be filtered, and says what to do.
formats::SceneFile scene_of(const std::filesystem::path& file,
                            const std::map<std::string, std::string>& attributes) {
  const auto found = attributes.find("pvol:scene");
  if (found == attributes.end()) {
    throw Error("has no pvol:scene; expected a picture of pvol-render --denoise-layers");
  }
  if (wants_filter(attributes)) {
    throw Error(
        "is filtered already; expected a picture of pvol-render --denoise-layers, which is "
        "not filtered yet");
  }
  formats::SceneFile scene = formats::parse_scene(found->second, file.string() + ": pvol:scene");
  const RenderOptions& r = scene.scene.options;
  for (const AovRow& row : kAovs) {
    if (!layers_for_filter().has(row.aov) || r.aovs.has(row.aov)) continue;
    throw Error(fmt::format(
        "has no layer {}, which the filter needs; render it again with --denoise-layers",
        row.name));
  }
  return scene;
}

Picture open_picture(const FilterGiven& o, const std::filesystem::path& file, int frame = 0) {
  return naming(file, [&] {
    Picture p;
    p.header = formats::read_picture_header(file);
    p.scene = scene_of(file, p.header.attributes);
    p.file = file;
    p.frame.emplace(formats::read_film(file).film, middle_camera(p.scene.scene.camera),
                    DenoiseOptions{.threads = o.threads, .stop = interrupted}, double(frame));
    return p;
  });
}

/// What is left of the layers when they have done their duty.
void drop_halves(Film& film) {
  std::erase_if(film.layers, [](const Layer& l) { return l.name.starts_with("half_"); });
}

/// The attributes of the picture, with what the filter did.
std::map<std::string, std::string> describe_filtered(const Picture& p,
                                                     const FilteredPicture& filtered,
                                                     std::size_t others) {
  std::map<std::string, std::string> a = p.header.attributes;
  std::erase_if(a, [](const auto& entry) { return !entry.first.starts_with("pvol:"); });
  describe_filter(true, a);
  describe_error(filtered, a);
  a["pvol:denoise_frames"] = std::to_string(others + 1);
  return a;
}

void write(const FilterGiven& o, const Picture& p, const FilteredPicture& filtered,
           const std::map<std::string, std::string>& attributes) {
  const formats::PictureHeader& like = p.header;
  const Scene& scene = p.scene.scene;
  formats::ExrOptions layout =
      exr_options(PictureLayout{true, like.multipart, like.pixels, like.compression}, scene);
  formats::write_exr(o.output.exr, filtered.film, attributes, layout);
  save_png(o.output, filtered.film, scene.options.background);
}

/// Filters a picture with light from others, and writes it.
void filter_one(const FilterGiven& o, const std::string& label, const Picture& p,
                const std::vector<FilterFrame>& others) {
  Stopwatch watch;
  // Read again rather than kept, since it takes most of the memory.
  const Film film = formats::read_film(p.file).film;
  const Denoised d = denoise(film, *p.frame, others);
  FilteredPicture f = filtered_picture(film, d);
  drop_halves(f.film);
  f.wall_seconds = watch.lap();
  write(o, p, f, describe_filtered(p, f, others.size()));
  if (o.common.quiet) return;
  std::cerr << fmt::format("{}: {}filtered in {}{}, {}; wrote {}\n", kConvertTool, label,
                           readable_seconds(f.wall_seconds),
                           others.empty() ? "" : fmt::format(" with {} others", others.size()),
                           error_text(f), o.output.exr.string());
}

FilterGiven names_of_frame(const FilterGiven& o, int frame) {
  FilterGiven one = o;
  for (std::filesystem::path* file : {&one.input, &one.output.exr, &one.output.png}) {
    *file = file_of_frame(*file, frame);
  }
  return one;
}

/// The frames of a sequence in their order, and the pictures of those near the one at work.
class Sequence {
 public:
  explicit Sequence(const FilterGiven& o) : given_(o), numbers_(o.frames.all()) {
    std::ranges::sort(numbers_);
  }

  /// Numbers of the frames that one is filtered with, itself included.
  [[nodiscard]] std::vector<int> around(int frame) const {
    const auto own = std::ranges::find(numbers_, frame) - numbers_.begin();
    const auto first = std::max<std::ptrdiff_t>(0, own - given_.around);
    const auto last = std::min(std::ssize(numbers_) - 1, own + given_.around);
    return {numbers_.begin() + first, numbers_.begin() + last + 1};
  }

  void filter(int frame, const std::string& label) {
    const std::vector<int> window = around(frame);
    std::erase_if(pictures_, [&](const auto& p) { return p.first < window.front(); });
    std::vector<FilterFrame> others;
    for (const int f : window) {
      if (!pictures_.contains(f)) {
        pictures_.emplace(f, open_picture(given_, file_of_frame(given_.input, f), f));
      }
      if (f != frame) others.push_back(*pictures_.at(f).frame);
    }
    filter_one(names_of_frame(given_, frame), label + ": ", pictures_.at(frame), others);
  }

 private:
  const FilterGiven& given_;
  std::vector<int> numbers_;
  std::map<int, Picture> pictures_;
};

/// Frames are read beside the others, and again where a run is interrupted.
void refuse_same(const std::filesystem::path& input, const std::filesystem::path& output) {
  if (!same_file(input, output)) return;
  throw UsageError(
      fmt::format("input and output are the same file, {}; choose another name for the output",
                  input.string()));
}

int filter_sequence(const FilterGiven& o) {
  require_pattern({o.input});
  require_output_pattern(o.frames, o.output.exr);
  require_output_pattern(o.frames, o.output.png);
  Sequence sequence(o);
  std::vector<int> frames = o.frames.now();
  std::ranges::sort(frames);
  const SequenceTool tool{kConvertTool, o.common.quiet};
  leave_out_existing(tool, o.frames, frames, [&](int frame) {
    return std::filesystem::exists(file_of_frame(o.output.exr, frame));
  });
  std::vector<FrameFile> needed;
  for (const int frame : frames) {
    refuse_same(file_of_frame(o.input, frame), file_of_frame(o.output.exr, frame));
    for (const int f : sequence.around(frame)) needed.push_back({f, file_of_frame(o.input, f)});
  }
  require_files(needed);
  return for_each_frame(tool, frames, [&](std::size_t i) {
    sequence.filter(frames[i], frame_label(frames[i], i, frames.size()));
    return kSuccess;
  });
}

}  // namespace

int filter_frames(const FilterGiven& o) {
  check_frames(o.frames);
  check(o.output);
  refuse_same(o.input, o.output.exr);
  formats::use_exr_threads(o.threads);
  if (o.frames.any()) return filter_sequence(o);
  refuse_pattern(o.input);
  Picture p = open_picture(o, o.input);
  filter_one(o, "", p, {});
  return kSuccess;
}

}  // namespace pvol::cli
