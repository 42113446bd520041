// The report of the verb `bounds` as a page.
#include <algorithm>
#include <filesystem>

#include "cli/cli.h"
#include "report/colour_map.h"
#include "report/svg.h"
#include "stats/bounds_report.h"
#include "stats/bounds_slices.h"

namespace pvol::cli {
namespace {

std::string edge_name(std::int64_t edge) {
  std::string name = std::to_string(edge);
  return name + (edge == 8 ? "³ voxels, the leaves" : "³ voxels");
}

/// "8^3", as terminals show it, with a raised figure.
std::string raised(std::string text) {
  for (std::size_t at; (at = text.find("^3")) != std::string::npos;) text.replace(at, 2, "³");
  return text;
}

// --- tables -------------------------------------------------------------------------------------

void add_lookups(html::Page& page, const BoundsReport& r) {
  html::add_heading(page, "Look-ups for each real collision");
  html::Table t;
  t.header = {"", "expected, even", "expected, dense", "measured"};
  for (const LookupFigure& f : lookup_figures(r)) {
    t.rows.push_back(
        {raised(f.name), f.expected ? readable(f.expected->even) : "",
         f.expected && f.expected->dense > 0 ? readable(f.expected->dense) : "",
         f.measured ? readable(f.measured->value) + " ± " + readable(f.measured->half_width) : ""});
  }
  html::add_table(page, t);
  html::add_paragraph(
      page,
      "Even: collisions lie as the density does, as where one can see through. Dense: places count "
      "once more by their density, as where paths stay in the core. Measured: a short render of "
      "the whole cloud from the front under an even sky, with its 95 % interval; paths at the rim "
      "of a thick cloud meet looser bounds than either expectation.");
}

void add_depths(html::Page& page, const BoundsReport& r) {
  html::Table t;
  t.caption = "Integrals of the bounds over the mass, for a walk that stops at a depth";
  t.header = {"depth",          "cube",  "cubes",          "leaves",
              "majorant, even", "dense", "residual, even", "dense"};
  for (const DepthStatistics& d : r.bounds.depths) {
    t.rows.push_back({std::to_string(d.depth), std::to_string(d.edge) + "³",
                      readable_count(d.nodes), readable_count(d.leaves),
                      readable(d.tightness.majorant.even), readable(d.tightness.majorant.dense),
                      readable(d.tightness.residual.even), readable(d.tightness.residual.dense)});
  }
  html::add_table(page, t);
}

void add_space_and_bytes(html::Page& page, const BoundsReport& r) {
  html::add_heading(page, "Space and memory");
  const BoundsStatistics& s = r.bounds;
  html::Table space;
  space.header = {"in the root's cube", "cubes", "volume", "mass"};
  const auto row = [&](const char* name, const ClassStatistics& c) {
    space.rows.push_back({name, readable_count(c.leaves),
                          readable(100 * c.volume / s.root_volume) + " %",
                          readable(100 * c.mass / s.mass) + " %"});
  };
  row("empty", s.empty);
  row("uniform", s.uniform);
  row("mixed", s.mixed);
  html::add_table(page, space);
  html::add_paragraph(page, "Walks skip " + readable(100 * r.empty_share_of_box) +
                                " % of the box around the density.");
  html::Table bytes;
  bytes.header = {"part", "in the file", "in memory"};
  const auto stored = [&](std::uint64_t formats::PvolSizes::*part) {
    return r.bytes ? readable_bytes((*r.bytes).*part) : "";
  };
  const VolumeFacts& f = r.cut->facts;
  bytes.rows = {{"density", stored(&formats::PvolSizes::density), readable_bytes(f.field_bytes)},
                {"bounds", stored(&formats::PvolSizes::bounds), readable_bytes(f.octree_bytes)},
                {"micro-bounds of 2³ voxels, if used", stored(&formats::PvolSizes::micro),
                 readable_bytes(r.probe->squeezed.micro_bytes)},
                {"shell", stored(&formats::PvolSizes::shell), ""},
                {"header and metadata",
                 r.bytes ? readable_bytes(r.bytes->header + r.bytes->metadata) : "", ""}};
  html::add_table(page, bytes);
}

// --- plots --------------------------------------------------------------------------------------

svg::Series by_depth(const BoundsReport& r, const std::string& name,
                     double (*value)(const Tightness&), int colour, bool dashed) {
  svg::Series s{name, {}, svg::Style::line, colour, dashed};
  for (const DepthStatistics& d : r.bounds.depths) {
    s.points.push_back({double(d.depth), value(d.tightness)});
  }
  return s;
}

html::Figure depth_plot(const BoundsReport& r) {
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
  return {svg::draw(p), "Finer cubes bound more tightly, and take more steps to walk."};
}

/// The middle of the distribution of hi / mean, by depth.
html::Figure quantile_plot(const BoundsReport& r) {
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
  return {svg::draw(p), "What these shares of the mass do not exceed; 1 is the best there is."};
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
html::Figure histogram(const TwoDistributions& d, const std::string& title,
                       const std::string& ratio) {
  svg::Plot p;
  p.title = title;
  p.x = {ratio, true};
  p.y = {"% of volume or mass"};
  p.bars = {bars_of(d.by_volume, "by volume", 0), bars_of(d.by_mass, "by mass", 1)};
  std::string caption = "Four bins to a factor of two.";
  if (d.by_volume.below > 0) {
    caption += " 0 or too small to show: " + readable(100 * d.by_volume.below) +
               " % of the volume, " + readable(100 * d.by_mass.below) + " % of the mass.";
  }
  if (d.by_volume.above > 0) {
    caption += " Beyond: " + readable(100 * d.by_volume.above) + " % of the volume.";
  }
  return {svg::draw(p), caption};
}

void add_histograms(html::Page& page, const BoundsReport& r) {
  html::add_heading(page, "How tight, and where");
  const html::Figure by_depth[] = {depth_plot(r), quantile_plot(r)};
  html::add_figures(page, by_depth);
  add_depths(page, r);
  // The leaves, and cubes two levels above them.
  const std::size_t count = r.distributions.size();
  std::vector<std::size_t> shown{count - 1};
  if (count > 3) shown.push_back(count - 3);
  for (const std::size_t i : shown) {
    const DepthDistributions& d = r.distributions[i];
    const std::string cubes = " in cubes of " + edge_name(r.bounds.depths[i].edge);
    const html::Figure figures[] = {
        histogram(d.hi, "Majorants" + cubes, "hi / mean density of the cube"),
        histogram(d.lo, "Minorants" + cubes, "lo / mean density of the cube"),
        histogram(d.gap, "Gaps" + cubes, "(hi - lo) / mean density of the cube")};
    html::add_figures(page, figures);
  }
}

// --- pictures -----------------------------------------------------------------------------------

void add_slices(html::Page& page, const BoundsReport& r) {
  html::add_heading(page, "Slices through the middle");
  const Shell* const shell = r.cloud.shell ? &*r.cloud.shell : nullptr;
  const std::vector<BoundsSlice> slices = slice_bounds(r.cloud.grid, r.cloud.pyramid, shell);
  std::vector<html::Figure> figures;
  for (const BoundsSlice& s : slices) {
    const std::string across = std::string("across ") + "xyz"[s.across];
    figures.push_back({html::image(formats::encode_png(s.picture), "slice " + across, false),
                       across + ", cubes of " + edge_name(s.edge)});
  }
  html::add_figures(page, figures);
  html::add_figure(
      page,
      {colour_bar(ColourMap::sequential, 0, double(r.cloud.pyramid.scale),
                  "hi - lo at the borders"),
       std::string("Grey is density, on a root scale. Borders of cubes have the colour of their "
                   "gap: where they are yellow, decisions need look-ups.") +
           (shell != nullptr ? " Orange: the shell." : "")});
}

void add_heat_map(html::Page& page, const measure::Probe& p) {
  html::add_heading(page, "Where the look-ups are");
  std::vector<double> lookups, collisions;
  for (const PixelSums& s : p.film.pixels) {
    const double n = std::max(1.0, double(s.samples));
    lookups.push_back(double(s.lookups) / n);
    collisions.push_back(s.collisions > 0 ? double(s.lookups) / double(s.collisions) : 0);
  }
  const auto figure = [&](const std::vector<double>& values, const std::string& label,
                          const std::string& caption) {
    const double most = std::max(quantile(values, 0.995), 1e-12);
    return html::Figure{html::image(formats::encode_png(map_colours(
                                        values, p.film.crop_width, ColourMap::sequential, 0, most)),
                                    label, true) +
                            colour_bar(ColourMap::sequential, 0, most, label),
                        caption};
  };
  const html::Figure figures[] = {
      figure(lookups, "look-ups for each path",
             "Decomposition without micro-bounds, " + std::to_string(p.film.pixels[0].samples) +
                 " paths a pixel."),
      figure(collisions, "look-ups for each real collision",
             "What the bounds leave open: high at the rim, where cubes hold cloud and air.")};
  html::add_figures(page, figures);
}

}  // namespace

html::Page bounds_page(const BoundsReport& r) {
  html::Page page;
  page.title = "Bounds of " + std::filesystem::path(r.file).filename().string();
  html::add_paragraph(page, "Grid " + r.cloud.report.grid + ", " + describe_size(r) + ".");
  if (r.check) {
    html::add_verdict(page,
                      readable_count(r.check->leaves) + " leaves and " +
                          readable_count(r.check->uniform) + " uniform cubes hold their samples",
                      html::Mood::good);
  }
  if (!r.probe) return page;  // a cloud without density
  const VolumeFacts& f = r.cut->facts;
  html::add_paragraph(
      page, "At extinction " + readable(r.cut->extinction) +
                " per world unit: shortest free path " + readable(f.shortest_free_path) +
                " world units, largest optical thickness " + readable(f.largest_optical_thickness) +
                ", mean along the axes " + readable(f.mean_optical_thickness[0]) + ", " +
                readable(f.mean_optical_thickness[1]) + " and " +
                readable(f.mean_optical_thickness[2]) + "; the walk stops at depth " +
                std::to_string(f.depth) + " or above.");
  add_lookups(page, r);
  add_slices(page, r);
  add_heat_map(page, *r.probe);
  add_histograms(page, r);
  add_space_and_bytes(page, r);
  return page;
}

}  // namespace pvol::cli
