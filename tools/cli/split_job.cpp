#include "cli/split_job.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numeric>

#include "cli/cli.h"
#include "cli/split_render.h"
#include "pvol/formats/cloud.h"
#include "pvol/render/render.h"

namespace pvol::cli {
namespace {

namespace fs = std::filesystem;

/// Options that parts do not take over; a value follows those that have one.
struct Dropped {
  const char* flag;
  bool has_value;
};
constexpr auto kDropped = std::to_array<Dropped>({
    {"-o", true},
    {"--output", true},
    {"--png", true},
    {"--no-png", false},
    {"--exposure", true},
    {"--tone-map", true},
    {"--split", true},
    {"--for", true},
    {"--at-once", true},
    {"--crop", true},
    {"--frame", true},
    {"--skip-existing", false},
    {"--resume", false},
    {"--no-resume", false},
    {"--summary", true},
    {"--checkpoint", true},
    {"--sums", true},
});

const Dropped* find_dropped(const std::string& argument) {
  const std::string flag = argument.substr(0, argument.find('='));
  for (const Dropped& d : kDropped) {
    if (flag == d.flag) return &d;
  }
  const bool short_with_value = argument.starts_with("-o") && argument.size() > 2;
  return short_with_value ? &kDropped.front() : nullptr;
}

/// Whether the value is a word of its own.
bool is_apart(const Dropped& d, const std::string& argument) {
  return d.has_value && argument == d.flag;
}

/// The value that was given last, if any.
std::optional<std::string> value_of(const Arguments& given, const std::string& flag) {
  for (std::size_t i = given.size(); i-- > 0;) {
    if (given[i].starts_with(flag + "=")) return given[i].substr(flag.size() + 1);
    if (given[i] == flag && i + 1 < given.size()) return given[i + 1];
  }
  return std::nullopt;
}

Arguments operator+(Arguments a, const Arguments& b) {
  a.insert(a.end(), b.begin(), b.end());
  return a;
}

/// The converter beside this tool, where the user named this one by its folder.
std::string converter(const std::string& tool) {
  const fs::path path = tool;
  return path.has_parent_path() ? (path.parent_path() / "pvol-convert").string() : "pvol-convert";
}

/// "smoke.####.exr" -> "smoke.exr": what is before the number, which is where the names of two
/// frames part.
fs::path without_pattern(const fs::path& file) {
  if (!has_pattern(file)) return file;
  const std::string a = file_of_frame(file, 1111111).filename().string();
  const std::string b = file_of_frame(file, 2222222).filename().string();
  std::string name(a.begin(), std::mismatch(a.begin(), a.end(), b.begin()).first);
  while (!name.empty() && std::string("._-").find(name.back()) != name.npos) name.pop_back();
  return fs::path(file).replace_filename((name.empty() ? "frames" : name) + ".exr");
}

fs::path parts_folder(const RenderOptionsGiven& o) {
  fs::path folder = o.frames.any() ? without_pattern(o.output) : o.output;
  folder.replace_extension(".parts");
  // Commands would take it for an option.
  return folder.string().starts_with('-') ? fs::path(".") / folder : folder;
}

/// Names and options of one picture: a frame, or the only one.
struct Naming {
  const RenderOptionsGiven& o;
  std::optional<int> frame;
  fs::path folder;
  std::string end;  ///< of the files' names

