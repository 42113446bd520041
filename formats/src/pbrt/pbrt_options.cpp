// Film, filter, sampler and integrator of pbrt's scenes.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "file/mesh_read.h"
#include "pbrt/pbrt_world.h"

namespace pvol::formats::detail {
namespace {

void check_size(const PbrtThing& film, int pixels) {
  if (pixels >= 1 && pixels <= kLargestEdge) return;
  fail_at(film.where, fmt::format("a picture with a side of {} pixels", pixels),
          fmt::format("1 to {}", kLargestEdge));
}

/// From x0, x1, y0, y1 in pixels.
void set_crop(const PbrtThing& film, const PbrtMaking& making, const std::array<double, 4>& b) {
  RenderOptions& o = making.scene->file.scene.options;
  const int x0 = int(std::clamp(b[0], 0.0, double(o.width)));
  const int x1 = int(std::clamp(b[1], 0.0, double(o.width)));
  const int y0 = int(std::clamp(b[2], 0.0, double(o.height)));
  const int y1 = int(std::clamp(b[3], 0.0, double(o.height)));
  if (x0 >= x1 || y0 >= y1) fail_at(film.where, "an empty crop", "pixels within the picture");
  if (x0 == 0 && y0 == 0 && x1 == o.width && y1 == o.height) return;
  o.crop_x = x0, o.crop_y = y0, o.crop_width = x1 - x0, o.crop_height = y1 - y0;
}

std::vector<double> four(const PbrtThing& film, const char* name) {
  std::vector<double> all = film.parameters.numbers(name);
  if (!all.empty() && all.size() != 4) {
    fail_at(film.where, fmt::format("{} of {} numbers", name, all.size()), "four");
  }
  return all;
}

void make_film(const PbrtThing& film, const PbrtMaking& making) {
  const PbrtParameters& p = film.parameters;
  RenderOptions& o = making.scene->file.scene.options;
  o.width = p.whole("xresolution", 1280), o.height = p.whole("yresolution", 720);
  check_size(film, o.width), check_size(film, o.height);
  const std::vector<double> crop = four(film, "cropwindow"), pixels = four(film, "pixelbounds");
  if (!pixels.empty()) {
    set_crop(film, making, {pixels[0], pixels[1], pixels[2], pixels[3]});
  } else if (!crop.empty()) {
    set_crop(film, making,
             {std::ceil(crop[0] * o.width), std::ceil(crop[1] * o.width),
              std::ceil(crop[2] * o.height), std::ceil(crop[3] * o.height)});
  }
  const std::string name = p.word("filename", "");
  if (!name.empty()) {
    making.note(
        film.where,
        fmt::format("the output name {} is left out: use pvol-render -o NAME.exr", shown(name)));
  }
  const double exposure = p.number("iso", 100) / 100 * p.number("exposuretime", 1);
  if (exposure != 1 && exposure > 0) {
    making.note(
        film.where,
        fmt::format("the sensor's factor of {:.4g} is left out: for the PNG, use --exposure {:.3f}",
                    exposure, std::log2(exposure)));
  }
  (void)p.number("diagonal", 35);  // of realistic cameras
  if (const std::string sensor = p.word("sensor", "cie1931"); sensor != "cie1931") {
    making.note(film.where, fmt::format("the sensor \"{}\" is left out: colours are linear Rec.709",
                                        shown(sensor)));
  }
  if (!film.type.empty() && film.type != "rgb") {
    making.note(film.where, fmt::format("the film \"{}\" is taken as rgb: choose layers with --aov",
                                        shown(film.type)));
  }
  p.note_unused(*making.notes, "film");
}

void make_filter(const PbrtThing& filter, const PbrtMaking& making) {
  RenderOptions& o = making.scene->file.scene.options;
  const PbrtParameters& p = filter.parameters;
  const std::string& type = filter.type;
  const double usual = type == "box" ? 0.5 : type.empty() || type == "gaussian" ? 1.5 : 2;
  const double x = p.number("xradius", usual), y = p.number("yradius", usual);
  const auto width = [](double w) { return std::clamp(w, 0.01, 100.0); };
  if (x != y)
    making.note(filter.where, "the filter's radii differ: the one along x is used for both");
  if (type == "box") {
    o.filter = PixelFilter::box;
    o.filter_width = width(2 * x);
  } else if (type.empty() || type == "gaussian") {  // ours ends at three deviations
    o.filter = PixelFilter::gaussian;
    o.filter_width = width(6 * p.number("sigma", 0.5));
  } else {
    o.filter = PixelFilter::blackman_harris;
    o.filter_width = width(std::min(2 * x, 3.0));
    making.note(filter.where, fmt::format("the filter \"{}\" becomes blackman-harris, {} wide",
                                          shown(type), *o.filter_width));
  }
  p.note_unused(*making.notes, "filter");
}

void make_sampler(const PbrtThing& sampler, const PbrtMaking& making) {
  const PbrtParameters& p = sampler.parameters;
  double samples = p.whole("pixelsamples", 16);
  if (sampler.type == "stratified") {
    samples = double(p.whole("xsamples", 4)) * p.whole("ysamples", 4);
    (void)p.flag("jitter", true);
  }
  (void)p.word("randomization", "");
  if (const PbrtParameter* seed = p.find("seed"); seed != nullptr) {
    making.scene->file.scene.options.seed = std::uint64_t(std::max(p.whole("seed", 0), 0));
  }
  if (!(samples >= 1 && samples < 4e9)) {
    fail_at(sampler.where, fmt::format("{} samples per pixel", samples), "at least 1");
  }
  making.scene->file.scene.options.samples = std::uint32_t(samples);
  p.note_unused(*making.notes, "sampler");
}

/// Both count scatterings: pbrt's path of maxdepth n gathers light after up to n of them.
void make_integrator(const PbrtThing& integrator, const PbrtMaking& making) {
  const PbrtParameters& p = integrator.parameters;
  const std::string& type = integrator.type;
  const int depth = p.whole("maxdepth", 5);
  if (depth < 0) fail_at(integrator.where, fmt::format("maxdepth {}", depth), "0 or more");
  if (std::uint32_t(depth) > kMostBounces) {
    making.note(integrator.where,
                fmt::format("maxdepth {} is no limit in practice, and becomes none", depth));
  } else {
    making.scene->file.scene.options.max_bounces = std::uint32_t(depth);
    making.note(integrator.where,
                fmt::format("maxdepth {}{} becomes max_bounces, which darkens the picture; "
                            "--max-bounces none lifts the limit",
                            depth, p.find("maxdepth") ? "" : ", pbrt's default,"));
  }
  if (!type.empty() && type != "volpath") {
    making.note(integrator.where,
                fmt::format("the integrator \"{}\" is taken as volpath", shown(type)));
  }
  (void)p.flag("regularize", false), (void)p.word("lightsampler", "");
  p.note_unused(*making.notes, "integrator");
}

}  // namespace

void make_options(const PbrtDescription& from, const PbrtMaking& making) {
  make_film(from.film, making);
  make_filter(from.filter, making);
  make_sampler(from.sampler, making);
  make_integrator(from.integrator, making);
}

}  // namespace pvol::formats::detail
