// Readers of sky pictures, each of a kind of file; see `read_sky`.
#pragma once

#include <filesystem>

#include "pvol/render/sky.h"

namespace pvol::formats::detail {

[[nodiscard]] ImageSky read_exr_sky(const std::filesystem::path& file);
[[nodiscard]] ImageSky read_hdr_sky(const std::filesystem::path& file);

/// Whether a file has the ending, or the first two bytes, of a Radiance picture.
[[nodiscard]] bool is_hdr(const std::filesystem::path& file);

/// Largest edge and most pixels of skies.
inline constexpr int kLongestSkyEdge = 1 << 16;
inline constexpr std::size_t kMostSkyPixels = std::size_t(1) << 28;

}  // namespace pvol::formats::detail
