// What this build of the tools is.
#pragma once

#include <string>

namespace pvol::cli {

/// "0.2.0 (1a2b3c4, avx512)": the version, the commit it was built from, where that is known, and
/// the kernel with the most lanes that this machine has.
[[nodiscard]] std::string version_text();

}  // namespace pvol::cli
