#include "stats/stats_image_page.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <numbers>

#include "cli/cli.h"
#include "report/colour_map.h"
#include "report/svg.h"

namespace pvol::cli {
namespace {

constexpr double kMapShare = 0.995;  // of all pixels that the colours of a map tell apart
constexpr double kMapSigmas = 5;

std::string known(double v) { return std::isfinite(v) ? readable(v) : "unknown"; }

std::string with_sign(double v) { return v > 0 ? '+' + known(v) : known(v); }

std::string percent(double share) {
  return std::isfinite(share) ? readable(100 * share) + " %" : "unknown";
}

std::string place(int x, int y) { return '(' + std::to_string(x) + ", " + std::to_string(y) + ')'; }

/// Below the smallest double there is no telling.
std::string probability(double p) { return p > 0 ? "p = " + readable(p) : "p < 1e-300"; }

/// Every pixel's difference in luminance, and the same in standard deviations.
struct Differences {
  std::vector<double> values, sigmas;
};

Differences measure(const Film& a, const Film& b) {
  Differences d;
  for (std::size_t i = 0; i < a.pixels.size(); ++i) {
    const double difference = measure::luminance(mean(a.pixels[i]) - mean(b.pixels[i]));
    const double deviation = std::hypot(measure::luminance_deviation(a.pixels[i]),
                                        measure::luminance_deviation(b.pixels[i]));
    d.values.push_back(difference);
    d.sigmas.push_back(deviation > 0 ? difference / deviation : 0);
  }
  return d;
}

/// The end of a map's colours: most values lie within.
double limit_of(std::vector<double> values) {
  for (double& v : values) v = std::abs(v);
  const double most = quantile(values, kMapShare), all = quantile(values, 1);
  return most > 0 ? most : all > 0 ? all : 1;
}

/// Stops that bring bright pixels of both films just below white.
double exposure_of(const ImagePair& p) {
  std::vector<double> bright;
  for (const Film* f : {&p.a.film, &p.b.film}) {
    for (const PixelSums& s : f->pixels) bright.push_back(measure::luminance(mean(s)));
  }
  const double white = quantile(bright, kMapShare);
  return white > 0 ? std::clamp(-std::log2(white), -60.0, 60.0) : 0;
}

html::Figure film_figure(const std::string& name, const Film& film, double exposure) {
  const bool small = film.crop_width < 300;
  return {html::image(formats::encode_png(formats::to_picture(film, exposure)), name, small), name};
}

html::Figure map_figure(const formats::Picture& picture, double limit, const std::string& label,
                        const std::string& caption) {
  return {html::image(formats::encode_png(picture), label, picture.width < 300) +
              colour_bar(ColourMap::diverging, -limit, limit, label),
          caption};
}

/// Deviations of pixels beside the normal law that they follow where there is only noise.
svg::Plot sigma_plot(const std::vector<double>& sigmas) {
  constexpr double kEnd = 6, kStep = 0.25;
  const auto bins = std::size_t(2 * kEnd / kStep);
  svg::Bars bars{"pixels", {}, 0};
  svg::Series normal{"noise alone, with many samples", {}, svg::Style::curve, 1};
  std::vector<double> counts(bins);
  double all = 0;
  for (const double s : sigmas) {
    if (s == 0) continue;  // pixels without variance say nothing
    counts[std::size_t(std::clamp((s + kEnd) / kStep, 0.0, double(bins - 1)))] += 1;
    ++all;
  }
  for (std::size_t i = 0; i < bins; ++i) {
    const double x = -kEnd + kStep * double(i);
    if (counts[i] > 0) bars.bars.push_back({x, x + kStep, counts[i] / all});
  }
  for (double x = -4.5; x <= 4.5; x += 0.125) {
    const double density = std::exp(-x * x / 2) / std::sqrt(2 * std::numbers::pi);
    normal.points.push_back({x, density * kStep});
  }
  svg::Plot plot;
  plot.title = "Deviations of pixels";
  plot.x = {"difference in luminance, in its own standard deviations", false, -kEnd, kEnd};
  plot.y = {"share of pixels", true, std::max(0.1 / std::max(all, 1.0), 1e-7), 1.0};
  plot.bars = {bars};
  plot.series = {normal};
  return plot;
}

void add_maps(html::Page& page, const ImagePair& p, const measure::FilmComparison& r) {
  const double exposure = exposure_of(p);
  const std::string stops = " (exposure " + readable(exposure) + " stops)";
  const html::Figure films[] = {film_figure(p.name_a + stops, p.a.film, exposure),
                                film_figure(p.name_b + stops, p.b.film, exposure)};
  html::add_figures(page, films);
  const DifferenceMap map = difference_map(p);
  std::vector<html::Figure> maps{
      map_figure(map.picture, map.limit, "difference in luminance",
                 "Where the first picture is brighter: orange; where the second is: blue.")};
  if (r.variances_known) {
    const Differences d = measure(p.a.film, p.b.film);
    maps.push_back(map_figure(
        map_colours(d.sigmas, p.a.film.crop_width, ColourMap::diverging, -kMapSigmas, kMapSigmas),
        kMapSigmas, "difference in standard deviations",
        "Noise alone looks like even grain here; patches and edges of one colour are bias."));
    html::add_figures(page, maps);
    html::add_figure(page, {svg::draw(sigma_plot(d.sigmas)),
                            "With few samples each pixel's own deviation is noisy, and its tails "
                            "are heavier than the curve."});
  } else {
    html::add_figures(page, maps);
  }
}

}  // namespace

std::vector<ImageFigure> image_figures(const measure::FilmComparison& r) {
  using C = measure::ChannelComparison;
  std::vector<ImageFigure> f{
      {"mean of the first", [](const C& c) { return known(c.mean_a); }, false},
      {"mean of the second", [](const C& c) { return known(c.mean_b); }, false},
      {"bias (first - second)", [](const C& c) { return with_sign(c.bias); }, false},
      {"bias, +-", [](const C& c) { return known(c.bias_half_width); }},
      {"relative bias", [](const C& c) { return percent(c.relative_bias); }, false},
      {"relative bias, +-",
       [](const C& c) { return percent(c.bias_half_width / std::abs(c.mean_b)); }},
      {"MSE", [](const C& c) { return known(c.mse); }, false},
      {"MSE explained by noise", [](const C& c) { return known(c.explained_mse); }},
      {"MSE, systematic", [](const C& c) { return with_sign(c.systematic_mse); }},
      {"MSE, systematic, +-", [](const C& c) { return known(c.systematic_half_width); }},
      {"RMSE", [](const C& c) { return known(c.rmse); }, false},
      {"relative RMSE", [](const C& c) { return percent(c.relative_rmse); }, false},
  };
  if (!r.variances_known) std::erase_if(f, [](const ImageFigure& i) { return i.needs_variances; });
  return f;
}

std::vector<std::string> describe_pixels(const measure::FilmComparison& r) {
  std::vector<std::string> lines;
  if (r.largest) {
    lines.push_back("largest difference of a pixel: " + readable(r.largest->sigmas) + " sigma at " +
                    place(r.largest->x, r.largest->y) + " (p = " + readable(r.largest->p_value) +
                    " for the largest of all pixels)");
  }
  if (!r.variances_known) return lines;
  std::string tails = "pixels beyond";
  for (const measure::PixelTail& t : r.tails) {
    if (t.sigmas == 0) continue;
    tails += (t.sigmas > 3 ? ", " : " ") + readable(t.sigmas) +
             " sigma: " + readable_count(t.found) + " (noise: " + readable(t.expected) + ")";
  }
  if (r.tails[0].sigmas > 0) lines.push_back(tails);
  return lines;
}

std::string describe_verdict(const measure::FilmComparison& r) {
  if (!r.verdict) {
    return "whether there is a bias is not known: that takes the variances of both pictures, of "
           "two samples a pixel at least";
  }
  const measure::BiasVerdict& v = *r.verdict;
  const std::string odds = probability(v.p_value) + ", level " + readable(r.options.level);
  if (!v.detected) return "no bias detected (" + odds + ")";
  std::string text = "bias detected (" + odds + ")";
  if (v.regions_p_value <= v.pixels_p_value) {
    const measure::RegionDifference& w = v.worst;
    text += ": " + std::to_string(w.width) + " x " + std::to_string(w.height) + " pixels at " +
            place(w.x, w.y) + " differ by " + with_sign(w.bias) + " +- " + readable(w.deviation) +
            " (one sigma) in " + std::string(1, "RGB"[w.channel]);
  } else {
    text += ": pixels differ by more than noise, in both directions";
  }
  return text;
}

Film difference_film(const Film& a, const Film& b) {
  Film d = a;
  for (std::size_t i = 0; i < d.pixels.size(); ++i) {
    const PixelSums &pa = a.pixels[i], &pb = b.pixels[i];
    PixelSums& p = d.pixels[i];
    p = {};
    p.samples = pa.samples + pb.samples;
    const double n = p.samples;
    p.sum = (mean(pa) - mean(pb)) * n;
    p.sum_squares = (variance_of_mean(pa) + variance_of_mean(pb)) * (n * (n - 1)) +
                    p.sum * p.sum / std::max(n, 1.0);
  }
  return d;
}

DifferenceMap difference_map(const ImagePair& pair) {
  const Differences d = measure(pair.a.film, pair.b.film);
  DifferenceMap m;
  m.limit = limit_of(d.values);
  m.picture =
      map_colours(d.values, pair.a.film.crop_width, ColourMap::diverging, -m.limit, m.limit);
  return m;
}

html::Page image_page(const ImagePair& pair, const measure::FilmComparison& r) {
  html::Page page;
  page.title = std::filesystem::path(pair.name_a).filename().string() + " against " +
               std::filesystem::path(pair.name_b).filename().string();
  const html::Mood mood = !r.verdict            ? html::Mood::plain
                          : r.verdict->detected ? html::Mood::bad
                                                : html::Mood::good;
  std::string verdict = describe_verdict(r);
  verdict[0] = char(std::toupper(static_cast<unsigned char>(verdict[0])));
  html::add_verdict(page, verdict, mood);
  add_maps(page, pair, r);
  html::add_heading(page, "Figures");
  html::Table table;
  table.header = {"", "luminance", "R", "G", "B"};
  for (const ImageFigure& f : image_figures(r)) {
    table.rows.push_back({f.name, f.text(r.luminance)});
    for (const measure::ChannelComparison& c : r.channels) table.rows.back().push_back(f.text(c));
  }
  table.caption = "Means over " + readable_count(r.pixels) + " pixels; intervals at " +
                  readable(100 * r.options.confidence) + " % confidence";
  html::add_table(page, table);
  for (const std::string& line : describe_pixels(r)) html::add_paragraph(page, line);
  html::add_heading(page, "What the figures mean");
  html::add_paragraph(
      page,
      "Noise: the variance of each pixel's mean, from its own samples; the pictures are taken to "
      "be independent. Systematic: the MSE less what noise explains, an unbiased estimate that "
      "may fall below 0. The verdict tests the means of the picture, its quarters, their quarters "
      "and so on, and the systematic MSE, in every channel, with false alarms at the stated level "
      "for all tests together.");
  return page;
}

}  // namespace pvol::cli
