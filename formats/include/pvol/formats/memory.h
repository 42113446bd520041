// Memory that work is going to take, compared with what there is before the work begins.
#pragma once

#include <cstdint>
#include <string>

namespace pvol::formats {

/// Throws Error, with figures and what to do, where `what` ("cloud.vdb: grid 'density'") needs more
/// bytes than are left: of the limit of the address space (setrlimit), or without one of the
/// machine's memory with its swap space.
void require_memory(std::uint64_t bytes, const std::string& what);

}  // namespace pvol::formats
