// The verb `bounds`: how tight the bounds of a cloud are, and whether they hold.
#include <iostream>

#include "pvol/error.h"
#include "pvol/render/scene_volume.h"
#include "pvol/volume/facts.h"
#include "stats/bounds_report.h"
#include "stats/stats.h"

namespace pvol::cli {
namespace {

constexpr std::size_t kNamed = 20;  // wrong bounds in the text; JSON has all

void measure_cut(BoundsReport& r, const PyramidContent& content, const BoundsOptions& o) {
  const double extinction = r.probe ? r.probe->extinction : *o.extinction;
  Scene scene;
  scene.medium.extinction = extinction;
  const Volume v =
      naming(o.input, [&] { return make_volume(r.cloud.grid, r.cloud.pyramid, scene); });
  r.cut = {extinction, describe(v, r.cloud.grid, scene.medium),
           pvol::measure_cut(r.cloud.pyramid, content, v.octree, extinction)};
}

BoundsReport measure(const BoundsOptions& o, formats::Cloud cloud) {
  BoundsReport r;
  r.file = o.input.string();
  r.cloud = std::move(cloud);
  const PyramidContent content = measure_content(r.cloud.grid, r.cloud.pyramid);
  r.bounds = measure_bounds(r.cloud.pyramid, content);
  r.distributions = measure_distributions(r.cloud.pyramid, content);
  r.empty_share_of_box = empty_share_of_box(r.cloud.pyramid);
  if (formats::ending(o.input) == ".pvol") r.bytes = formats::measure_pvol(o.input);
  if (r.cloud.pyramid.empty()) return r;
  if (o.measure || o.html) {
    measure::ProbeOptions options;
    options.extinction = o.extinction;
    r.probe = naming(o.input, [&] { return probe(r.cloud.grid, r.cloud.pyramid, options); });
  }
  if (o.extinction || r.probe) measure_cut(r, content, o);
  return r;
}

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

void print_quantiles(const std::string& name, const TwoDistributions& d) {
  for (const auto& [by, distribution] :
       {std::pair("volume", &d.by_volume), std::pair("mass", &d.by_mass)}) {
    std::cout << column(name, 10) << column(by, 8);
    for (const double q : distribution->quantiles) std::cout << column(readable(q), 11);
    std::cout << '\n';
  }
}

void print_distributions(const BoundsReport& r) {
  std::cout << "\nin the leaves: what 5, 25, 50, 75 and 95 % of volume or mass do not exceed\n";
  const DepthDistributions& d = r.distributions.back();
  print_quantiles("hi/mean", d.hi);
  print_quantiles("lo/mean", d.lo);
  print_quantiles("gap/mean", d.gap);
}

void print_class(const char* name, const ClassStatistics& c, const BoundsStatistics& s) {
  print_row({name, readable_count(c.leaves), readable(100 * c.volume / s.root_volume) + " %",
             readable(100 * c.mass / s.mass) + " %"});
}

void print_lookups(const BoundsReport& r) {
  std::cout << "\nexpected look-ups per collision                     even     dense"
            << (r.probe ? "   measured" : "") << '\n';
  for (const LookupFigure& f : lookup_figures(r)) {
    std::cout << "  " << f.name << std::string(f.name.size() < 44 ? 44 - f.name.size() : 1, ' ')
              << column(f.expected ? readable(f.expected->even) : "", 10)
              << column(f.expected && f.expected->dense > 0 ? readable(f.expected->dense) : "", 10);
    if (f.measured) {
      std::cout << column(readable(f.measured->value), 11) << " +- "
                << readable(f.measured->half_width);
    }
    std::cout << '\n';
  }
}

void print_cut(const BoundsReport::Cut& cut) {
  const VolumeFacts& f = cut.facts;
  std::cout << "\nat extinction " << readable(cut.extinction) << " per world unit: largest "
            << readable(f.largest_extinction) << ", shortest free path "
            << readable(f.shortest_free_path) << " world units\n"
            << "mean optical thickness along the axes " << readable(f.mean_optical_thickness[0])
            << ", " << readable(f.mean_optical_thickness[1]) << ", "
            << readable(f.mean_optical_thickness[2]) << "; largest "
            << readable(f.largest_optical_thickness) << '\n'
            << "the walk stops at depth " << f.depth << " or above\n";
}

void print_bytes(const BoundsReport& r) {
  if (r.bytes) {
    std::cout << "\nbytes: header " << r.bytes->header << ", metadata " << r.bytes->metadata
              << ", bounds " << r.bytes->bounds << ", micro-bounds " << r.bytes->micro << ", shell "
              << r.bytes->shell << ", density " << r.bytes->density << ", total " << r.bytes->total
              << '\n';
  }
  if (r.cut) {
    std::cout << "in memory: density " << readable_bytes(r.cut->facts.field_bytes) << ", octree "
              << readable_bytes(r.cut->facts.octree_bytes);
    if (r.probe) {
      std::cout << ", micro-bounds of 2^3 voxels " << readable_bytes(r.probe->squeezed.micro_bytes);
    }
    std::cout << '\n';
  }
}

void report_text(const BoundsReport& r) {
  std::cout << r.file << ": grid " << r.cloud.report.grid << ", " << describe_size(r) << '\n';
  if (r.check) {
    std::cout << "verified: " << readable_count(r.check->leaves) << " leaves and "
              << readable_count(r.check->uniform) << " uniform cubes hold their samples\n";
  }
  if (r.cloud.pyramid.empty()) return;
  print_depths(r.bounds);
  print_distributions(r);
  std::cout << "\nclasses of space in the root's cube\n";
  print_row({"", "leaves", "volume", "mass"});
  print_class("empty", r.bounds.empty, r.bounds);
  print_class("uniform", r.bounds.uniform, r.bounds);
  print_class("mixed", r.bounds.mixed, r.bounds);
  std::cout << "walks skip " << readable(100 * r.empty_share_of_box)
            << " % of the box around the density\n";
  print_lookups(r);
  if (r.cut) print_cut(*r.cut);
  print_bytes(r);
}

/// Names what is wrong and fails.
[[noreturn]] void refuse(const BoundsOptions& o, const formats::Cloud& cloud,
                         const BoundsCheck& check) {
  const Affine& to_world = cloud.grid.index_to_world;
  if (o.json) {
    Json j;
    j["file"] = o.input.string();
    j["verified"] = to_json(check, to_world);
    std::cout << to_text(j);
  } else {
    if (check.support) std::cout << describe(*check.support) << '\n';
    for (std::size_t i = 0; i < std::min(kNamed, check.wrong.size()); ++i) {
      std::cout << describe(check.wrong[i], to_world) << '\n';
    }
    if (check.wrong.size() > kNamed) {
      std::cout << "and " << readable_count(check.wrong.size() - kNamed)
                << " more; --json names all\n";
    }
  }
  std::cout.flush();
  throw Error(o.input.string() + ": the bounds do not hold: " + readable_count(check.wrong.size()) +
              " of " + readable_count(check.leaves + check.uniform) + " cubes are wrong" +
              (check.support ? ", and so is the box around them" : "") +
              ". They belong to another density or were damaged; fit the cloud again.");
}

/// Throws Error, naming a leaf, for stored micro-bounds that do not hold.
void prove_micro_bounds(const formats::Cloud& cloud) {
  const FieldWithLinks field = build_field(cloud.grid, cloud.pyramid);
  (void)arrange(*cloud.micro, field.field, field.brick_of, cloud.pyramid);
}

}  // namespace

int run_bounds(const BoundsOptions& o) {
  if (o.html) check_output(*o.html, {".html", ".htm"});
  formats::Cloud cloud = formats::load_cloud(o.input, o.grid);
  print_warnings("pvol-stats", cloud.report.warnings);
  std::optional<BoundsCheck> check;
  if (o.verify) {
    check = verify_bounds(cloud.grid, cloud.pyramid);
    if (!check->holds()) refuse(o, cloud, *check);
    if (cloud.micro) naming(o.input, [&] { prove_micro_bounds(cloud); });
  }
  BoundsReport r = measure(o, std::move(cloud));
  r.check = std::move(check);
  if (o.html) html::write_page(*o.html, bounds_page(r));
  if (o.json) {
    std::cout << to_text(to_json(r));
  } else {
    report_text(r);
  }
  return kSuccess;
}

}  // namespace pvol::cli