  Naming(const RenderOptionsGiven& options, std::optional<int> of)
      : o(options), frame(of), folder(parts_folder(options)), end(".exr") {
    if (!frame) return;
    folder /= fmt::format("{:04}", *frame);
    end = fmt::format(".{:04}.exr", *frame);
  }
  [[nodiscard]] fs::path of_frame(const fs::path& file) const {
    return frame ? file_of_frame(file, *frame) : file;
  }
  /// As the renderer wants it, which puts the number in itself.
  [[nodiscard]] std::string as_told(const fs::path& stem) const {
    return stem.string() + (frame ? ".####.exr" : ".exr");
  }
};

std::string text_of(const PixelRect& r) {
  return fmt::format("{},{},{},{}", r.x, r.y, r.width, r.height);
}

/// What a merge says of the finished picture. `crop` is what is rendered of the image, where that
/// is not all.
Arguments looks(const Naming& name, const std::optional<PixelRect>& crop) {
  const RenderOptionsGiven& o = name.o;
  Arguments a{"-o", name.of_frame(o.output).string()};
  if (!o.png.empty()) a = a + Arguments{"--png", name.of_frame(o.png).string()};
  if (o.no_png) a.emplace_back("--no-png");
  if (crop) a = a + Arguments{"--crop", text_of(*crop)};
  for (const char* flag : {"--exposure", "--tone-map", "--sums"}) {
    if (const auto value = value_of(o.arguments, flag)) a = a + Arguments{flag, *value};
  }
  return a;
}

/// A part's own options, after those that all have.
Arguments options_of(const PartCommand& p, const Naming& name, const std::string& stem) {
  Arguments a;
  if (name.frame) a = {"--frame", std::to_string(*name.frame)};
  a = a + Arguments{"--crop", text_of(p.part.pixels)};
  if (p.samples_told) {
    a = a + Arguments{"--samples", fmt::format("{}:{}", p.part.first_sample, p.part.end_sample)};
  }
  return a + Arguments{"-o",           name.as_told(name.folder / stem),
                       "--no-png",     "--sums",
                       "on",           "--resume",
                       "--checkpoint", value_of(name.o.arguments, "--checkpoint").value_or("10")};
}

/// `kind` is "part" or "pilot"; `more` is what its parts are told besides.
SplitStage stage(const std::vector<PicturePart>& parts, const Naming& name, const std::string& kind,
                 bool samples_told, const Arguments& more) {
  SplitStage s;
  const std::size_t width = std::max<std::size_t>(4, std::to_string(parts.size()).size());
  const std::string of_all = fmt::format("-of-{:0{}}", parts.size(), width);
  for (const PicturePart& part : parts) {
    const std::string stem = fmt::format("{}.{:0{}}{}", kind, s.parts.size() + 1, width, of_all);
    PartCommand p{
        .output = name.folder / (stem + name.end), .part = part, .samples_told = samples_told};
    p.command = echoed(name.o.arguments) + more + options_of(p, name, stem);
    s.merge.files.push_back(p.output);
    s.parts.push_back(std::move(p));
  }
  s.merge.before = {converter(name.o.arguments.front()), "merge"};
  s.merge.folder = name.folder;
  s.merge.pattern = kind + ".*" + of_all + name.end;
  return s;
}

double sum(const std::vector<double>& v) { return std::accumulate(v.begin(), v.end(), 0.0); }

/// The ways in which a picture is cut: all frames alike.
struct Cuts {
  std::vector<PicturePart> pilots;  ///< none unless samples are adaptive
  std::vector<PicturePart> parts;
  std::optional<PixelRect> crop;  ///< what they make up, where that is not the whole image
};

Cuts cut(const RenderPlan& plan, const CostMap& map, int count) {
  const RenderOptions& o = plan.scene.options;
  const PixelRect whole = rendered_part(o);
  Cuts c;
  if (whole != PixelRect{0, 0, o.width, o.height}) c.crop = whole;
  if (!is_adaptive(o)) {
    c.parts = split_picture(whole, o.samples, count, CostSums(map, map.work));
    return c;
  }
  constexpr std::uint32_t kAllTogether = 1;  // a pixel's samples are never cut
  c.parts = split_picture(whole, kAllTogether, count, CostSums(map, map.work));
  const double share = sum(map.pilot_work) / sum(map.work);
  const int pilots = std::clamp(int(std::lround(count * share)), 1, count);
  c.pilots = split_picture(whole, kAllTogether, pilots, CostSums(map, map.pilot_work));
  for (PicturePart& p : c.pilots) p.end_sample = kPilot;
  return c;
}

SplitPicture picture(const RenderOptionsGiven& o, std::optional<int> frame, const Cuts& cuts) {
  const Naming name(o, frame);
  SplitPicture p{.frame = frame, .output = name.of_frame(o.output), .folder = name.folder};
  Arguments more;
  if (!cuts.pilots.empty()) {
    p.pilots = stage(cuts.pilots, name, "pilot", true, {});
    const std::string merged = (name.folder / ("pilot" + name.end)).string();
    p.pilots->merge.before.emplace_back("--partial");
    p.pilots->merge.after = {"-o", merged, "--no-png"};
    if (cuts.crop)
      p.pilots->merge.after = p.pilots->merge.after + Arguments{"--crop", text_of(*cuts.crop)};
    more = {"--pilot", merged};
  }
  p.parts = stage(cuts.parts, name, "part", cuts.pilots.empty(), more);
  p.parts.merge.after = looks(name, cuts.crop);
  return p;
}

void refuse(bool given, const char* flag, const char* why) {
  if (given) throw UsageError(fmt::format("--split and {} exclude each other: {}", flag, why));
}

}  // namespace

Arguments MergeCommand::command() const {
  Arguments all = before;
  for (const fs::path& file : files) all.push_back(file.string());
  return all + after;
}

void check_split(const RenderOptionsGiven& o) {
  if (!o.split.parts) {
    if (o.split.form) throw UsageError("--for needs --split N, whose parts it prints");
    if (o.split.at_once) throw UsageError("--at-once needs --split N --for slurm");
    return;
  }
  if (o.split.at_once && o.split.form != SplitForm::slurm) {
    throw UsageError("--at-once needs --for slurm, whose tasks it limits");
  }
  if (!o.print_scene && formats::ending(o.output) == ".png") {
    throw UsageError(fmt::format(
        "--split: found the output {}, expected an .exr, since only those can be merged",
        o.output.string()));
  }
  refuse(o.options.contains("time") && o.options.at("time") != "off", "--time",
         "each part would take that long; use --noise or --spp");
  refuse(!o.deep.empty(), "--deep", "deep pictures cannot be merged");
  refuse(!o.stats.empty(), "--stats", "each part would count only its own work");
  refuse(o.live, "--live", "nothing is rendered in this run");
  refuse(o.denoise, "--denoise", "the filter needs the whole picture");
  refuse(o.print_scene, "--print-scene", "each prints its own result");
  const auto given = [&](const char* flag) { return value_of(o.arguments, flag).has_value(); };
  refuse(given("--samples"), "--samples", "the split divides the samples of --spp itself");
  refuse(given("--pilot"), "--pilot", "the split makes its own pilots");
}

Arguments echoed(const Arguments& given) {
  Arguments all;
  for (std::size_t i = 0; i < given.size(); ++i) {
    const Dropped* d = i == 0 ? nullptr : find_dropped(given[i]);
    if (d == nullptr) {
      all.push_back(given[i]);
    } else if (is_apart(*d, given[i])) {
      ++i;
    }
  }
  return all;
}

SplitJob split_job(const RenderOptionsGiven& o, const RenderPlan& plan) {
  if (plan.scene.options.time) {
    throw UsageError(
        "--split: the scene limits the time of the render, and each part would take that long; use "
        "--time off, and --noise or --spp");
  }
  const int count = *o.split.parts;
  constexpr int kCellsOfPart = 64, kLeastCells = 8192, kMostCells = 131072;
  const CostMap map = map_cost(plan, std::clamp(kCellsOfPart * count, kLeastCells, kMostCells));
  const Cuts cuts = cut(plan, map, count);
  const TimeForecast time = forecast_time(plan);
  const double processes = double(cuts.parts.size() + cuts.pilots.size());
  SplitJob job{.folder = parts_folder(o),
               .cpu_seconds = time.sample_seconds * sum(map.work) + time.guide_seconds * processes,
               .imbalance = imbalance(cuts.parts)};
  if (o.frames.any()) {
    for (const int frame : o.frames.now()) job.pictures.push_back(picture(o, frame, cuts));
  } else {
    job.pictures.push_back(picture(o, std::nullopt, cuts));
  }
  return job;
}

std::string summary(const SplitJob& job) {
  const SplitPicture& one = job.pictures.front();
  const double each = job.cpu_seconds / double(one.parts.parts.size());
  std::string text;
  if (one.frame) text = fmt::format("{} frames of ", job.pictures.size());
  if (one.pilots) text += fmt::format("{} pilots and ", one.pilots->parts.size());
  return text + fmt::format(
                    "{} parts of {} of CPU time by forecast, {} in all; the largest takes "
                    "{:.3g} times the mean",
                    one.parts.parts.size(), readable_seconds(each),
                    readable_seconds(job.cpu_seconds * double(job.pictures.size())), job.imbalance);
}

}  // namespace pvol::cli
