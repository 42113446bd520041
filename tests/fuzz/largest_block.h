// The largest block of memory that operator new was asked for: what a file announces shows there,
// even where it is never touched, or refused by the system.
#pragma once

#include <cstddef>

namespace pvol::fuzz {

/// Since the last call, in bytes.
[[nodiscard]] std::size_t take_largest_block();

}  // namespace pvol::fuzz
