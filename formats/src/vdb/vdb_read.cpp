// Density grids through OpenVDB.
#include <fmt/format.h>

#include <openvdb/openvdb.h>

#include <oneapi/tbb/blocked_range.h>
#include <oneapi/tbb/parallel_reduce.h>
#include <openvdb/tree/LeafManager.h>

#include <algorithm>

#include "file/density_values.h"
#include "pvol/error.h"
#include "vdb/vdb_calls.h"
#include "vdb/vdb_load.h"

namespace pvol::formats {

namespace {

using openvdb::FloatTree;
using Leaf = FloatTree::LeafNodeType;
using detail::ByteSource;
using detail::ValueCounts;
using detail::VdbFile;
using detail::VdbGrid;

constexpr std::uint64_t kUpperTile = 4096, kLowerTile = 128;  // edges of tiles of root and upper

/// The grid's values as a float tree; a double tree is converted and freed.
FloatTree::Ptr take_tree(openvdb::GridBase::Ptr& grid) {
  if (const auto floats = openvdb::gridPtrCast<openvdb::FloatGrid>(grid)) {
    grid.reset();
    return floats->treePtr();
  }
  const auto doubles = openvdb::gridPtrCast<openvdb::DoubleGrid>(grid);
  grid.reset();
  return std::make_shared<FloatTree>(doubles->tree());
}

/// What a pass over leaves and tiles found.
struct Found {
  ValueCounts counts;
  std::uint64_t mirrored = 0;  ///< inactive samples of value -background

  Found& operator+=(const Found& o) {
    counts += o.counts;
    mirrored += o.mirrored;
    return *this;
  }
};

/// Makes the samples of a leaf densities, in place; tells whether any is above 0.
bool clean_leaf(Leaf& leaf, float background, Found& found) {
  float* values = leaf.buffer().data();
  const auto& mask = leaf.getValueMask();
  float largest = 0;
  for (openvdb::Index i = 0; i < Leaf::SIZE; ++i) {
    if (mask.isOn(i)) {
      values[i] = detail::to_density(values[i], 1, found.counts);
      largest = std::max(largest, values[i]);
    } else {
      found.counts.stray += detail::is_stray(values[i], background);
      found.mirrored += values[i] == -background;
      values[i] = 0;
    }
  }
  return largest > 0;
}

Found add_bricks(FloatTree& tree, VoxelGrid& grid) {
  openvdb::tree::LeafManager<FloatTree> leaves(tree);
  const float background = tree.background();
  std::vector<char> keep(leaves.leafCount());
  const Found found = oneapi::tbb::parallel_reduce(
      oneapi::tbb::blocked_range<std::size_t>(0, keep.size()), Found{},
      [&](const oneapi::tbb::blocked_range<std::size_t>& range, Found part) {
        for (std::size_t i = range.begin(); i < range.end(); ++i) {
          keep[i] = clean_leaf(leaves.leaf(i), background, part);
        }
        return part;
      },
      [](Found a, const Found& b) { return a += b; });
  for (std::size_t i = 0; i < keep.size(); ++i) {
    if (!keep[i]) continue;
    const openvdb::Coord o = leaves.leaf(i).origin();
    grid.bricks.push_back({{o.x(), o.y(), o.z()}, leaves.leaf(i).buffer().data()});
  }
  return found;
}

Found add_tiles(const FloatTree& tree, VoxelGrid& grid) {
  Found found;
  const float background = tree.background();
  auto it = tree.cbeginValueAll();
  it.setMaxDepth(FloatTree::ValueAllCIter::LEAF_DEPTH - 1);
  for (; it; ++it) {
    const std::uint64_t edge = it.getDepth() == 0   ? kUpperTile
                               : it.getDepth() == 1 ? kLowerTile
                                                    : std::uint64_t(kBrickEdge);
    const std::uint64_t samples = edge * edge * edge;
    if (it.isValueOn()) {
      const float value = detail::to_density(*it, samples, found.counts);
      const openvdb::Coord o = it.getCoord();
      if (value > 0) grid.tiles.push_back({{o.x(), o.y(), o.z()}, std::int32_t(edge), value});
    } else {
      if (detail::is_stray(*it, background)) found.counts.stray += samples;
      if (*it == -background) found.mirrored += samples;
    }
  }
  return found;
}

void check_bbox(const ByteSource& source, const VdbGrid& grid, const FloatTree& tree) {
  if (!grid.active_bbox) return;
  const auto& told = *grid.active_bbox;
  const bool told_any = told[0] <= told[3] && told[1] <= told[4] && told[2] <= told[5];
  openvdb::CoordBBox box;
  const bool any = tree.evalActiveVoxelBoundingBox(box);
  const openvdb::Coord lo = box.min(), hi = box.max();
  const std::array<std::int32_t, 6> found = {lo.x(), lo.y(), lo.z(), hi.x(), hi.y(), hi.z()};
  if (any ? found == told : !told_any) return;
  throw Error(source.file().string() + ": grid '" + detail::printable(grid.name) +
              "': its active voxels do not fill the box in its metadata; the file is damaged");
}

}  // namespace

LoadedGrid detail::read_vdb_density(const std::filesystem::path& path,
                                    const GridOptions& options) try {
  ByteSource source(path);
  VdbFile file = inspect_vdb(source);
  LoadedGrid loaded;
  GridReport& report = loaded.report;
  report.warnings = std::move(file.warnings);
  const std::vector<detail::GridChoice> list = choices(file);
  const VdbGrid& chosen = file.grids[choose_grid(path, list, options.grid, report.warnings)];
  report.grid = chosen.name;
  report.type = value_type(chosen);

  openvdb::GridBase::Ptr from = load_vdb_grid(source, file, chosen);
  VoxelGrid& grid = loaded.grid;
  if (!chosen.base.empty()) grid.name = chosen.base;
  grid.index_to_world = detail::affine_map(source, chosen, from->transform());
  const FloatTree::Ptr tree = take_tree(from);
  check_bbox(source, tree_owner(source, file, chosen), *tree);

  // Leaves are changed in place: the tiles first, while the background is as in the file.
  Found found = add_tiles(*tree, grid);
  found += add_bricks(*tree, grid);
  if (tree->background() > 0 && found.mirrored > 0) {
    throw Error(fmt::format(
        "{}: grid '{}' is a level set, though not marked as one: its empty space holds {:f} "
        "outside and minus that inside; convert it to a fog volume first; the file has: {}",
        path.string(), detail::printable(chosen.name), tree->background(), list_grids(list)));
  }
  sort(grid);
  grid.owner = tree;
  detail::finish_report(path, found.counts, tree->background(), options.strict, report);
  detail::warn_of_others(list, options, report);
  return loaded;
} catch (const std::bad_alloc&) {
  throw Error(path.string() + ": not enough memory to load it");
}

}  // namespace pvol::formats
