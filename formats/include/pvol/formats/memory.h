// Memory that work is going to take, compared with what there is before the work begins.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

namespace pvol::formats {

/// What the process may take at most, in bytes.
struct MemoryLimit {
  std::uint64_t most = 0;  ///< in all
  std::uint64_t left = 0;  ///< beside what it has taken
  bool set = false;        ///< by a limit of the address space; else it is what the machine has
};

/// The limit of the address space (setrlimit), else the machine's memory with its swap space;
/// nothing where neither is known.
[[nodiscard]] std::optional<MemoryLimit> memory_limit();

/// Throws Error, with figures and what to do, where `what` ("cloud.vdb: its grid 'density'") needs
/// more bytes than are left.
void require_memory(std::uint64_t bytes, const std::string& what);

}  // namespace pvol::formats
