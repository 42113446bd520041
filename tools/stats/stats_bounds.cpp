// The verb `bounds`: how tight the bounds of a cloud are, and whether they hold.
#include <fmt/format.h>

#include <iostream>

#include "cli/load_scene.h"
#include "pvol/error.h"
#include "pvol/render/scene_volume.h"
#include "pvol/volume/facts.h"
#include "pvol/volume/make_volume.h"
#include "report/html.h"
#include "report/terminal.h"
#include "stats/bounds_report.h"
#include "stats/stats.h"

namespace pvol::cli {
namespace {

constexpr std::size_t kNamed = 20;  // wrong bounds in the text; JSON has all

void measure_cut(BoundsReport& r, const PyramidContent& content, const BoundsOptions& o) {
  const double extinction = r.probe ? r.probe->extinction : *o.extinction;
  const Medium medium{.extinction = extinction};
  const Volume v = naming(o.input, [&] {
    return make_volume(r.cloud.grid(), r.cloud.pyramid, medium, VolumeOptions{});
  });
  r.cut = {extinction, describe(v, pvol::describe(r.cloud.grid(), extinction, {})),
           pvol::measure_cut(r.cloud.pyramid, content, v.density.octree, extinction)};
}

BoundsReport measure(const BoundsOptions& o, formats::Cloud cloud) {
  BoundsReport r;
  r.file = o.input.string();
  r.cloud = std::move(cloud);
  const PyramidContent content = measure_content(r.cloud.grid(), r.cloud.pyramid);
  r.bounds = measure_bounds(r.cloud.pyramid, content);
  r.distributions = measure_distributions(r.cloud.pyramid, content);
  r.empty_share_of_box = empty_share_of_box(r.cloud.pyramid);
  if (formats::ending(o.input) == ".pvol") r.bytes = formats::measure_pvol(o.input);
  if (r.cloud.pyramid.empty()) return r;
  if (o.measure || o.html) {
    measure::ProbeOptions options;
    // As pvol-render would, so that the page is about the picture.
    options.extinction = o.extinction ? *o.extinction : choose_extinction(r.cloud, {});
    r.probe = naming(o.input, [&] { return probe(r.cloud.grid(), r.cloud.pyramid, options); });
  }
  if (o.extinction || r.probe) measure_cut(r, content, o);
  return r;
}

/// Names what is wrong and fails.
[[noreturn]] void refuse(const BoundsOptions& o, const formats::Cloud& cloud,
                         const BoundsCheck& check) {
  const Affine& to_world = cloud.grid().index_to_world;
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
  throw Error(fmt::format(
      "{}: the bounds do not hold: {} of {} cubes are wrong{}. They belong to another density or "
      "were damaged; fit the cloud again.",
      o.input.string(), readable_count(check.wrong.size()),
      readable_count(check.leaves + check.uniform),
      check.support ? ", and so is the box around them" : ""));
}

/// Throws Error, naming a leaf, for stored micro-bounds that do not hold.
void prove_micro_bounds(const formats::Cloud& cloud) {
  const FieldWithLinks field = build_field(cloud.grid(), cloud.pyramid);
  (void)arrange(*cloud.micro, field.field, field.brick_of, cloud.pyramid);
}

/// The further grids of a .pvol file, whose bounds are verified where that is asked for.
std::vector<BoundsReport::Field> measure_fields(const BoundsOptions& o) {
  std::vector<BoundsReport::Field> fields;
  if (formats::ending(o.input) != ".pvol" || !o.grid.grid.empty()) return fields;
  const std::vector<formats::PvolGridName> grids = formats::list_pvol(o.input);
  for (std::size_t i = 1; i < grids.size(); ++i) {
    const formats::Cloud cloud =
        load_cloud({"pvol-stats"}, o.input, {grids[i].name, o.grid.strict});
    const Pyramid& p = cloud.pyramid;
    BoundsReport::Field& f = fields.emplace_back();
    f.name = grids[i].name;
    f.verified = o.verify;
    if (o.verify) {
      const BoundsCheck check = verify_bounds(cloud.grid(), p);
      if (!check.holds()) refuse(o, cloud, check);
    }
    if (p.empty()) continue;
    f.largest = p.scale;
    f.leaves = p.levels[0].size();
    f.tightness = measure_bounds(p, measure_content(cloud.grid(), p)).depths.back().tightness;
  }
  return fields;
}

}  // namespace

int run_bounds(const BoundsOptions& o) {
  if (o.html) check_output(*o.html, {".html", ".htm"});
  formats::Cloud cloud = load_cloud({"pvol-stats"}, o.input, o.grid);
  std::optional<BoundsCheck> check;
  if (o.verify) {
    check = verify_bounds(cloud.grid(), cloud.pyramid);
    if (!check->holds()) refuse(o, cloud, *check);
    if (cloud.micro) naming(o.input, [&] { prove_micro_bounds(cloud); });
  }
  BoundsReport r = measure(o, std::move(cloud));
  r.check = std::move(check);
  r.fields = measure_fields(o);
  const report::Document document = bounds_document(r, o.html.has_value());
  if (o.html) html::write_page(*o.html, document);
  std::cout << (o.json ? to_text(to_json(r)) : report::to_terminal(document));
  return kSuccess;
}

}  // namespace pvol::cli
