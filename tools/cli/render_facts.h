// What is worth knowing of a render before it begins.
#pragma once

#include "cli/render_report.h"

namespace pvol::cli {

/// Prints sizes and thicknesses of the clouds, what was chosen and why, and the time to expect.
void print_facts(const RenderJob& job);

}  // namespace pvol::cli
