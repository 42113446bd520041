#include "cli/shell_checks.h"

#ifdef PVOL_WITH_CGAL
#include "shellcheck.h"
#endif

#include "pvol/error.h"

namespace pvol::cli {

#ifdef PVOL_WITH_CGAL

bool can_check_shells() { return true; }

CheckedShell check_shell(const Shell& shell, const Support& support) {
  const ShellCheck check = pvol::check_shell(shell, support);
  if (!check.contained) {
    throw Error("CGAL found that the shell does not contain the cloud:\n" + describe(check));
  }
  return {describe(check),          check.support_to_shell,       check.shell_to_support,
          check.shell_volume_ratio, check.ellipsoid_volume_ratio, check.hull_volume_ratio};
}

#else

bool can_check_shells() { return false; }

CheckedShell check_shell(const Shell&, const Support&) {
  throw Error(
      "this pvol was built without CGAL, which --check needs; configure it with "
      "-DPVOL_WITH_CGAL=ON, or use the certificate (pvol-stats shells --verify)");
}

#endif

}  // namespace pvol::cli
