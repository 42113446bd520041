// The report of the verb `shells` as a page.
#pragma once

#include <optional>
#include <string>

#include "cli/shell_checks.h"
#include "pvol/formats/cloud.h"
#include "pvol/measure/probe.h"
#include "pvol/shell/certificate.h"
#include "report/html.h"

namespace pvol::cli {

/// The certificate computed again from the density, and the tightness measured again.
struct ShellReplay {
  Certificate certificate;
  ShellTightness tightness;
  double margin = 0;   ///< that rays need
  double seconds = 0;  ///< of the certificate
};

/// `cloud` has a shell and density.
[[nodiscard]] html::Page shell_page(const std::string& file, const formats::Cloud& cloud,
                                    std::uint64_t bytes, const measure::ShellProbe& probe,
                                    const std::optional<ShellReplay>& replay,
                                    const std::optional<CheckedShell>& check);

}  // namespace pvol::cli
