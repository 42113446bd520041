// Exact signs of a shell's slack at points of its support.
#pragma once

#include "pvol/shell/mesh.h"
#include "shellcheck.h"

namespace pvol::detail {

/// Fills in what exact signs tell. `boundary` is the mesh of the support.
void check_signs(const Shell& shell, const Support& support, const TriangleMesh& boundary,
                 const ShellCheckOptions& options, ShellCheck& check);

}  // namespace pvol::detail
