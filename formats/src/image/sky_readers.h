// Readers of sky pictures, each of a kind of file; see `read_sky`.
#pragma once

#include <filesystem>

#include "pvol/math/color_space.h"
#include "pvol/render/sky.h"

namespace pvol::formats::detail {

/// A picture in the colours of its file.
struct StoredSky {
  ImageSky sky;
  Primaries primaries;
};

[[nodiscard]] StoredSky read_exr_sky(const std::filesystem::path& file);
[[nodiscard]] StoredSky read_hdr_sky(const std::filesystem::path& file);

/// Whether a file has the ending, or the first two bytes, of a Radiance picture.
[[nodiscard]] bool is_hdr(const std::filesystem::path& file);

/// Largest edge and most pixels of skies.
inline constexpr int kLongestSkyEdge = 1 << 16;
inline constexpr std::size_t kMostSkyPixels = std::size_t(1) << 28;

}  // namespace pvol::formats::detail
