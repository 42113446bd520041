#include "stats/shell_document.h"

#include <fmt/format.h>

#include <filesystem>

#include "cli/cli.h"
#include "pvol/shell/costs.h"
#include "pvol/shell/tightness.h"
#include "stats/bounds_slices.h"
#include "stats/shell_report.h"

namespace pvol::cli {
namespace {

using report::Content;
using report::Heading;
using report::Shown;
using report::Table;
using report::Text;

/// A hit ratio with its 95 % interval, "1.16 ± 0.0035".
std::string hits_text(double ratio, const ShellTightness& t) {
  const std::optional<double> error = standard_error_of_hits(ratio, t.box_hit_ratio);
  if (!error) return fmt::format("about {:.2g}: few lines meet the cloud", ratio);
  return fmt::format("{:.4g} ± {:.2g}", ratio, 1.96 * *error);
}

std::vector<Content> tightness_part(const ShellReport& r) {
  const ShellTightness& t = r.shell.tightness;
  Table hulls{.caption = "Volumes and rays, as multiples of those of the cloud's occupied voxels",
              .header = {"", "volume", "rays that hit it"},
              .rows = {{"the shell", readable(t.volume_ratio), hits_text(t.hit_ratio, t)},
                       {"its box", readable(t.box_volume_ratio), hits_text(t.box_hit_ratio, t)}}};
  if (!r.check) {
    return {Heading{"How tight"}, hulls,
            Text{"Distances to the cloud and other hulls: with --check."}};
  }
  hulls.rows.push_back({"the least ellipsoid", readable(r.check->ellipsoid_volume_ratio), ""});
  hulls.rows.push_back({"the convex hull", readable(r.check->hull_volume_ratio), ""});
  const Table distances{
      .caption = "Directed Hausdorff distances, in voxels; upper bounds",
      .header = {"", "distance"},
      .rows = {{"from the cloud's boundary to the shell", readable(r.check->cloud_to_shell)},
               {"from the shell to the cloud's boundary", readable(r.check->shell_to_cloud)}}};
  return {Heading{"How tight"}, hulls, distances};
}

std::vector<Content> proof_part(const ShellReport& r) {
  const Certificate& c = r.shell.certificate;
  Table table{.header = {"", "slack at least", "boxes"},
              .rows = {{"certificate in the file", readable(c.bound), readable_count(c.boxes)}}};
  if (r.replay) {
    const Certificate& again = r.replay->certificate;
    table.rows.push_back(
        {"proved again from the density", readable(again.bound), readable_count(again.boxes)});
    table.rows.push_back({"what rays need", readable(r.replay->margin), ""});
  }
  std::vector<Content> part{Heading{"Proof"}, table};
  if (r.check) {
    part.push_back(report::Verdict{"CGAL's exact arithmetic finds no point of the cloud outside",
                                   report::Mood::good});
  }
  return part;
}

std::vector<Content> cost_part(const measure::ShellProbe& p) {
  const ShellEstimate& e = p.estimate;
  const auto per_ray = [&](std::uint64_t count) {
    return readable(double(count) / double(p.rays));
  };
  const Table table{
      .caption = fmt::format("A render of the whole cloud from the front at extinction {:.4g}, for "
                             "each camera ray",
                             p.extinction),
      .header = {"", "without the shell", "with it"},
      .rows = {{"tests of the shell", "0", per_ray(p.with_shell.shell_tests)},
               {"rays rejected", "0", per_ray(p.with_shell.shell_rejections)},
               {"segments walked", per_ray(p.without.path.segments),
                per_ray(p.with_shell.path.segments)},
               {"null collisions", per_ray(p.without.path.null_collisions),
                per_ray(p.with_shell.path.null_collisions)},
               {"look-ups", per_ray(p.without.path.lookups), per_ray(p.with_shell.path.lookups)}}};
  return {Heading{"Cost and savings"}, table,
          Text{fmt::format("Of the rays that hit the box, the shell rejects {:.4g} % ± {:.4g} % "
                           "(95 % interval). By the cost model, a test takes {:.4g} ns and saves "
                           "{:.4g} ns of walking for each ray that hits the box.",
                           100 * p.rejected.value, 100 * p.rejected.half_width, e.spent, e.saved)},
          report::Verdict{e.pays() ? "By this estimate, the shell saves time for this view"
                                   : "By this estimate, the shell saves no time for this view, and "
                                     "pvol-render leaves it out"}};
}

/// What was proved again, for terminals.
std::vector<Content> replay_lines(const ShellReplay& r) {
  return {
      Text{fmt::format("verified: the proof was found again with {} boxes in {}, slack at least "
                       "{:.4g} where rays need {:.4g}",
                       readable_count(r.certificate.boxes), readable_seconds(r.seconds),
                       r.certificate.bound, r.margin)},
      Text{fmt::format("measured again: volume {:.4g}, rays {:.4g}", r.tightness.volume_ratio,
                       r.tightness.hit_ratio)}};
}

}  // namespace

report::Document shell_document(const ShellReport& r) {
  const auto lines = shell_lines(r.shell, r.bytes);
  report::Document d{.title = "Shell of " + std::filesystem::path(r.file).filename().string(),
                     .subject = r.file,
                     .lead = lines[0]};
  for (std::size_t i = 1; i < lines.size(); ++i) add(d, Text{lines[i]}, Shown::on_terminal);
  if (r.replay) add(d, replay_lines(*r.replay), Shown::on_terminal);
  if (r.probe) {
    add(d, report::Figures{slice_figures(r.cloud, false)}, Shown::on_page);
    add(d,
        Text{"Orange: the outline of the shell. Grey: density; squares are cubes of bounds, whose "
             "borders are yellow where bounds are loose."},
        Shown::on_page);
    add(d, tightness_part(r), Shown::on_page);
    add(d, proof_part(r), Shown::on_page);
  }
  if (r.check) add(d, report::Details{"The check in full", r.check->text});
  if (r.probe) add(d, cost_part(*r.probe), Shown::on_page);
  return d;
}

}  // namespace pvol::cli
