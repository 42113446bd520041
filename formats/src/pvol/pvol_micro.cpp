// The micr chunk: bounds of cubes of 2^3 cells, leaf by leaf.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "pvol/error.h"
#include "pvol/field/micro_range.h"
#include "pvol/pvol_chunks.h"

namespace pvol::formats::detail {
namespace {

constexpr int kEdge = 2;
constexpr std::size_t kCubes = micro_cubes_per_brick(kEdge);

std::size_t leaf_count(const Pyramid& p) { return p.empty() ? 0 : p.levels[0].size(); }

/// Leaves of one density have a step of 0 and no codes.
std::size_t count_open(const std::vector<MicroBounds::Scale>& scales) {
  return std::size_t(
      std::count_if(scales.begin(), scales.end(), [](const auto& s) { return s.step > 0; }));
}

/// A sentence about the first thing that is wrong with scales and codes.
std::optional<std::string> check(const MicroBounds& m) {
  const auto good = [](float v) { return v >= 0 && std::isfinite(v); };
  for (std::size_t i = 0; i < m.scales.size(); ++i) {
    const auto leaf = [&](const char* wrong) { return fmt::format("leaf {}: {}", i, wrong); };
    if (!good(m.scales[i].base)) return leaf("its base is negative or not finite");
    if (!good(m.scales[i].step)) return leaf("its step is negative or not finite");
    for (std::size_t c = i * kCubes; c < (i + 1) * kCubes; ++c) {
      if (m.codes[c].lo > m.codes[c].hi) return leaf("a lower bound above the upper one");
    }
  }
  return std::nullopt;
}

/// Calls f(code) for the codes of every leaf that has some, in order.
template <class Codes, class F>
void for_codes(const std::vector<MicroBounds::Scale>& scales, Codes& codes, const F& f) {
  for (std::size_t i = 0; i < scales.size(); ++i) {
    if (!(scales[i].step > 0)) continue;
    for (std::size_t c = i * kCubes; c < (i + 1) * kCubes; ++c) f(codes[c]);
  }
}

using Byte = std::uint8_t MicroBounds::Codes::*;
using Float = float MicroBounds::Scale::*;

constexpr Float kFloats[] = {&MicroBounds::Scale::base, &MicroBounds::Scale::step};
constexpr Byte kBytes[] = {&MicroBounds::Codes::lo, &MicroBounds::Codes::hi};

}  // namespace

void encode_micro(const LeafMicroBounds& micro, const Pyramid& pyramid, ChunkWriter& chunk,
                  const std::string& place) {
  const MicroBounds& m = micro.by_leaf;
  const std::size_t leaves = leaf_count(pyramid);
  if (m.edge != kEdge || m.scales.size() != leaves || m.codes.size() != leaves * kCubes) {
    throw Error(
        place +
        ": the micro-bounds to write belong to another cloud, or are not for cubes of 2^3 cells.");
  }
  if (const auto wrong = check(m)) {
    throw Error(place + ": the micro-bounds to write are wrong: " + *wrong + ".");
  }
  chunk.put(MicroHeader{kEdge, std::uint32_t(leaves), std::uint32_t(count_open(m.scales)), 0});
  // Like stands with like, which compresses better than the same leaf by leaf.
  for (const Float member : kFloats) {
    std::vector<float> row;
    for (const MicroBounds::Scale& s : m.scales) row.push_back(s.*member);
    chunk.write(std::as_bytes(std::span(row)));
  }
  for (const Byte member : kBytes) {
    std::vector<std::uint8_t> row;
    for_codes(m.scales, m.codes, [&](const MicroBounds::Codes& c) { row.push_back(c.*member); });
    chunk.write(std::as_bytes(std::span(row)));
  }
}

LeafMicroBounds decode_micro(ChunkReader& chunk, const Pyramid& pyramid) {
  const auto h = chunk.get<MicroHeader>();
  if (h.edge != kEdge) {
    throw Error(fmt::format("{}: micro-bounds of the unknown edge {}. Use a newer pvol.",
                            chunk.place(), h.edge));
  }
  const std::size_t leaves = leaf_count(pyramid);
  if (h.leaves != leaves || h.open > h.leaves) {
    refuse(chunk.place(), fmt::format("{} leaves, of which {} have codes; the bounds have {}",
                                      h.leaves, h.open, leaves));
  }
  const std::uint64_t expected = sizeof(MicroHeader) + sizeof(MicroBounds::Scale) * leaves +
                                 sizeof(MicroBounds::Codes) * kCubes * h.open;
  if (chunk.raw_bytes() != expected) {
    refuse(chunk.place(),
           fmt::format("{} raw bytes; its counts of {} leaves and {} with codes take {}",
                       chunk.raw_bytes(), h.leaves, h.open, expected));
  }
  LeafMicroBounds micro;
  MicroBounds& m = micro.by_leaf;
  m.edge = kEdge;
  m.scales.resize(leaves);
  for (const Float member : kFloats) {
    std::vector<float> row(leaves);
    chunk.read(row);
    for (std::size_t i = 0; i < leaves; ++i) m.scales[i].*member = row[i];
  }
  if (count_open(m.scales) != h.open) {
    refuse(chunk.place(),
           fmt::format("{} leaves have a step above 0; {} should", count_open(m.scales), h.open));
  }
  m.codes.resize(leaves * kCubes);
  for (const Byte member : kBytes) {
    std::vector<std::uint8_t> row(kCubes * h.open);
    chunk.read(row);
    auto next = row.begin();
    for_codes(m.scales, m.codes, [&](MicroBounds::Codes& c) { c.*member = *next++; });
  }
  if (const auto wrong = check(m)) refuse(chunk.place(), *wrong);
  return micro;
}

}  // namespace pvol::formats::detail
