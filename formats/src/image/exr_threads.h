// Sharing the work on EXR files among threads.
#pragma once

#include <cstddef>

namespace pvol::formats::detail {

/// How many of a picture's rows, of so many bytes each in memory, to read or write by one call:
/// OpenEXR's threads share the blocks of a call. Some for each thread, as far as they fit into
/// 32 MB.
[[nodiscard]] int rows_at_once(int height, std::size_t row_bytes);

}  // namespace pvol::formats::detail
