// CGAL's check of a shell, where pvol was built with CGAL.
#pragma once

#include <string>

#include "pvol/shell/shell.h"
#include "pvol/shell/support.h"

namespace pvol::cli {

/// Whether pvol was built with CGAL.
[[nodiscard]] bool can_check_shells();

/// Checks the shell in exact arithmetic and returns a report of some lines. Throws Error that names
/// a point of the cloud where the shell does not hold it, and where pvol was built without CGAL.
[[nodiscard]] std::string check_shell(const Shell& shell, const Support& support);

}  // namespace pvol::cli
