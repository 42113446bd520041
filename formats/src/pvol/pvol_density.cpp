// The DENS chunk: samples in bricks and tiles.
#include <fmt/format.h>

#include <algorithm>

#include "pvol/density/sample_count.h"
#include "pvol/error.h"
#include "pvol/pvol_blocks.h"

namespace pvol::formats::detail {
namespace {

struct Samples {
  std::span<const float> values;
  std::shared_ptr<const void> owner;
};

/// The next samples of a chunk: where they lie, if that can be.
Samples take_samples(ChunkReader& chunk, std::size_t count) {
  if (auto in_place = chunk.take_in_place(count * sizeof(float))) {
    const std::byte* const at = in_place->bytes.data();
    // Chunks begin at multiples of 64, and all that is before the samples is words.
    return {{reinterpret_cast<const float*>(at), count}, std::move(in_place->owner)};
  }
  const auto values = std::make_shared_for_overwrite<float[]>(count);
  chunk.read(std::as_writable_bytes(std::span(values.get(), count)));
  return {{values.get(), count}, values};
}

}  // namespace

void encode_density(const VoxelGrid& grid, const Pyramid& pyramid, ChunkWriter& chunk,
                    const std::string& place) {
  const VoxelGrid g = occupied(grid);
  if (const auto wrong = check_blocks(g, pyramid)) {
    throw Error(place + ": the density to write is wrong: " + *wrong + ".");
  }
  chunk.put(DensityHeader{std::uint32_t(g.tiles.size()), std::uint32_t(g.bricks.size())});
  write_blocks(g, chunk);
  for (const Brick& b : g.bricks) {
    std::array<float, kBrickSamples> values;
    for (std::size_t i = 0; i < values.size(); ++i) {
      if (!is_density(b.values[i])) {
        throw Error(place + ": the density to write is wrong: brick at " + text(b.origin) +
                    ": a sample is negative or not finite.");
      }
      values[i] = b.values[i] + 0.0f;  // -0 becomes 0, so that equal fields give equal bytes
    }
    chunk.put(values);
  }
}

CountedGrid decode_density(ChunkReader& chunk, const Pyramid& pyramid) {
  const auto header = chunk.get<DensityHeader>();
  const std::uint64_t expected = sizeof(DensityHeader) + block_bytes(header.tiles, header.bricks) +
                                 kBrickSamples * sizeof(float) * std::uint64_t(header.bricks);
  if (chunk.raw_bytes() != expected) {
    refuse(chunk.place(), fmt::format("{} raw bytes; its counts of {} tiles and {} bricks take {}",
                                      chunk.raw_bytes(), header.tiles, header.bricks, expected));
  }
  VoxelGrid grid = read_blocks(chunk, header.tiles, header.bricks);
  if (const auto bad = check_blocks(grid, pyramid)) refuse(chunk.place(), *bad);

  const auto [samples, owner] = take_samples(chunk, std::size_t(header.bricks) * kBrickSamples);
  for (std::size_t b = 0; b < grid.bricks.size(); ++b) {
    grid.bricks[b].values = samples.data() + b * kBrickSamples;
  }
  grid.owner = owner;
  const SampleCount count = count_samples(grid);
  if (const auto wrong = count.wrong_brick) {
    refuse(chunk.place(), fmt::format("brick {}: a sample is negative or not finite", *wrong));
  }
  return {std::move(grid), count};
}

}  // namespace pvol::formats::detail
