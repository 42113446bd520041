// What OpenEXR's zip does.
#pragma once

#include <cstdint>

namespace pvol::formats::detail {

/// Rows that it compresses together.
inline constexpr int kZipRows = 16;

/// No bytes are packed tighter, by zlib.
inline constexpr std::uint64_t kBestZipRatio = 1032;

}  // namespace pvol::formats::detail
