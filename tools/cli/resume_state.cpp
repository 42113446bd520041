#include "cli/resume_state.h"

#include <fmt/format.h>

#include <algorithm>

#include "cli/cli.h"
#include "cli/picture_facts.h"
#include "cli/picture_key.h"
#include "pvol/error.h"
#include "pvol/formats/film_file.h"
#include "pvol/render/cost_map.h"

namespace pvol::cli {
namespace {

using Attributes = std::map<std::string, std::string>;

bool have_same_window(const formats::FilmPiece& a, const formats::FilmPiece& b) {
  return a.x == b.x && a.y == b.y && a.width == b.width && a.height == b.height;
}

formats::FilmPiece window_piece_of(const Film& f) {
  return {.x = f.x, .y = f.y, .width = f.crop_width, .height = f.crop_height};
}

/// Throws Error unless a file is a picture of the job, as far as its header tells.
void check_picture(const std::filesystem::path& file, const formats::PictureHeader& h,
                   const RenderJob& job) {
  const auto refuse = [&](const std::string& why) {
    throw Error(
        fmt::format("--resume: {} is another picture: {}; choose another name, or render "
                    "it anew with --no-resume",
                    file.string(), why));
  };
  const Attributes wanted = describe_picture(job, {});
  for (const char* name : {"pvol:scene", "pvol:key", "pvol:part"}) {
    const std::string found = attribute(h.attributes, name), here = attribute(wanted, name);
    if (found == here) continue;
    if (name == std::string("pvol:key")) {
      refuse(found.empty() ? "it was written by a version of pvol-render without keys"
                           : "the contents of its clouds or of other files of its scene changed");
    }
    if (name == std::string("pvol:part")) {
      refuse(fmt::format("it has {}, this one has {}", found.empty() ? "all samples" : found,
                         here.empty() ? "all" : here));
    }
    if (found.empty()) refuse("pvol-render did not write it");
    const auto [its, own] = first_difference(found, here, {});
    refuse(fmt::format("its scene has '{}', this one has '{}'", its, own));
  }
  if (!have_same_window(window_piece_of(h.window), piece_of(job.file.scene.options, false))) {
    refuse("it has another crop");
  }
  if (wants_filter(h.attributes) != job.denoise) {
    refuse(job.denoise ? "it was rendered without --denoise" : "it was rendered with --denoise");
  }
  for (const char* name : {"pvol:kernel_used", "pvol:version"}) {
    const std::string found = attribute(h.attributes, name), here = attribute(wanted, name);
    if (found == here) continue;
    print_warnings("pvol-render",
                   {fmt::format("{}: its samples so far are by {} {}, the further ones by {}: the "
                                "picture is correct, but may differ in bits from one run",
                                file.string(), name + std::string("pvol:").size(), found, here)});
  }
}

/// Nothing where there is no picture, or a damaged one.
std::optional<formats::PictureHeader> header_of(const std::filesystem::path& file) {
  try {
    return formats::read_picture_header(file);
  } catch (const Error&) {
    return std::nullopt;
  }
}

bool has_all_samples(const Attributes& a) {
  const std::string samples = attribute(a, "pvol:samples");
  const std::size_t of = samples.find(" of ");
  return of != std::string::npos && samples.substr(0, of) == samples.substr(of + 4);
}

bool has_layout(const formats::PictureHeader& h, const RenderOptionsGiven& o) {
  return h.multipart == o.multipart && h.pixels == o.pixels && h.compression == o.compression;
}

ResumeState resume(const FrameJob& frame, const RenderJob& job) {
  const Outputs& out = frame.outputs;
  std::error_code ignored;
  if (!std::filesystem::exists(out.exr, ignored)) return {};
  const formats::PictureHeader h = [&] {
    try {
      return formats::read_picture_header(out.exr);
    } catch (const Error& e) {
      throw Error(fmt::format("--resume: {}; --no-resume renders it anew", e.what()));
    }
  }();
  check_picture(out.exr, h, job);
  const bool as_asked = has_layout(h, frame.options);
  if (!h.has_sums) {
    if (has_all_samples(h.attributes) && as_asked)
      return {.film = {}, .finished = all_there(frame.options, out)};
    throw Error(
        fmt::format("--resume: {} has no sums to continue from (--sums off); render it again "
                    "with --no-resume",
                    out.exr.string()));
  }
  formats::FilmFile file = formats::read_film_file(out.exr);
  ResumeState b{std::move(file.film)};
  const bool complete = std::ranges::all_of(file.record.pieces, &formats::FilmPiece::complete);
  // A filter may have been interrupted; of parts of the samples the whole is filtered.
  const bool filter_owed =
      attribute(h.attributes, kWishForFilter) == "on" && job.file.scene.options.part_end == 0;
  b.complete = complete;
  b.finished = complete && !filter_owed && as_asked && all_there(frame.options, out);
  return b;
}

/// Whether a file is a picture that a render left before it had all samples that are wanted.
bool is_unfinished(const RenderOptionsGiven& o, const std::filesystem::path& file) {
  const std::optional<formats::PictureHeader> h = header_of(file);
  if (!h || !h->has_sums) return false;
  const bool of_others = h->attributes.contains("pvol:part") && !o.options.contains("samples");
  return of_others || !has_all_samples(h->attributes);
}

ResumeState go_on_from_pilot(const std::filesystem::path& file, const RenderJob& job) {
  if (!job.file.scene.options.noise) {
    throw UsageError("--pilot is for pictures that --noise ends; give the --noise of the pilot");
  }
  const formats::FilmFile pilot = formats::read_film_file(file);
  if (pilot.record.key != job.key) {
    throw Error(fmt::format("--pilot: {} shows another scene or other clouds", file.string()));
  }
  return naming(file, [&] { return ResumeState{begin_by_pilot(job.plan, pilot.film)}; });
}

}  // namespace

formats::FilmPiece piece_of(const RenderOptions& o, bool complete) {
  const PixelRect r = rendered_part(o);
  formats::FilmPiece p{.seed = o.seed,
                       .x = r.x,
                       .y = r.y,
                       .width = r.width,
                       .height = r.height,
                       .complete = complete};
  if (is_adaptive(o) && o.part_end == 0) return p;
  p.begin = o.first_sample + o.part_begin;
  p.end = o.first_sample + (o.part_end > 0 ? o.part_end : o.samples);
  return p;
}

ResumeState find_resume_state(const FrameJob& frame, const RenderJob& job) {
  const RenderOptionsGiven& o = frame.options;
  const Outputs& out = frame.outputs;
  ResumeState b;
  const bool implied = !o.resume && frame.in_sequence;
  if ((implied || o.resume.value_or(false)) && !out.exr.empty() && out.deep.empty()) {
    try {
      b = resume(frame, job);
    } catch (const Error&) {
      // Frames of a scene that changed since, or damaged ones, are rendered anew.
      if (!implied) throw;
    }
  }
  if (b.finished || !b.film.pixels.empty() || o.pilot.empty()) return b;
  return go_on_from_pilot(o.pilot, job);
}

bool is_rendered(const FrameJob& frame) {
  if (frame.options.print_scene || !all_there(frame.options, frame.outputs)) return false;
  const std::filesystem::path& file = frame.outputs.exr;
  return file.empty() || !is_unfinished(frame.options, file);
}

bool is_finished(const FrameJob& frame) {
  const RenderOptionsGiven& o = frame.options;
  if (!frame.in_sequence || !o.resume.value_or(true)) return false;
  if (frame.outputs.exr.empty() || !all_there(o, frame.outputs)) return false;
  const std::optional<formats::PictureHeader> found = header_of(frame.outputs.exr);
  if (!found) return false;
  const formats::PictureHeader& h = *found;
  if (!has_all_samples(h.attributes) ||
      attribute(h.attributes, "pvol:key") != picture_key(frame.scene) ||
      !have_same_window(window_piece_of(h.window), piece_of(frame.scene.scene.options, true))) {
    return false;
  }
  // The key does not know what leaves pictures the same on average, but for their noise.
  RenderOptions options = frame.scene.scene.options;
  const auto is_as_found = [&](const Entry& e) {
    const bool open = std::string_view(e.about.key) == "transmittance" &&
                      options.transmittance == Transmittance::automatic;
    return open || !e.about.in_scenes ||
           attribute(h.attributes, std::string("pvol:") + e.about.key) == attribute_text(e.value());
  };
  return std::ranges::all_of(entries(options), is_as_found) &&
         attribute(h.attributes, "pvol:part") == part_text(options) &&
         attribute(h.attributes, "pvol:denoised") == (o.denoise ? "on" : "off") && has_layout(h, o);
}

}  // namespace pvol::cli
