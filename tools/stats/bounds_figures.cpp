// What the report of the verb `bounds` draws.
#include <fmt/format.h>

#include <algorithm>
#include <array>

#include "cli/cli.h"
#include "pvol/measure/pixel_maps.h"
#include "report/colour_map.h"
#include "report/html.h"
#include "report/svg.h"
#include "stats/bounds_report.h"
#include "stats/bounds_slices.h"

namespace pvol::cli {
namespace {

// --- plots --------------------------------------------------------------------------------------

svg::Series by_depth(const BoundsReport& r, const std::string& name,
                     double (*value)(const Tightness&), int colour, bool dashed) {
  svg::Series s{name, {}, svg::Style::line, colour, dashed};
  for (const DepthStatistics& d : r.bounds.depths) {
    s.points.push_back({double(d.depth), value(d.tightness)});
  }
  return s;
}

report::Figure depth_plot(const BoundsReport& r) {
  svg::Plot p;
  p.title = "Look-ups for each collision, by depth";
  p.x = {"octree depth at which the walk stops"};
  p.y = {"expected look-ups for each real collision", true};
  p.series = {
      by_depth(
          r, "delta, even", [](const Tightness& t) { return t.majorant.even; }, 0, false),
      by_depth(
          r, "delta, dense", [](const Tightness& t) { return t.majorant.dense; }, 0, true),
      by_depth(
          r, "decomposition, even", [](const Tightness& t) { return t.residual.even; }, 1, false),
      by_depth(
          r, "decomposition, dense", [](const Tightness& t) { return t.residual.dense; }, 1, true)};
  return {svg::draw(p), "Finer cubes have tighter bounds, but walks take more steps."};
}

/// The middle of the distribution of hi / mean, by depth.
report::Figure quantile_plot(const BoundsReport& r) {
  svg::Plot p;
  p.title = "Tightness of the majorant, by depth";
  p.x = {"octree depth"};
  p.y = {"hi / mean density of the cube, by mass", true};
  constexpr std::array<const char*, 5> kNames = {"5 %", "25 %", "half", "75 %", "95 % of the mass"};
  for (const std::size_t q : {std::size_t(0), std::size_t(2), std::size_t(4)}) {
    svg::Series s{kNames[q], {}, svg::Style::line, q == 2 ? 0 : 5, q != 2};
    for (const DepthDistributions& d : r.distributions) {
      s.points.push_back({double(d.depth), d.hi.by_mass.quantiles[q]});
    }
    p.series.push_back(s);
  }
  return {svg::draw(p), "Upper limits for these shares of the mass; 1 is the optimum."};
}

svg::Bars bars_of(const Distribution& d, const std::string& name, int colour) {
  svg::Bars bars{name, {}, colour};
  for (std::size_t i = 0; i < Distribution::kBins; ++i) {
    if (d.share[i] == 0) continue;
    bars.bars.push_back({Distribution::edge(i), Distribution::edge(i + 1), 100 * d.share[i]});
  }
  return bars;
}

/// Histograms of one ratio. What lies off the scale, above all 0, is said below.
report::Figure histogram(const TwoDistributions& d, const std::string& title,
                         const std::string& ratio) {
  svg::Plot p;
  p.title = title;
  p.x = {ratio, true};
  p.y = {"% of volume or mass"};
  p.bars = {bars_of(d.by_volume, "by volume", 0), bars_of(d.by_mass, "by mass", 1)};
  std::string caption = "Four bins to a factor of two.";
  if (d.by_volume.below > 0) {
    caption += fmt::format(" 0 or too small to show: {:.4g} % of the volume, {:.4g} % of the mass.",
                           100 * d.by_volume.below, 100 * d.by_mass.below);
  }
  if (d.by_volume.above > 0) {
    caption += fmt::format(" Beyond: {:.4g} % of the volume.", 100 * d.by_volume.above);
  }
  return {svg::draw(p), caption};
}

// --- pictures -----------------------------------------------------------------------------------

report::Figure gap_scale(const BoundsReport& r) {
  return {
      colour_bar(ColourMap::sequential, 0, double(r.cloud.pyramid.scale), "hi - lo at the borders"),
      std::string("Grey is density, on a square root scale. Borders of cubes have the colour of "
                  "their gap: where they are yellow, decisions need look-ups.") +
          (r.cloud.shell ? " Orange: the shell." : "")};
}

report::Figure heat_map(const Film& film, const std::vector<double>& values,
                        const std::string& label, const std::string& caption) {
  const double most = std::max(measure::quantile(values, 0.995), 1e-12);
  const formats::Picture p = map_colours(values, film.crop_width, ColourMap::sequential, 0, most);
  return {html::image(formats::encode_png(p), label, true) +
              colour_bar(ColourMap::sequential, 0, most, label),
          caption};
}

report::Figures heat_maps(const Film& film) {
  return {
      {heat_map(film, measure::lookups_per_sample(film), "look-ups for each path",
                fmt::format("Decomposition without micro-bounds, {} paths per pixel.",
                            film.pixels[0].samples)),
       heat_map(film, measure::lookups_per_collision(film), "look-ups for each real collision",
                "High at the rim, where cubes contain both cloud and air and bounds are loose.")}};
}

}  // namespace

std::vector<report::Content> picture_parts(const BoundsReport& r) {
  return {report::Heading{"Slices through the middle"},
          report::Figures{slice_figures(r.cloud, true)}, report::Figures{{gap_scale(r)}},
          report::Heading{"Where the look-ups are"}, heat_maps(r.probe->film)};
}

report::Figures depth_figures(const BoundsReport& r) { return {{depth_plot(r), quantile_plot(r)}}; }

std::vector<report::Content> histogram_parts(const BoundsReport& r) {
  // The leaves, and cubes two levels above them.
  const std::size_t count = r.distributions.size();
  std::vector<std::size_t> shown{count - 1};
  if (count > 3) shown.push_back(count - 3);
  std::vector<report::Content> parts;
  for (const std::size_t i : shown) {
    const DepthDistributions& d = r.distributions[i];
    const std::string cubes = " in cubes of " + cube_name(r.bounds.depths[i].edge);
    parts.push_back(report::Figures{
        {histogram(d.hi, "Majorants" + cubes, "hi / mean density of the cube"),
         histogram(d.lo, "Minorants" + cubes, "lo / mean density of the cube"),
         histogram(d.gap, "Gaps" + cubes, "(hi - lo) / mean density of the cube")}});
  }
  return parts;
}

}  // namespace pvol::cli
