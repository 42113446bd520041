// The verb `image`: how far apart two pictures are, and how much of that is not noise.
#include <cmath>
#include <iomanip>
#include <iostream>

#include "cli/json.h"
#include "pvol/formats/cloud.h"
#include "pvol/formats/image.h"
#include "pvol/measure/compare.h"
#include "stats/stats.h"
#include "stats/stats_image_page.h"

namespace pvol::cli {
namespace {

std::string attribute(const formats::StoredFilm& f, const std::string& name) {
  const auto found = f.attributes.find(name);
  return found == f.attributes.end() ? "" : found->second;
}

std::vector<std::string> warnings_of(const ImagePair& p) {
  std::vector<std::string> w;
  const std::string seed = attribute(p.a, "pvol:seed");
  if (!seed.empty() && seed == attribute(p.b, "pvol:seed")) {
    w.push_back(
        "both pictures were rendered with seed " + seed +
        ": what random numbers they share makes every interval too wide and may hide a bias; "
        "render one of them again with another --seed");
  }
  for (const auto& [name, film] : {std::pair(p.name_a, &p.a), std::pair(p.name_b, &p.b)}) {
    if (!film->has_variances) {
      w.push_back(name +
                  " has no variances (channels variance.R, .G, .B and samples, as pvol-render "
                  "writes them): whether differences are more than noise is not known");
    }
  }
  return w;
}

// --- text ---------------------------------------------------------------------------------------

void report_text(const ImagePair& p, const measure::FilmComparison& r) {
  std::cout << p.name_a << " against " << p.name_b << ": " << p.a.film.crop_width << " x "
            << p.a.film.crop_height << " pixels\n\n"
            << std::setw(36) << "luminance" << std::setw(13) << "R" << std::setw(13) << "G"
            << std::setw(13) << "B" << '\n';
  for (const ImageFigure& f : image_figures(r)) {
    std::cout << "  " << f.name << std::setw(34 - int(f.name.size())) << f.text(r.luminance);
    for (const measure::ChannelComparison& c : r.channels) std::cout << std::setw(13) << f.text(c);
    std::cout << '\n';
  }
  std::cout << '\n';
  for (const std::string& line : describe_pixels(r)) std::cout << line << '\n';
  std::cout << describe_verdict(r) << '\n';
}

// --- JSON ---------------------------------------------------------------------------------------

/// Numbers that are not known are null.
Json number(double v) { return std::isfinite(v) ? Json(v) : Json(nullptr); }

Json to_json(const measure::ChannelComparison& c) {
  return {{"mean_a", number(c.mean_a)},
          {"mean_b", number(c.mean_b)},
          {"bias", number(c.bias)},
          {"bias_deviation", number(c.bias_deviation)},
          {"bias_half_width", number(c.bias_half_width)},
          {"relative_bias", number(c.relative_bias)},
          {"mse", number(c.mse)},
          {"rmse", number(c.rmse)},
          {"relative_rmse", number(c.relative_rmse)},
          {"explained_mse", number(c.explained_mse)},
          {"systematic_mse", number(c.systematic_mse)},
          {"systematic_half_width", number(c.systematic_half_width)}};
}

Json to_json(const measure::BiasVerdict& v) {
  const measure::RegionDifference& w = v.worst;
  return {{"bias_detected", v.detected},
          {"p_value", v.p_value},
          {"regions_p_value", v.regions_p_value},
          {"pixels_p_value", v.pixels_p_value},
          {"regions", v.regions},
          {"worst_region",
           {{"rectangle", {w.x, w.y, w.width, w.height}},
            {"channel", std::string(1, "RGB"[w.channel])},
            {"bias", w.bias},
            {"deviation", w.deviation},
            {"p_value", w.p_value}}}};
}

void report_json(const ImagePair& p, const measure::FilmComparison& r) {
  Json j;
  j["a"] = p.name_a;
  j["b"] = p.name_b;
  j["size"] = {p.a.film.crop_width, p.a.film.crop_height};
  j["confidence"] = r.options.confidence;
  j["level"] = r.options.level;
  j["variances_known"] = r.variances_known;
  j["luminance"] = to_json(r.luminance);
  for (std::size_t c = 0; c < 3; ++c)
    j["channels"][std::string(1, "RGB"[c])] = to_json(r.channels[c]);
  if (r.largest) {
    j["largest_pixel"] = {{"place", {r.largest->x, r.largest->y}},
                          {"sigmas", r.largest->sigmas},
                          {"p_value", r.largest->p_value}};
  }
  if (r.variances_known) {
    j["tails"] = Json::array();
    for (const measure::PixelTail& t : r.tails) {
      j["tails"].push_back({{"sigmas", t.sigmas}, {"found", t.found}, {"expected", t.expected}});
    }
  }
  j["verdict"] = r.verdict ? to_json(*r.verdict) : Json(nullptr);
  std::cout << to_text(j);
}

void write_map(const std::filesystem::path& file, const ImagePair& p) {
  if (formats::ending(file) == ".png") {
    formats::write_png(file, difference_map(p).picture);
  } else {
    formats::write_exr(file, difference_film(p.a.film, p.b.film),
                       {{"pvol:map",
                         "R, G, B: the first picture less the second; variance: of the "
                         "difference"}});
  }
}

}  // namespace

int run_image(const ImageOptions& o) {
  if (o.map) check_output(*o.map, {".exr", ".png"});
  if (o.map && (same_file(*o.map, o.a) || same_file(*o.map, o.b))) {
    throw UsageError("the map " + o.map->string() + " is one of the pictures to be compared");
  }
  if (o.html) check_output(*o.html, {".html", ".htm"});
  ImagePair pair{o.a.string(), o.b.string(), formats::read_film(o.a), formats::read_film(o.b)};
  const measure::FilmComparison r = naming(o.a, [&] {
    return measure::compare(pair.a.film, pair.b.film, {o.confidence, o.level});
  });
  print_warnings("pvol-stats", warnings_of(pair));
  if (o.map) write_map(*o.map, pair);
  if (o.html) html::write_page(*o.html, image_page(pair, r));
  if (o.json) {
    report_json(pair, r);
  } else {
    report_text(pair, r);
  }
  if (!o.fail_on_bias) return kSuccess;
  if (!r.verdict) {
    throw Error(o.a.string() +
                ": --fail-on-bias needs the variances of both pictures, of two samples a pixel at "
                "least; render them with pvol-render and --spp 2 or more");
  }
  return r.verdict->detected ? kFailure : kSuccess;
}

}  // namespace pvol::cli
