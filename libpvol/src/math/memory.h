// Memory that work is going to take, compared with what there is before it is taken.
#pragma once

#include <cstdint>
#include <string>

#include "pvol/error.h"

namespace pvol::detail {

/// Input that needs more memory than there is.
struct NoMemory : Error {
  using Error::Error;
};

/// Bytes that the process can still take: of the limit of its address space (setrlimit), or without
/// one of the machine's memory with its swap space. The largest number where neither is known.
[[nodiscard]] std::uint64_t free_memory();

/// Throws NoMemory: `what` ("the density") needs at least `bytes`, and only `free` are there.
[[noreturn]] void refuse_memory(const std::string& what, double bytes, std::uint64_t free);

}  // namespace pvol::detail
