#include "stats/shell_report.h"

#include <cmath>
#include <ostream>

#include "cli/cli.h"
#include "pvol/shell/costs.h"

namespace pvol::cli {
namespace {

/// "4 voxels", "1/16 voxel".
std::string edge(int log2) {
  if (log2 < 0) return "1/" + readable_count(std::uint64_t(1) << -log2) + " voxel";
  return readable_count(std::uint64_t(1) << log2) + (log2 == 0 ? " voxel" : " voxels");
}

}  // namespace

void print_shell(std::ostream& out, const Shell& shell, std::uint64_t bytes,
                 const std::string& indent) {
  const ShellTightness& t = shell.tightness;
  const Certificate& c = shell.certificate;
  out << indent << name(shell.kind) << ", " << shell.form.perturbations.size() << " perturbations, "
      << readable_bytes(bytes) << '\n'
      << indent << "volume " << readable(t.volume_ratio)
      << " times the cloud's (its box: " << readable(t.box_volume_ratio) << "); rays that enter "
      << readable(t.hit_ratio)
      << " times those that meet the cloud (its box: " << readable(t.box_hit_ratio) << ")\n"
      << indent << "certified with " << readable_count(c.boxes) << " boxes down to "
      << edge(c.depth) << ": slack at least " << readable(c.bound) << '\n'
      << indent << "about " << readable(test_cost(shell)) << " ns for a ray in the box\n";
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
