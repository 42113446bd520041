#include "stats/image_report.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>

#include "cli/cli.h"
#include "pvol/measure/pixel_maps.h"
#include "report/colour_map.h"
#include "report/html.h"
#include "report/svg.h"

namespace pvol::cli {
namespace {

using measure::ChannelComparison;
using measure::FilmComparison;
using report::Content;
using report::Figure;
using report::Shown;
using report::Text;

constexpr double kMapShare = 0.995;  // of all pixels that the colours of a map tell apart
constexpr double kMapSigmas = 5;

std::string known(double v) { return std::isfinite(v) ? readable(v) : "unknown"; }

std::string with_sign(double v) { return v > 0 ? '+' + known(v) : known(v); }

std::string percent(double share) {
  return std::isfinite(share) ? fmt::format("{:.4g} %", 100 * share) : "unknown";
}

/// Below the smallest double there is no telling.
std::string probability(double p) { return p > 0 ? fmt::format("p = {:.4g}", p) : "p < 1e-300"; }

// --- words --------------------------------------------------------------------------------------

/// A line of the table: one figure of each channel.
struct ImageFigure {
  const char* name;
  std::string (*text)(const ChannelComparison&);
  bool needs_variances = true;
};

constexpr ImageFigure kFigures[] = {
    {"mean of the first", [](const ChannelComparison& c) { return known(c.mean_a); }, false},
    {"mean of the second", [](const ChannelComparison& c) { return known(c.mean_b); }, false},
    {"bias (first - second)", [](const ChannelComparison& c) { return with_sign(c.bias); }, false},
    {"bias, +-", [](const ChannelComparison& c) { return known(c.bias_half_width); }},
    {"relative bias", [](const ChannelComparison& c) { return percent(c.relative_bias); }, false},
    {"relative bias, +-",
     [](const ChannelComparison& c) { return percent(c.bias_half_width / std::abs(c.mean_b)); }},
    {"MSE", [](const ChannelComparison& c) { return known(c.mse); }, false},
    {"MSE explained by noise", [](const ChannelComparison& c) { return known(c.explained_mse); }},
    {"MSE, systematic", [](const ChannelComparison& c) { return with_sign(c.systematic_mse); }},
    {"MSE, systematic, +-",
     [](const ChannelComparison& c) { return known(c.systematic_half_width); }},
    {"RMSE", [](const ChannelComparison& c) { return known(c.rmse); }, false},
    {"relative RMSE", [](const ChannelComparison& c) { return percent(c.relative_rmse); }, false},
};

report::Table figure_table(const FilmComparison& r) {
  report::Table table{
      .caption = fmt::format("Means over {} pixels; intervals at {:.4g} % confidence",
                             readable_count(r.pixels), 100 * r.options.confidence),
      .header = {"", "luminance", "R", "G", "B"}};
  for (const ImageFigure& f : kFigures) {
    if (f.needs_variances && !r.variances_known) continue;
    table.rows.push_back({f.name, f.text(r.luminance)});
    for (const ChannelComparison& c : r.channels) table.rows.back().push_back(f.text(c));
  }
  return table;
}

/// About the largest difference, and how many pixels differ by much.
std::vector<Content> pixel_lines(const FilmComparison& r) {
  std::vector<Content> lines;
  if (r.largest) {
    lines.push_back(
        Text{fmt::format("most significant difference of a pixel: {:.4g} sigma at ({}, {}) "
                         "(p = {:.4g} for the least likely of all pixels)",
                         r.largest->sigmas, r.largest->x, r.largest->y, r.largest->p_value)});
  }
  if (!r.variances_known || !(r.tails[0].sigmas > 0)) return lines;
  std::string tails = "pixels beyond";
  for (const measure::PixelTail& t : r.tails) {
    if (t.sigmas == 0) continue;
    tails += fmt::format("{} {:.4g} sigma: {} (noise: {:.4g})", t.sigmas > 3 ? "," : "", t.sigmas,
                         readable_count(t.found), t.expected);
  }
  lines.push_back(Text{tails});
  return lines;
}

/// Whether a bias was found, how sure that is, and where.
report::Verdict verdict_of(const FilmComparison& r) {
  if (!r.verdict) {
    return {
        "whether there is a bias is not known; the test needs the variances of both pictures "
        "(--aov variance,samples), with at least two samples per pixel"};
  }
  const measure::BiasVerdict& v = *r.verdict;
  const std::string odds =
      fmt::format("({}, level {:.4g})", probability(v.p_value), r.options.level);
  if (!v.detected) return {"no bias detected " + odds, report::Mood::good};
  const measure::RegionDifference& w = v.worst;
  const std::string where =
      v.regions_p_value <= v.pixels_p_value
          ? fmt::format("{} x {} pixels at ({}, {}) differ by {} +- {:.4g} (one sigma) in {}",
                        w.width, w.height, w.x, w.y, with_sign(w.bias), w.deviation,
                        "RGB"[w.channel])
          : "pixels differ by more than noise, in both directions";
  return {fmt::format("bias detected {}: {}", odds, where), report::Mood::bad};
}

constexpr const char* kMeanings =
    "Noise: the variance of each pixel's mean, from its own samples; the pictures are taken to be "
    "independent. Squared errors in the column of luminance are those of the channels, weighted as "
    "in luminance. Systematic: the MSE less what noise explains, which may fall below 0; where the "
    "light varies across pixels, their positions in a pixel are spread more evenly than noise is, "
    "and it is estimated too low; its interval counts how it varies over the picture as "
    "uncertainty, too. The verdict tests the means of the picture, its quarters, their quarters "
    "and so on, and the systematic MSE, in every channel, with false alarms at the stated level "
    "for all tests together.";

// --- pictures -----------------------------------------------------------------------------------

std::string picture_markup(const formats::Picture& picture, const std::string& name) {
  constexpr int kSmall = 300;  // pixels across; smaller ones are enlarged
  return html::image(formats::encode_png(picture), name, picture.width < kSmall);
}

Figure film_figure(const std::string& name, const Film& film, double exposure) {
  const std::string caption = fmt::format("{} (exposure {:.4g} stops)", name, exposure);
  return {picture_markup(formats::to_picture(film, {.exposure = exposure}), caption), caption};
}

Figure map_figure(const formats::Picture& picture, double limit, const std::string& label,
                  const std::string& caption) {
  return {picture_markup(picture, label) + colour_bar(ColourMap::diverging, -limit, limit, label),
          caption};
}

/// Deviations of pixels beside the normal law that they follow where there is only noise.
svg::Plot sigma_plot(const std::vector<double>& sigmas) {
  const measure::SigmaHistogram h = measure::sigma_histogram(sigmas);
  svg::Bars bars{"pixels", {}, 0};
  for (std::size_t i = 0; i < h.shares.size(); ++i) {
    const double x = h.lower_edge(i);
    if (h.shares[i] > 0) bars.bars.push_back({x, x + h.width, h.shares[i]});
  }
  svg::Series normal{"noise alone, with many samples", {}, svg::Style::curve, 1};
  for (double x = -4.5; x <= 4.5; x += 0.125) normal.points.push_back({x, h.expected(x)});
  svg::Plot plot;
  plot.title = "Deviations of pixels";
  plot.x = {"difference in luminance, in its own standard deviations", false, -h.end, h.end};
  plot.y = {"share of pixels", true, std::max(0.1 / std::max(h.pixels, 1.0), 1e-7), 1.0};
  plot.bars = {bars};
  plot.series = {normal};
  return plot;
}

/// Both pictures, and where they differ.
std::vector<Content> picture_parts(const ImageReport& r) {
  const double exposure = measure::exposure_below_white(r.a.film, r.b.film, kMapShare);
  std::vector<Content> parts{report::Figures{
      {film_figure(r.name_a, r.a.film, exposure), film_figure(r.name_b, r.b.film, exposure)}}};
  const DifferenceMap map = difference_map(r.a.film, r.b.film);
  report::Figures maps{
      {map_figure(map.picture, map.limit, "difference in luminance",
                  "Where the first picture is brighter: orange; where the second is: blue.")}};
  if (!r.comparison.variances_known) {
    parts.push_back(maps);
    return parts;
  }
  const std::vector<double> sigmas = measure::differences(r.a.film, r.b.film).sigmas;
  maps.figures.push_back(map_figure(
      map_colours(sigmas, r.a.film.crop_width, ColourMap::diverging, -kMapSigmas, kMapSigmas),
      kMapSigmas, "difference in standard deviations",
      "Noise alone looks like even grain here; patches and edges of one colour indicate bias."));
  parts.push_back(maps);
  parts.push_back(report::Figures{{{svg::draw(sigma_plot(sigmas)),
                                    "With few samples each pixel's own deviation is noisy, and its "
                                    "tails are heavier than the curve."}}});
  return parts;
}

}  // namespace

DifferenceMap difference_map(const Film& a, const Film& b) {
  const std::vector<double> values = measure::differences(a, b).values;
  DifferenceMap m;
  m.limit = measure::range_of(values, kMapShare);
  m.picture = map_colours(values, a.crop_width, ColourMap::diverging, -m.limit, m.limit);
  return m;
}

report::Document image_document(const ImageReport& r, bool pictures) {
  const auto file = [](const std::string& name) {
    return std::filesystem::path(name).filename().string();
  };
  report::Document d{
      .title = file(r.name_a) + " against " + file(r.name_b),
      .subject = r.name_a + " against " + r.name_b,
      .lead = fmt::format("{} x {} pixels", r.a.film.crop_width, r.a.film.crop_height)};
  const report::Verdict verdict = verdict_of(r.comparison);
  add(d, verdict, Shown::on_page);
  if (pictures) add(d, picture_parts(r), Shown::on_page);
  add(d, report::Heading{"Figures"});
  add(d, figure_table(r.comparison));
  add(d, pixel_lines(r.comparison), Shown::everywhere);
  add(d, verdict, Shown::on_terminal);
  add(d, report::Heading{"What the figures mean"}, Shown::on_page);
  add(d, Text{kMeanings}, Shown::on_page);
  return d;
}

// --- JSON ---------------------------------------------------------------------------------------

namespace {

/// Numbers that are not known are null.
Json number(double v) { return std::isfinite(v) ? Json(v) : Json(nullptr); }

Json channel_json(const ChannelComparison& c) {
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

std::string channel_name(std::size_t channel) { return std::string(1, "RGB"[channel]); }

Json verdict_json(const measure::BiasVerdict& v) {
  const measure::RegionDifference& w = v.worst;
  return {{"bias_detected", v.detected},
          {"p_value", v.p_value},
          {"regions_p_value", v.regions_p_value},
          {"pixels_p_value", v.pixels_p_value},
          {"regions", v.regions},
          {"worst_region",
           {{"rectangle", {w.x, w.y, w.width, w.height}},
            {"channel", channel_name(std::size_t(w.channel))},
            {"bias", w.bias},
            {"deviation", w.deviation},
            {"p_value", w.p_value}}}};
}

}  // namespace

Json to_json(const ImageReport& report) {
  const FilmComparison& r = report.comparison;
  Json j;
  j["a"] = report.name_a;
  j["b"] = report.name_b;
  j["size"] = {report.a.film.crop_width, report.a.film.crop_height};
  j["confidence"] = r.options.confidence;
  j["level"] = r.options.level;
  j["variances_known"] = r.variances_known;
  j["luminance"] = channel_json(r.luminance);
  for (std::size_t c = 0; c < 3; ++c) j["channels"][channel_name(c)] = channel_json(r.channels[c]);
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
  j["verdict"] = r.verdict ? verdict_json(*r.verdict) : Json(nullptr);
  return j;
}

}  // namespace pvol::cli
