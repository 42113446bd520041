#include "stats/shell_page.h"

#include <cmath>
#include <filesystem>
#include <vector>

#include "cli/cli.h"
#include "pvol/shell/costs.h"
#include "stats/bounds_slices.h"
#include "stats/shell_report.h"

namespace pvol::cli {
namespace {

/// Half of the 95 % interval of a hit ratio from so many lines (see measure_tightness).
double hit_half_width(const ShellTightness& t) {
  constexpr double kLines = 1 << 17;
  return 1.96 * std::sqrt(t.box_hit_ratio / kLines);
}

void add_tightness(html::Page& page, const ShellTightness& t,
                   const std::optional<CheckedShell>& check) {
  html::add_heading(page, "How tight");
  const std::string hits = " ± " + readable(hit_half_width(t));
  html::Table table;
  table.caption = "Volumes and rays, as multiples of those of the cloud's occupied voxels";
  table.header = {"", "volume", "rays that meet it"};
  table.rows = {{"the shell", readable(t.volume_ratio), readable(t.hit_ratio) + hits},
                {"its box", readable(t.box_volume_ratio), readable(t.box_hit_ratio) + hits}};
  if (check) {
    table.rows.push_back({"the least ellipsoid", readable(check->ellipsoid_volume_ratio), ""});
    table.rows.push_back({"the convex hull", readable(check->hull_volume_ratio), ""});
  }
  html::add_table(page, table);
  if (!check) {
    html::add_paragraph(page, "Distances to the cloud and other hulls: with --check.");
    return;
  }
  html::Table distances;
  distances.caption = "Directed Hausdorff distances, in voxels; upper bounds";
  distances.header = {"", "distance"};
  distances.rows = {{"from the cloud's boundary to the shell", readable(check->cloud_to_shell)},
                    {"from the shell to the cloud's boundary", readable(check->shell_to_cloud)}};
  html::add_table(page, distances);
}

void add_proof(html::Page& page, const Shell& shell, const std::optional<ShellReplay>& replay,
               const std::optional<CheckedShell>& check) {
  html::add_heading(page, "That it holds");
  const Certificate& c = shell.certificate;
  html::Table table;
  table.header = {"", "slack at least", "boxes"};
  table.rows = {{"certificate in the file", readable(c.bound), readable_count(c.boxes)}};
  if (replay) {
    table.rows.push_back({"proved again from the density", readable(replay->certificate.bound),
                          readable_count(replay->certificate.boxes)});
    table.rows.push_back({"what rays need", readable(replay->margin), ""});
  }
  html::add_table(page, table);
  if (check) {
    html::add_verdict(page, "CGAL's exact arithmetic finds no point of the cloud outside",
                      html::Mood::good);
    html::add_details(page, "The check in full", check->text);
  }
}

void add_cost(html::Page& page, const measure::ShellProbe& p) {
  html::add_heading(page, "What it costs and saves");
  const ShellEstimate& e = p.estimate;
  const double rays = double(p.rays);
  const auto per_ray = [&](std::uint64_t count) { return readable(double(count) / rays); };
  html::Table table;
  table.caption = "A render of the whole cloud from the front at extinction " +
                  readable(p.extinction) + ", for each camera ray";
  table.header = {"", "without the shell", "with it"};
  table.rows = {
      {"tests of the shell", "0", per_ray(p.with_shell.shell_tests)},
      {"rays rejected", "0", per_ray(p.with_shell.shell_rejections)},
      {"segments walked", per_ray(p.without.segments_path), per_ray(p.with_shell.segments_path)},
      {"null collisions", per_ray(p.without.null_collisions),
       per_ray(p.with_shell.null_collisions)},
      {"look-ups", per_ray(p.without.lookups_path), per_ray(p.with_shell.lookups_path)}};
  html::add_table(page, table);
  html::add_paragraph(page, "Of the rays that meet the box the shell rejects " +
                                readable(100 * p.rejected.value) + " % ± " +
                                readable(100 * p.rejected.half_width) +
                                " % (95 % interval). By the cost model a test takes " +
                                readable(e.spent) + " ns and saves " + readable(e.saved) +
                                " ns of walking, for each ray that meets the box.");
  html::add_verdict(page,
                    e.pays() ? "By that estimate the shell pays for this view"
                             : "By that estimate the shell does not pay for this view, and "
                               "pvol-render leaves it out",
                    html::Mood::plain);
}

}  // namespace

html::Page shell_page(const std::string& file, const formats::Cloud& cloud, std::uint64_t bytes,
                      const measure::ShellProbe& probe, const std::optional<ShellReplay>& replay,
                      const std::optional<CheckedShell>& check) {
  const Shell& shell = *cloud.shell;
  html::Page page;
  page.title = "Shell of " + std::filesystem::path(file).filename().string();
  html::add_paragraph(page, std::string(name(shell.kind)) + " shell with " +
                                std::to_string(shell.form.perturbations.size()) +
                                " perturbations, " + readable_bytes(bytes) + ".");
  std::vector<html::Figure> figures;
  for (const BoundsSlice& s : slice_bounds(cloud.grid, cloud.pyramid, &shell)) {
    const std::string across = std::string("across ") + "xyz"[s.across];
    figures.push_back(
        {html::image(formats::encode_png(s.picture), "slice " + across, false), across});
  }
  html::add_figures(page, figures);
  html::add_paragraph(page,
                      "Orange: the outline of the shell. Grey: density; squares are cubes of "
                      "bounds, whose borders are yellow where bounds are loose.");
  add_tightness(page, shell.tightness, check);
  add_proof(page, shell, replay, check);
  add_cost(page, probe);
  return page;
}

}  // namespace pvol::cli
