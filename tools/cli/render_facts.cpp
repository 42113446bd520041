#include "cli/render_facts.h"

#include <fmt/format.h>

#include <algorithm>
#include <iostream>
#include <string>

#include "cli/cli.h"
#include "cli/render_options.h"
#include "pvol/bounds/homogenise.h"
#include "pvol/volume/facts.h"

namespace pvol::cli {
namespace {

/// "  paths guided (--guide auto): ...", for the decision of this name about a volume, or all.
void print_decision(const RenderPlan& plan, const std::string& what, const std::string& told,
                    int volume = -1) {
  for (const Decision& d : plan.decisions) {
    if (d.what == what && d.volume == volume) {
      std::cerr << "  " << what << ' ' << d.choice << told << ": " << d.reason << '\n';
    }
  }
}

void print_density(const Volume& volume, const cli::VolumeReport& report) {
  using cli::readable;
  if (report.density.precision != Precision::fp32) {
    const QuantisationError& e = report.density_error;
    std::cerr << "  density " << name(report.density.precision)
              << (e.absolute == 0 ? ", exact for this cloud\n"
                                  : ", biased: samples are off by up to " + readable(e.absolute) +
                                        ", their sum by " + readable(100 * e.mass) + " %\n");
  }
  if (const auto& h = volume.density.homogeneous) {
    std::cerr << "  homogeneous parts: " << h->nodes << " nodes, "
              << readable(100 * h->volume_share) << " % of the volume and "
              << readable(100 * h->mass_share)
              << " % of the mass; no ray's optical depth changes by more than "
              << readable(h->depth_error) << '\n';
  }
}

void print_facts(const Volume& volume, const VolumeFacts& f) {
  using cli::readable;
  std::cerr << kRenderTool << ": " << volume.name << ": ";
  if (volume.density.world_box.empty()) {
    std::cerr << (volume.fire ? "a fire without smoke\n" : "the density is 0 everywhere\n");
    return;
  }
  if (count_places(volume) > 1) {
    std::cerr << cli::readable_count(count_places(volume)) << " instances, the first of ";
  }
  const Box& box = volume.density.world_box;
  const Vec3d size = box.extent();
  const auto corner = [](Vec3d p) {
    return fmt::format("({}, {}, {})", readable(p.x), readable(p.y), readable(p.z));
  };
  std::cerr << readable(size.x) << " x " << readable(size.y) << " x " << readable(size.z)
            << " world units, from " << corner(box.lo) << " to " << corner(box.hi) << '\n'
            << "  largest extinction " << readable(f.largest_extinction)
            << " per world unit: shortest free path " << readable(f.shortest_free_path)
            << " world units\n"
            << "  mean optical thickness along the axes " << readable(f.mean_optical_thickness[0])
            << ", " << readable(f.mean_optical_thickness[1]) << ", "
            << readable(f.mean_optical_thickness[2]) << "; octree depth " << f.depth
            << "; micro-bounds: " << cli::micro_bounds_text(volume) << '\n';
}

}  // namespace

void print_facts(const RenderJob& job) {
  const RenderOptions& o = job.file.scene.options;
  const auto told = [](const char* flag, const char* value) {
    return fmt::format(" ({} {})", flag, value);
  };
  for (std::size_t i = 0; i < job.volumes.size(); ++i) {
    print_facts(job.volumes[i], job.facts[i]);
    const bool is_empty = job.volumes[i].density.world_box.empty();
    if (!is_empty) print_density(job.volumes[i], job.reports[i]);
    print_decision(job.plan, "motion", "", int(i));
    if (is_empty) continue;
    print_decision(job.plan, "shell", told("--shells", name(o.shells)), int(i));
  }
  if (std::all_of(job.volumes.begin(), job.volumes.end(),
                  [](const Volume& v) { return v.density.octree.empty(); })) {
    return;
  }
  print_decision(job.plan, "camera", "");
  print_decision(job.plan, "paths", told("--guide", name(o.guide)));
  print_decision(job.plan, "emission", told("--line-emission", name(o.line_emission)));
  print_decision(job.plan, "lamps", told("--line-lamps", name(o.line_lamps)));
  print_decision(job.plan, "kernel", "");
  if (job.chose_transmittance) print_decision(job.plan, "shadow rays", "");
  const Forecast& f = job.plan.forecast;
  std::cerr << "  roughly " << cli::readable(f.collisions / f.samples)
            << " collisions per sample\n";
  if (is_adaptive(o)) {
    std::cerr << "  adaptive samples until";
    if (o.noise)
      std::cerr << " the noise of pixels is about " << cli::readable(100 * *o.noise)
                << " % of their own brightness";
    if (o.noise && o.time) std::cerr << " or";
    if (o.time) std::cerr << " the time limit, " << cli::readable_seconds(*o.time);
    std::cerr << '\n';
  }
}

}  // namespace pvol::cli
