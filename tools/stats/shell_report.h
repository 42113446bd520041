// What the tools say about a shell.
#pragma once

#include <array>
#include <cstdint>
#include <iosfwd>
#include <string>

#include "cli/json.h"
#include "pvol/shell/shell.h"

namespace pvol::cli {

[[nodiscard]] inline const char* name(ShellKind kind) {
  return kind == ShellKind::soft ? "soft" : "hard";
}

/// Kind and size, tightness, certificate, expected cost: a line each.
[[nodiscard]] std::array<std::string, 4> shell_lines(const Shell& shell, std::uint64_t bytes);

/// The same lines, each with `indent` before it.
void print_shell(std::ostream& out, const Shell& shell, std::uint64_t bytes,
                 const std::string& indent);

[[nodiscard]] Json to_json(const Shell& shell, std::uint64_t bytes);

}  // namespace pvol::cli
