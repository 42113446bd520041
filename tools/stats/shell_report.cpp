#include "stats/shell_report.h"

#include <fmt/format.h>

#include <ostream>

#include "cli/cli.h"
#include "pvol/shell/costs.h"

namespace pvol::cli {
namespace {

/// "4 voxels", "1/16 voxel".
std::string edge(int log2) {
  const std::string size = readable_count(std::uint64_t(1) << (log2 < 0 ? -log2 : log2));
  return log2 < 0 ? "1/" + size + " voxel" : size + (log2 == 0 ? " voxel" : " voxels");
}

}  // namespace

std::array<std::string, 4> shell_lines(const Shell& shell, std::uint64_t bytes) {
  const ShellTightness& t = shell.tightness;
  const Certificate& c = shell.certificate;
  return {fmt::format("{}, {} perturbations, {}", name(shell.kind), shell.form.perturbations.size(),
                      readable_bytes(bytes)),
          fmt::format("volume {:.4g} times the cloud's (its box: {:.4g}); rays that enter {:.4g} "
                      "times those that hit the cloud (its box: {:.4g})",
                      t.volume_ratio, t.box_volume_ratio, t.hit_ratio, t.box_hit_ratio),
          fmt::format("certified with {} boxes down to {}: slack at least {:.4g}",
                      readable_count(c.boxes), edge(c.depth), c.bound),
          fmt::format("about {:.4g} ns for a ray in the box", test_cost(shell))};
}

void print_shell(std::ostream& out, const Shell& shell, std::uint64_t bytes,
                 const std::string& indent) {
  for (const std::string& line : shell_lines(shell, bytes)) out << indent << line << '\n';
}

Json to_json(const Shell& shell, std::uint64_t bytes) {
  const ShellTightness& t = shell.tightness;
  const Certificate& c = shell.certificate;
  return {{"kind", name(shell.kind)},
          {"perturbations", shell.form.perturbations.size()},
          {"bytes", bytes},
          {"volume_ratio", t.volume_ratio},
          {"hit_ratio", t.hit_ratio},
          {"box_volume_ratio", t.box_volume_ratio},
          {"box_hit_ratio", t.box_hit_ratio},
          {"certificate", {{"bound", c.bound}, {"boxes", c.boxes}, {"depth", c.depth}}},
          {"expected_nanoseconds", test_cost(shell)}};
}

}  // namespace pvol::cli
