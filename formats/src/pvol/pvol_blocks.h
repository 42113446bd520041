// Bricks and tiles as both chunks of density hold them.
#pragma once

#include <array>
#include <optional>
#include <string>

#include "pvol/pvol_chunks.h"

namespace pvol::formats::detail {

/// "(1, 2, 3)".
[[nodiscard]] std::string text(Vec3i v);

/// Order, alignment, disjointness and place of bricks and tiles; a sentence about what is wrong.
/// Samples are not looked at.
[[nodiscard]] std::optional<std::string> check_blocks(const VoxelGrid& grid,
                                                      const Pyramid& pyramid);

/// The bytes of tiles and of the bricks' origins, and back.
void write_blocks(const VoxelGrid& grid, ChunkWriter& chunk);
[[nodiscard]] VoxelGrid read_blocks(ChunkReader& chunk, std::uint32_t tiles, std::uint32_t bricks);

/// Bytes that these take.
[[nodiscard]] constexpr std::uint64_t block_bytes(std::uint64_t tiles, std::uint64_t bricks) {
  return sizeof(TileRecord) * tiles + sizeof(Vec3i) * bricks;
}

}  // namespace pvol::formats::detail
