// The report of the verb `bounds` as a document.
#include "stats/bounds_report.h"

#include <fmt/format.h>

#include <filesystem>

#include "cli/cli.h"

namespace pvol::cli {
namespace {

using report::Heading;
using report::Shown;
using report::Table;
using report::Text;

std::string describe_size(const BoundsReport& r) {
  const Pyramid& p = r.cloud.pyramid;
  if (p.empty()) return "the density is 0 everywhere";
  const Vec3l cells = p.support_hi - p.support_lo;
  return fmt::format("{} x {} x {} voxels, largest density {:.4g}", cells.x, cells.y, cells.z,
                     double(p.scale));
}

std::string number(double v) { return readable(v); }
std::string percent(double share) { return fmt::format("{:.4g} %", 100 * share); }

Table depth_table(const BoundsStatistics& s) {
  Table t{.caption = "depth by depth; look-ups per collision for a walk that stops there",
          .header = {"depth", "cube", "nodes", "leaves", "hi/mean", "lo/mean", "delta, even",
                     "dense", "decomposition, even", "dense"}};
  for (const DepthStatistics& d : s.depths) {
    t.rows.push_back({fmt::format("{}", d.depth), fmt::format("{}³", d.edge),
                      readable_count(d.nodes), readable_count(d.leaves), number(d.mean_hi),
                      number(d.mean_lo), number(d.tightness.majorant.even),
                      number(d.tightness.majorant.dense), number(d.tightness.residual.even),
                      number(d.tightness.residual.dense)});
  }
  return t;
}

Table quantile_table(const DepthDistributions& d) {
  Table t{.caption = "in the leaves: upper limits for 5, 25, 50, 75 and 95 % of volume or mass",
          .header = {"", "5 %", "25 %", "50 %", "75 %", "95 %"}};
  const auto add = [&](const char* name, const Distribution& values) {
    t.rows.push_back({name});
    for (const double q : values.quantiles) t.rows.back().push_back(number(q));
  };
  add("hi/mean, by volume", d.hi.by_volume);
  add("hi/mean, by mass", d.hi.by_mass);
  add("lo/mean, by volume", d.lo.by_volume);
  add("lo/mean, by mass", d.lo.by_mass);
  add("gap/mean, by volume", d.gap.by_volume);
  add("gap/mean, by mass", d.gap.by_mass);
  return t;
}

Table class_table(const BoundsStatistics& s) {
  Table t{.caption = "classes of space in the root's cube",
          .header = {"", "leaves", "volume", "mass"}};
  const auto add = [&](const char* name, const ClassStatistics& c) {
    t.rows.push_back({name, readable_count(c.leaves), percent(c.volume / s.root_volume),
                      percent(c.mass / s.mass)});
  };
  add("empty", s.empty);
  add("uniform", s.uniform);
  add("mixed", s.mixed);
  return t;
}

/// Expectations: dense is 0 where it is not known.
Table lookup_table(const BoundsReport& r) {
  Table t{.caption = "expected look-ups per collision", .header = {"", "even", "dense"}};
  if (r.probe) t.header.push_back("measured");
  const auto add = [&](const char* name, const CollisionCost& expected,
                       const measure::PathCosts* measured) {
    t.rows.push_back(
        {name, number(expected.even), expected.dense > 0 ? number(expected.dense) : ""});
    if (!r.probe) return;
    t.rows.back().push_back(measured ? fmt::format("{:.4g} ± {:.4g}", measured->lookups.value,
                                                   measured->lookups.half_width)
                                     : "");
  };
  const Tightness& leaves = r.bounds.depths.back().tightness;
  add("delta, one majorant over the box", r.bounds.global_majorant, nullptr);
  add("delta, leaves of 8³", leaves.majorant, nullptr);
  add("decomposition, leaves of 8³", leaves.residual, nullptr);
  if (!r.cut) return t;
  const measure::Probe* const p = r.probe ? &*r.probe : nullptr;
  add("delta, the cut of the cost model", r.cut->tightness.majorant, p ? &p->delta : nullptr);
  add("decomposition, the cut of the cost model", r.cut->tightness.residual,
      p ? &p->decomposition : nullptr);
  if (p) add("the same with micro-bounds of 2³ voxels", {p->squeezed_expected, 0}, &p->squeezed);
  return t;
}

Text cut_text(const BoundsReport::Cut& cut) {
  const VolumeFacts& f = cut.facts;
  const double* const t = f.mean_optical_thickness;
  return {fmt::format(
      "at extinction {:.4g} per world unit: largest {:.4g}, shortest free path {:.4g} world units; "
      "mean optical thickness along the axes {:.4g}, {:.4g}, {:.4g}; largest {:.4g}; the walk "
      "stops "
      "at depth {} or above",
      cut.extinction, f.largest_extinction, f.shortest_free_path, t[0], t[1], t[2],
      f.largest_optical_thickness, f.depth)};
}

/// To the byte, for terminals.
std::vector<report::Content> byte_lines(const BoundsReport& r) {
  std::vector<report::Content> lines;
  if (r.bytes) {
    const formats::PvolSizes& b = *r.bytes;
    lines.push_back(
        Text{fmt::format("bytes: header {}, metadata {}, bounds {}, micro-bounds {}, shell {}, "
                         "density {}, fields {}, padding {}, total {}",
                         b.header, b.metadata, b.bounds, b.micro, b.shell, b.density, b.fields,
                         b.padding(), b.total)});
  }
  if (r.cut) {
    lines.push_back(Text{fmt::format(
        "in memory: density {}, octree {}{}", readable_bytes(r.cut->facts.field_bytes),
        readable_bytes(r.cut->facts.octree_bytes),
        r.probe ? ", micro-bounds of 2³ voxels " + readable_bytes(r.probe->squeezed.micro_bytes)
                : "")});
  }
  return lines;
}

/// Beside each other, for pages; the cloud was probed.
Table byte_table(const BoundsReport& r) {
  const auto stored = [&](std::uint64_t formats::PvolSizes::*part) {
    return r.bytes ? readable_bytes((*r.bytes).*part) : "";
  };
  using P = formats::PvolSizes;
  const VolumeFacts& f = r.cut->facts;
  return {.header = {"part", "in the file", "in memory"},
          .rows = {{"density", stored(&P::density), readable_bytes(f.field_bytes)},
                   {"bounds", stored(&P::bounds), readable_bytes(f.octree_bytes)},
                   {"micro-bounds of 2³ voxels, if used", stored(&P::micro),
                    readable_bytes(r.probe->squeezed.micro_bytes)},
                   {"shell", stored(&P::shell), ""},
                   {"header and metadata",
                    r.bytes ? readable_bytes(r.bytes->header + r.bytes->metadata) : "", ""}}};
}

/// The part that a page begins with and a terminal ends with.
std::vector<report::Content> lookup_part(const BoundsReport& r) {
  return {Heading{"Look-ups for each real collision"}, lookup_table(r)};
}

constexpr const char* kLookupNotes =
    "Even: collisions are distributed like the density, as in thin clouds. Dense: places are "
    "weighted by their density once more, as where paths stay in the core. Measured: a short "
    "render of the whole cloud from the front under an even sky, with its 95 % interval; paths at "
    "the rim of a thick cloud meet looser bounds than either expectation.";

}  // namespace

namespace {

report::Table field_table(const BoundsReport& r) {
  report::Table t{.caption = "further grids of the file; more of one with --grid NAME",
                  .header = {"grid", "largest", "leaves", "hi/mean", "(hi - lo)/mean", "bounds"}};
  for (const BoundsReport::Field& f : r.fields) {
    t.rows.push_back({f.name, readable(double(f.largest)), readable_count(f.leaves),
                      readable(f.tightness.majorant.even), readable(f.tightness.residual.even),
                      f.verified ? "hold" : ""});
  }
  return t;
}

}  // namespace

report::Document bounds_document(const BoundsReport& r, bool pictures) {
  report::Document d{.title = "Bounds of " + std::filesystem::path(r.file).filename().string(),
                     .subject = r.file,
                     .lead = fmt::format("grid {}, {}", r.cloud.report.grid, describe_size(r))};
  if (r.check) {
    add(d, report::Verdict{
               fmt::format("verified: the bounds of {} leaves and {} uniform cubes hold",
                           readable_count(r.check->leaves), readable_count(r.check->uniform)),
               report::Mood::good});
  }
  if (r.cloud.pyramid.empty()) {
    if (!r.fields.empty()) add(d, field_table(r));
    return d;
  }
  if (pictures) {
    add(d, cut_text(*r.cut), Shown::on_page);
    add(d, lookup_part(r), Shown::on_page);
    add(d, Text{kLookupNotes}, Shown::on_page);
    add(d, picture_parts(r), Shown::on_page);
    add(d, Heading{"How tight, and where"}, Shown::on_page);
    add(d, depth_figures(r), Shown::on_page);
  }
  add(d, depth_table(r.bounds));
  add(d, quantile_table(r.distributions.back()));
  if (pictures) add(d, histogram_parts(r), Shown::on_page);
  if (!r.fields.empty()) add(d, field_table(r));
  add(d, Heading{"Space and memory"});
  add(d, class_table(r.bounds));
  add(d, Text{fmt::format("walks skip {} of the box around the density",
                          percent(r.empty_share_of_box))});
  add(d, lookup_part(r), Shown::on_terminal);
  if (r.cut) add(d, cut_text(*r.cut), Shown::on_terminal);
  add(d, byte_lines(r), Shown::on_terminal);
  if (pictures) add(d, byte_table(r), Shown::on_page);
  return d;
}

}  // namespace pvol::cli
