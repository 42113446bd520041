#include "pvol/field/leaf_micro_bounds.h"

#include <algorithm>
#include <string>

#include "pvol/error.h"
#include "pvol/field/micro_range.h"

namespace pvol {
namespace {

constexpr const char* kRemedy =
    " They belong to another density or were damaged; fit the cloud again.";

/// Where a leaf begins, for messages.
std::string place_of(const Pyramid& pyramid, std::size_t leaf) {
  const Vec3l at = pyramid.origin + Vec3l(morton_decode(pyramid.levels[0][leaf].code)) * kLeafEdge;
  const std::string x = std::to_string(at.x), y = std::to_string(at.y), z = std::to_string(at.z);
  return std::to_string(leaf) + " at (" + x + ", " + y + ", " + z + ")";
}

/// Bricks that no leaf reads are those of uniform cubes and of empty space: of one density.
void fill_constant(MicroBounds& m, const BrickField& field, const std::vector<bool>& filled) {
  for (std::size_t b = 0; b < filled.size(); ++b) {
    if (!filled[b]) m.scales[b] = {field.brick(std::uint32_t(b))[0], 0};
  }
}

}  // namespace

LeafMicroBounds build_leaf_micro_bounds(const VoxelGrid& grid, const Pyramid& pyramid, int edge) {
  const FieldWithLinks field = build_field(grid, pyramid);
  const MicroBounds by_brick = build_micro_bounds(field.field, edge);
  const auto cubes = std::ptrdiff_t(micro_cubes_per_brick(edge));
  LeafMicroBounds m;
  m.by_leaf.edge = edge;
  if (pyramid.empty()) return m;
  for (const std::uint32_t b : field.brick_of[0]) {
    m.by_leaf.scales.push_back(by_brick.scales[b]);
    const auto codes = by_brick.codes.begin() + b * cubes;
    m.by_leaf.codes.insert(m.by_leaf.codes.end(), codes, codes + cubes);
  }
  return m;
}

MicroBounds arrange(const LeafMicroBounds& bounds, const BrickField& field,
                    const std::vector<std::vector<std::uint32_t>>& brick_of,
                    const Pyramid& pyramid) {
  const MicroBounds& stored = bounds.by_leaf;
  const std::size_t leaves = pyramid.empty() ? 0 : pyramid.levels[0].size();
  const bool edge_known = stored.edge == 1 || stored.edge == 2;
  const std::size_t cubes = edge_known ? micro_cubes_per_brick(stored.edge) : 0;
  if (!edge_known || stored.scales.size() != leaves || stored.codes.size() != leaves * cubes) {
    throw Error("there are micro-bounds for " + std::to_string(stored.scales.size()) +
                " leaves; expected " + std::to_string(leaves) + "." + kRemedy);
  }
  MicroBounds m;
  m.edge = stored.edge;
  m.scales.resize(field.bricks());
  m.codes.resize(m.scales.size() * cubes);
  std::vector<bool> filled(m.scales.size());
  for (std::size_t leaf = 0; leaf < leaves; ++leaf) {
    const std::uint32_t b = brick_of[0][leaf];
    m.scales[b] = stored.scales[leaf];
    std::copy_n(&stored.codes[leaf * cubes], cubes, &m.codes[b * cubes]);
    filled[b] = true;
  }
  fill_constant(m, field, filled);
  if (const auto wrong = find_violation(m, field)) {
    const auto at = std::find(brick_of[0].begin(), brick_of[0].end(), *wrong);
    throw Error("the micro-bounds of leaf " +
                place_of(pyramid, std::size_t(at - brick_of[0].begin())) + " do not hold." +
                kRemedy);
  }
  return m;
}

}  // namespace pvol
