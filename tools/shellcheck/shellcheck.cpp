#include "shellcheck.h"

#include <cstdarg>
#include <cstdio>

#include "exact_signs.h"
#include "mesh_distance.h"
#include "pvol/error.h"
#include "pvol/shell/mesh.h"

namespace pvol {
namespace {

[[gnu::format(printf, 1, 2)]] std::string format(const char* pattern, ...) {
  char text[256];
  std::va_list values;
  va_start(values, pattern);
  std::vsnprintf(text, sizeof text, pattern, values);
  va_end(values);
  return text;
}

}  // namespace

ShellCheck check_shell(const Shell& shell, const Support& support,
                       const ShellCheckOptions& options) {
  if (support.empty())
    throw Error("the cloud has no cells against which the shell could be checked");
  if (options.points == 0 || options.mesh_points == 0) {
    throw Error("the check of a shell needs at least one point");
  }
  if (options.mesh_resolution < 8 || options.mesh_resolution > 512) {
    throw Error("found a resolution of " + std::to_string(options.mesh_resolution) +
                " steps, expected 8 to 512");
  }
  ShellCheck check;
  const TriangleMesh boundary = make_mesh(support);
  detail::check_signs(shell, support, boundary, options, check);
  detail::check_meshes(shell, support, boundary, options, check);
  detail::compare_with_baselines(support, boundary, check);
  return check;
}

std::string describe(const ShellCheck& check) {
  std::string text;
  if (check.witness) {
    const ShellWitness& w = *check.witness;
    text += format("NOT contained: %s cuts off index point (%.17g, %.17g, %.17g), slack %.3g\n",
                   w.what.c_str(), w.index.x, w.index.y, w.index.z, w.value);
  } else {
    text += "contained: no occupied point found outside\n";
  }
  text += format("  exact signs at %llu points, %llu of them in rationals\n",
                 static_cast<unsigned long long>(check.points),
                 static_cast<unsigned long long>(check.rational));
  if (check.cells > 0) {
    text += format("  exact greatest value of each dent over the %llu tightest cells\n",
                   static_cast<unsigned long long>(check.cells));
  }
  text += format("  shell's mesh (step %.3g cells) %s the support's boundary\n", check.mesh_step,
                 check.mesh_contained ? "holds" : "DOES NOT hold");
  text += format(
      "distances: support to shell %.2f cells (at most %.2f too large), "
      "shell to support %.2f (%.2f)\n",
      check.support_to_shell, check.support_to_shell_excess, check.shell_to_support,
      check.shell_to_support_excess);
  text += format("volume over the support's: shell %.3f, convex hull %.3f, least ellipsoid %.3f\n",
                 check.shell_volume_ratio, check.hull_volume_ratio, check.ellipsoid_volume_ratio);
  return text;
}

}  // namespace pvol
