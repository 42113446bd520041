// The DENQ chunk: samples as codes in bricks, and tiles.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numeric>

#include "pvol/error.h"
#include "pvol/pvol_blocks.h"

namespace pvol::formats::detail {
namespace {

constexpr int kLeastExponent = -164, kLargestExponent = 112;  // that float samples lead to
constexpr int kInfiniteHalf = 0x7c00;
constexpr std::uint8_t kZeroBit = 0x80;

/// A row of widths is filled up to whole words.
std::uint64_t width_bytes(std::uint64_t bricks) { return (bricks + 3) / 4 * 4; }

/// Bytes of everything but the codes.
std::uint64_t head_bytes(const QuantisedHeader& h, bool half) {
  const std::uint64_t scales = half ? 0 : 2 * sizeof(float) * h.bricks + width_bytes(h.bricks);
  return sizeof h + block_bytes(h.tiles, h.bricks) + scales;
}

/// Tiles and bricks as the checks of blocks want them.
VoxelGrid blocks_of(const QuantisedGrid& grid) {
  VoxelGrid g;
  g.tiles = grid.tiles;
  for (const Vec3i origin : grid.origins) g.bricks.push_back({origin, nullptr});
  return g;
}

bool is_width(int bits) { return bits == 1 || bits == 2 || bits == 4 || bits == 8 || bits == 16; }

std::optional<std::string> check_scale(const QuantisedGrid::Scale& s, Precision precision) {
  if (!is_width(s.bits) || (precision == Precision::fp8 && s.bits != 8)) {
    return fmt::format("codes of {} bits", s.bits);
  }
  if (!(s.lo > 0 && s.lo <= s.hi && std::isfinite(s.hi))) {
    return fmt::format("its samples reach from {:f} to {:f}; expected positive numbers in order",
                       s.lo, s.hi);
  }
  if (s.bits == 1 && s.zero && s.lo != s.hi) return "one code for two values";
  return std::nullopt;
}

/// A sentence about the first thing that is wrong with scales, or with halves.
std::optional<std::string> check_codes(const QuantisedGrid& q) {
  const auto brick = [](std::size_t i) { return fmt::format("brick {}: ", i); };
  for (std::size_t i = 0; i < q.scales.size(); ++i) {
    if (const auto wrong = check_scale(q.scales[i], q.how.precision)) return brick(i) + *wrong;
  }
  if (q.how.precision != Precision::fp16) {
    if (q.exponent != 0) return "an exponent, which only fp16 has";
    return std::nullopt;
  }
  if (q.exponent < kLeastExponent || q.exponent > kLargestExponent) {
    return fmt::format("an exponent of {}; expected -164 to 112", q.exponent);
  }
  for (std::size_t i = 0; i + 1 < q.codes.size(); i += 2) {
    if ((q.codes[i] | q.codes[i + 1] << 8) >= kInfiniteHalf) {
      return brick(i / code_bytes(16)) + "a sample is negative or not finite";
    }
  }
  return std::nullopt;
}

std::uint64_t count_code_bytes(const QuantisedGrid& q) {
  if (q.how.precision == Precision::fp16) return code_bytes(16) * q.origins.size();
  return std::accumulate(q.scales.begin(), q.scales.end(), std::uint64_t{0},
                         [](std::uint64_t sum, const auto& s) { return sum + code_bytes(s.bits); });
}

/// Widths, and whether code 0 is 0.
std::vector<std::uint8_t> encode_widths(const std::vector<QuantisedGrid::Scale>& scales) {
  std::vector<std::uint8_t> widths(width_bytes(scales.size()));
  for (std::size_t i = 0; i < scales.size(); ++i) {
    widths[i] = std::uint8_t(scales[i].bits | (scales[i].zero ? kZeroBit : 0));
  }
  return widths;
}

void read_scales(ChunkReader& chunk, std::size_t bricks, QuantisedGrid& q) {
  q.scales.resize(bricks);
  std::vector<float> ends(bricks);
  chunk.read(ends);
  for (std::size_t i = 0; i < bricks; ++i) q.scales[i].lo = ends[i];
  chunk.read(ends);
  for (std::size_t i = 0; i < bricks; ++i) q.scales[i].hi = ends[i];
  std::vector<std::uint8_t> widths(width_bytes(bricks));
  chunk.read(widths);
  for (std::size_t i = 0; i < bricks; ++i) {
    q.scales[i].bits = std::uint8_t(widths[i] & ~kZeroBit);
    q.scales[i].zero = (widths[i] & kZeroBit) != 0;
  }
  if (std::any_of(widths.begin() + std::ptrdiff_t(bricks), widths.end(),
                  [](std::uint8_t w) { return w != 0; })) {
    refuse(chunk.place(), "the widths are not padded with zeros");
  }
}

}  // namespace

void encode_quantised(const QuantisedGrid& q, const Pyramid& pyramid, ChunkWriter& chunk,
                      const std::string& place) {
  const VoxelGrid blocks = blocks_of(q);
  const bool half = q.how.precision == Precision::fp16;
  auto wrong = check_blocks(blocks, pyramid);
  if (!wrong) wrong = check_codes(q);
  if (!wrong &&
      (q.scales.size() != (half ? 0 : q.origins.size()) || q.codes.size() != count_code_bytes(q))) {
    wrong = "bricks, scales and codes do not agree in number";
  }
  if (wrong) throw Error(place + ": the density to write is wrong: " + *wrong + ".");
  chunk.put(QuantisedHeader{std::uint32_t(q.how.precision), half ? q.exponent : 0,
                            std::uint32_t(q.tiles.size()), std::uint32_t(q.origins.size())});
  write_blocks(blocks, chunk);
  if (!half) {
    for (const auto& s : q.scales) chunk.put(s.lo);
    for (const auto& s : q.scales) chunk.put(s.hi);
    const std::vector<std::uint8_t> widths = encode_widths(q.scales);
    chunk.write(std::as_bytes(std::span(widths)));
  }
  chunk.write(std::as_bytes(std::span(q.codes)));
}

CountedGrid decode_quantised(ChunkReader& chunk, const Pyramid& pyramid,
                             const Metadata& metadata) {
  const auto h = chunk.get<QuantisedHeader>();
  if (h.precision == 0 || h.precision != std::uint32_t(metadata.quantisation.precision)) {
    refuse(chunk.place(),
           fmt::format("precision {}; expected 1, 2 or 3 (fp16, fp8, fpn), as in the metadata",
                       h.precision));
  }
  QuantisedGrid q;
  q.how = metadata.quantisation;
  q.exponent = h.exponent;
  const bool half = q.how.precision == Precision::fp16;
  const auto require_size = [&](std::uint64_t least, std::uint64_t most) {
    if (chunk.raw_bytes() >= least && chunk.raw_bytes() <= most) return;
    refuse(
        chunk.place(),
        fmt::format("{} raw bytes; its counts of {} tiles and {} bricks take {}{}",
                    chunk.raw_bytes(), h.tiles, h.bricks, least, (most > least ? " or more" : "")));
  };
  const std::uint64_t head = head_bytes(h, half), bricks = h.bricks;
  require_size(head + code_bytes(half ? 16 : 1) * bricks, head + code_bytes(16) * bricks);
  const VoxelGrid blocks = read_blocks(chunk, h.tiles, h.bricks);
  if (const auto bad = check_blocks(blocks, pyramid)) refuse(chunk.place(), *bad);
  q.tiles = blocks.tiles;
  for (const Brick& b : blocks.bricks) q.origins.push_back(b.origin);
  if (!half) read_scales(chunk, h.bricks, q);
  if (const auto bad = check_codes(q)) refuse(chunk.place(), *bad);
  const std::uint64_t codes = count_code_bytes(q);
  require_size(head + codes, head + codes);
  q.codes.resize(codes);
  chunk.read(q.codes);
  if (const auto bad = check_codes(q)) refuse(chunk.place(), *bad);
  VoxelGrid grid = decode(q);
  const SampleCount count = count_samples(grid);
  return {std::move(grid), count};
}

}  // namespace pvol::formats::detail
