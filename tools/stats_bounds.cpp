// The verb `bounds`: how tight the bounds of a cloud are.
#include <iostream>

#include "json.h"
#include "pvol/bounds/statistics.h"
#include "pvol/render/volume.h"
#include "stats.h"

namespace pvol::cli {
namespace {

/// What depends on the extinction.
struct Cut {
  VolumeFacts facts;
  Tightness tightness;
};

struct Report {
  formats::Cloud cloud;
  BoundsStatistics bounds;
  std::optional<Cut> cut;
  std::optional<formats::PvolSizes> bytes;  ///< of a .pvol file
};

Report measure(const BoundsOptions& o) {
  Report r;
  r.cloud = formats::load_cloud(o.input, o.grid);
  const PyramidContent content = measure_content(r.cloud.grid, r.cloud.pyramid);
  r.bounds = measure_bounds(r.cloud.pyramid, content);
  if (o.extinction && !r.cloud.pyramid.empty()) {
    Scene scene;
    scene.medium.extinction = *o.extinction;
    const Volume v =
        naming(o.input, [&] { return make_volume(r.cloud.grid, r.cloud.pyramid, scene); });
    r.cut = {describe(v, r.cloud.grid, scene.medium),
             measure_cut(r.cloud.pyramid, content, v.octree, *o.extinction)};
  }
  if (formats::ending(o.input) == ".pvol") r.bytes = formats::measure_pvol(o.input);
  return r;
}

// --- text ---------------------------------------------------------------------------------------

std::string column(const std::string& text, std::size_t width) {
  return std::string(width > text.size() ? width - text.size() : 1, ' ') + text;
}

void print_row(const std::vector<std::string>& cells) {
  for (std::size_t i = 0; i < cells.size(); ++i) std::cout << column(cells[i], i == 0 ? 7 : 11);
  std::cout << '\n';
}

void print_depths(const BoundsStatistics& s) {
  std::cout
      << "\ndepth by depth; look-ups per collision for a walk that stops there\n"
      << "                                                                 delta              "
         " decomposition\n";
  print_row(
      {"depth", "edge", "nodes", "leaves", "hi/mean", "lo/mean", "even", "dense", "even", "dense"});
  for (const DepthStatistics& d : s.depths) {
    print_row({std::to_string(d.depth), std::to_string(d.edge), std::to_string(d.nodes),
               std::to_string(d.leaves), readable(d.mean_hi), readable(d.mean_lo),
               readable(d.tightness.majorant.even), readable(d.tightness.majorant.dense),
               readable(d.tightness.residual.even), readable(d.tightness.residual.dense)});
  }
}

void print_class(const char* name, const ClassStatistics& c, const BoundsStatistics& s) {
  print_row({name, readable_count(c.leaves), readable(100 * c.volume / s.root_volume) + " %",
             readable(100 * c.mass / s.mass) + " %"});
}

void print_lookups(const Report& r) {
  const BoundsStatistics& s = r.bounds;
  const auto row = [](const std::string& name, const CollisionCost& c) {
    std::cout << "  " << name << std::string(name.size() < 44 ? 44 - name.size() : 1, ' ')
              << column(readable(c.even), 10) << column(readable(c.dense), 10) << '\n';
  };
  std::cout << "\nexpected look-ups per collision                     even     dense\n";
  row("delta, one majorant over the box", s.global_majorant);
  row("delta, leaves of 8^3", s.depths.back().tightness.majorant);
  row("decomposition, leaves of 8^3", s.depths.back().tightness.residual);
  if (!r.cut) return;
  row("delta, the cut of the cost model", r.cut->tightness.majorant);
  row("decomposition, the cut of the cost model", r.cut->tightness.residual);
}

void print_cut(double extinction, const VolumeFacts& f) {
  std::cout << "\nat extinction " << readable(extinction) << " per world unit: largest "
            << readable(f.largest_extinction) << ", shortest free path "
            << readable(f.shortest_free_path) << " world units\n"
            << "mean optical thickness along the axes " << readable(f.mean_optical_thickness[0])
            << ", " << readable(f.mean_optical_thickness[1]) << ", "
            << readable(f.mean_optical_thickness[2]) << "; largest "
            << readable(f.largest_optical_thickness) << '\n'
            << "the walk stops at depth " << f.depth << " or above\n";
}

void report_text(const BoundsOptions& o, const Report& r) {
  const Pyramid& p = r.cloud.pyramid;
  std::cout << o.input.string() << ": grid " << r.cloud.report.grid;
  if (p.empty()) {
    std::cout << ", the density is 0 everywhere\n";
    return;
  }
  const Vec3l cells = p.support_hi - p.support_lo;
  std::cout << ", " << cells.x << " x " << cells.y << " x " << cells.z
            << " voxels, largest density " << readable(double(p.scale)) << '\n';
  print_depths(r.bounds);
  std::cout << "\nclasses of space in the root's cube\n";
  print_row({"", "leaves", "volume", "mass"});
  print_class("empty", r.bounds.empty, r.bounds);
  print_class("uniform", r.bounds.uniform, r.bounds);
  print_class("mixed", r.bounds.mixed, r.bounds);
  print_lookups(r);
  if (r.cut) print_cut(*o.extinction, r.cut->facts);
  if (!r.bytes) return;
  std::cout << "\nbytes: header " << r.bytes->header << ", metadata " << r.bytes->metadata
            << ", bounds " << r.bytes->bounds << ", micro-bounds " << r.bytes->micro << ", shell "
            << r.bytes->shell << ", density " << r.bytes->density << ", total " << r.bytes->total
            << '\n';
}

// --- JSON ---------------------------------------------------------------------------------------

Json to_json(const CollisionCost& c) { return {{"even", c.even}, {"dense", c.dense}}; }

Json to_json(const ClassStatistics& c) {
  return {{"leaves", c.leaves}, {"volume_voxels", c.volume}, {"mass", c.mass}};
}

Json to_json(const VolumeFacts& f) {
  return {{"largest_extinction", f.largest_extinction},
          {"shortest_free_path", f.shortest_free_path},
          {"mean_optical_thickness", f.mean_optical_thickness},
          {"largest_optical_thickness", f.largest_optical_thickness},
          {"depth", f.depth}};
}

void report_json(const BoundsOptions& o, const Report& r) {
  const BoundsStatistics& s = r.bounds;
  Json j;
  j["file"] = o.input.string();
  j["grid"] = r.cloud.report.grid;
  j["largest_density"] = r.cloud.pyramid.scale;
  j["mass"] = s.mass;
  j["depths"] = Json::array();
  for (const DepthStatistics& d : s.depths) {
    j["depths"].push_back({{"depth", d.depth},
                           {"edge_voxels", d.edge},
                           {"nodes", d.nodes},
                           {"leaves", d.leaves},
                           {"mean_hi_over_mean", d.mean_hi},
                           {"mean_lo_over_mean", d.mean_lo},
                           {"majorant_over_mass", to_json(d.tightness.majorant)},
                           {"residual_over_mass", to_json(d.tightness.residual)}});
  }
  j["classes"] = {
      {"empty", to_json(s.empty)}, {"uniform", to_json(s.uniform)}, {"mixed", to_json(s.mixed)}};
  j["lookups_per_collision"]["delta_global"] = to_json(s.global_majorant);
  if (!s.depths.empty()) {
    j["lookups_per_collision"]["delta_leaves"] = to_json(s.depths.back().tightness.majorant);
    j["lookups_per_collision"]["decomposition_leaves"] =
        to_json(s.depths.back().tightness.residual);
  }
  if (r.cut) {
    j["lookups_per_collision"]["delta_cut"] = to_json(r.cut->tightness.majorant);
    j["lookups_per_collision"]["decomposition_cut"] = to_json(r.cut->tightness.residual);
    j["extinction"] = *o.extinction;
    j["volume"] = to_json(r.cut->facts);
  }
  if (r.bytes) {
    j["bytes"] = {{"header", r.bytes->header}, {"metadata", r.bytes->metadata},
                  {"bounds", r.bytes->bounds}, {"micro", r.bytes->micro},
                  {"shell", r.bytes->shell},   {"density", r.bytes->density},
                  {"total", r.bytes->total}};
  }
  std::cout << to_text(j);
}

}  // namespace

int run_bounds(const BoundsOptions& o) {
  const Report r = measure(o);
  print_warnings("pvol-stats", r.cloud.report.warnings);
  if (o.json) {
    report_json(o, r);
  } else {
    report_text(o, r);
  }
  return kSuccess;
}

}  // namespace pvol::cli
