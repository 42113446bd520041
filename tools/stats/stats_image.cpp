// The verb `image`: how far apart two pictures are, and how much of that is not noise.
#include <fmt/format.h>

#include <iostream>

#include "cli/picture_facts.h"
#include "pvol/formats/cloud.h"
#include "pvol/formats/image.h"
#include "pvol/measure/compare.h"
#include "pvol/measure/pixel_maps.h"
#include "report/html.h"
#include "report/terminal.h"
#include "stats/image_report.h"
#include "stats/stats.h"

namespace pvol::cli {
namespace {

std::vector<std::string> warnings_of(const ImageReport& r) {
  std::vector<std::string> w;
  const std::string seed = attribute(r.a.attributes, "pvol:seed");
  if (!seed.empty() && seed == attribute(r.b.attributes, "pvol:seed")) {
    w.push_back(fmt::format(
        "both pictures were rendered with seed {}: the random numbers that they share make every "
        "interval too wide and may hide a bias; render one of them again with another --seed",
        seed));
  }
  for (const auto& [name, film] : {std::pair(r.name_a, &r.a), std::pair(r.name_b, &r.b)}) {
    if (!film->has_variances) {
      w.push_back(name +
                  " has no variances, so noise and bias cannot be told apart; render it with --aov "
                  "variance,samples");
    }
    if (attribute(film->attributes, "pvol:denoised") == "on") {
      w.push_back(name +
                  ": was filtered by --denoise: its pixels are not independent, so intervals and "
                  "findings of bias are invalid. Compare a picture without the filter");
    }
  }
  return w;
}

void write_map(const std::filesystem::path& file, const ImageReport& r) {
  if (formats::ending(file) == ".png") {
    formats::write_png(file, difference_map(r.a.film, r.b.film).picture);
  } else {
    const bool variances = r.a.has_variances && r.b.has_variances;
    formats::write_exr(
        file, measure::difference_film(r.a.film, r.b.film),
        {{"pvol:map",
          "R, G, B: the first picture less the second; variance: of the "
          "difference"}},
        {.aovs = variances ? AovSet{Aov::variance, Aov::samples} : AovSet{}, .opaque = true});
  }
}

}  // namespace

int run_image(const ImageOptions& o) {
  if (o.map) check_output(*o.map, {".exr", ".png"});
  if (o.map && (same_file(*o.map, o.a) || same_file(*o.map, o.b))) {
    throw UsageError("the map " + o.map->string() + " is one of the pictures to be compared");
  }
  if (o.html) check_output(*o.html, {".html", ".htm"});
  formats::use_exr_threads(0);
  ImageReport r{o.a.string(), o.b.string(), formats::read_film(o.a), formats::read_film(o.b), {}};
  r.comparison = naming(o.a, [&] {
    return measure::compare(r.a.film, r.b.film, {o.confidence, o.level});
  });
  print_warnings("pvol-stats", warnings_of(r));
  if (o.map) write_map(*o.map, r);
  const report::Document document = image_document(r, o.html.has_value());
  if (o.html) html::write_page(*o.html, document);
  std::cout << (o.json ? to_text(to_json(r)) : report::to_terminal(document));
  if (!o.fail_on_bias) return kSuccess;
  if (!r.comparison.verdict) {
    throw Error(o.a.string() +
                ": --fail-on-bias needs the variances of both pictures, with at least two samples "
                "per pixel; render them with --aov variance,samples and --spp 2 or more");
  }
  return r.comparison.verdict->detected ? kFailure : kSuccess;
}

}  // namespace pvol::cli
