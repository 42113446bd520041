// The report of the verb `shells` as a document.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "cli/shell_checks.h"
#include "pvol/formats/cloud.h"
#include "pvol/measure/probe.h"
#include "pvol/shell/certificate.h"
#include "report/document.h"

namespace pvol::cli {

/// The certificate computed again from the density, and the tightness measured again.
struct ShellReplay {
  Certificate certificate;
  ShellTightness tightness;
  double margin = 0;   ///< that rays need
  double seconds = 0;  ///< of the certificate
};

struct ShellReport {
  std::string file;
  Shell shell;
  std::uint64_t bytes = 0;  ///< in the file
  std::optional<ShellReplay> replay;
  std::optional<CheckedShell> check;
  // For pages:
  formats::Cloud cloud;  ///< with the shell and its density
  std::optional<measure::ShellProbe> probe;
};

/// What only pages show is there where the shell was probed.
[[nodiscard]] report::Document shell_document(const ShellReport& r);

}  // namespace pvol::cli
