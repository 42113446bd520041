// What the tools say about a shell.
#pragma once

#include <iosfwd>

#include "cli/json.h"
#include "pvol/shell/shell.h"

namespace pvol::cli {

[[nodiscard]] inline const char* name(ShellKind kind) {
  return kind == ShellKind::soft ? "soft" : "hard";
}

/// Kind, size, tightness, certificate and expected cost, four lines that begin with `indent`.
void print_shell(std::ostream& out, const Shell& shell, std::uint64_t bytes,
                 const std::string& indent);

[[nodiscard]] Json to_json(const Shell& shell, std::uint64_t bytes);

}  // namespace pvol::cli
