// Density grids through OpenVDB. The file is inspected first; OpenVDB then reads, as a stream with
// one grid, a header made here and the checked bytes of that grid's map and tree. So no other grid
// costs memory, and no metadata or offset of the file reaches OpenVDB.
#include <fmt/format.h>

#include <openvdb/openvdb.h>

#include <oneapi/tbb/blocked_range.h>
#include <oneapi/tbb/parallel_reduce.h>
#include <openvdb/io/Stream.h>
#include <openvdb/tree/LeafManager.h>

#include <algorithm>
#include <istream>
#include <mutex>
#include <streambuf>

#include "file/density_values.h"
#include "pvol/error.h"
#include "vdb/openvdb_start.h"
#include "vdb/vdb_inspect.h"

namespace pvol::formats {

void detail::start_openvdb() {
  static std::once_flag once;
  std::call_once(once, [] { openvdb::initialize(); });
}

namespace {

using openvdb::FloatTree;
using Leaf = FloatTree::LeafNodeType;
using detail::ByteRange;
using detail::ByteSource;
using detail::ValueCounts;
using detail::VdbFile;
using detail::VdbGrid;

constexpr std::uint64_t kUpperTile = 4096, kLowerTile = 128;  // edges of tiles of root and upper

/// Text, then ranges of a file, as one stream.
class SpliceBuffer : public std::streambuf {
 public:
  SpliceBuffer(std::string start, ByteSource& source, std::vector<ByteRange> ranges)
      : start_(std::move(start)), source_(&source), ranges_(std::move(ranges)) {
    setg(start_.data(), start_.data(), start_.data() + start_.size());
  }

  [[nodiscard]] bool at_end() const {
    return gptr() == egptr() && std::all_of(ranges_.begin(), ranges_.end(),
                                            [](const ByteRange& r) { return r.size() == 0; });
  }

 protected:
  int_type underflow() override {
    for (ByteRange& range : ranges_) {
      if (range.size() == 0) continue;
      const auto count = std::size_t(std::min<std::uint64_t>(range.size(), kChunk));
      chunk_.resize(kChunk);
      source_->copy(range.begin, count, chunk_.data());
      range.begin += count;
      setg(chunk_.data(), chunk_.data(), chunk_.data() + count);
      return traits_type::to_int_type(chunk_[0]);
    }
    return traits_type::eof();
  }

 private:
  static constexpr std::size_t kChunk = std::size_t(1) << 18;

  std::string start_;
  ByteSource* source_;
  std::vector<ByteRange> ranges_;
  std::vector<char> chunk_;
};

template <class T>
void append(std::string& text, T value) {
  text.append(reinterpret_cast<const char*>(&value), sizeof value);
}

void append_string(std::string& text, const std::string& value) {
  append(text, std::uint32_t(value.size()));
  text += value;
}

/// Header of a stream with one grid, up to the grid's map. The layout is that of streamed files:
/// no offsets, and zeros in their place.
std::string stream_header(const VdbFile& file, const VdbGrid& grid) {
  constexpr std::uint64_t kMagic = 0x56444220;
  const std::string any_uuid = "00000000-0000-0000-0000-000000000000";
  std::string text;
  append(text, kMagic);
  append(text, file.version);
  append(text, file.library_major);
  append(text, file.library_minor);
  append(text, char(0));  // no offsets
  text += any_uuid;
  append(text, std::uint32_t(0));  // metadata of the file
  append(text, std::uint32_t(1));  // grids
  append_string(text, "density");
  append_string(text, grid.type + (grid.half ? "_HalfFloat" : ""));
  append_string(text, "");  // parent
  text.append(3 * 8, '\0');
  append(text, grid.compression);
  append(text, std::uint32_t(grid.half));  // metadata of the grid
  if (grid.half) {
    append_string(text, "is_saved_as_half_float");
    append_string(text, "bool");
    append(text, std::uint32_t(1));
    append(text, char(1));
  }
  return text;
}

/// The grid, whose tree is that of `owner`, both inspected.
openvdb::GridBase::Ptr load_checked(ByteSource& source, const VdbFile& file, const VdbGrid& grid,
                                    const VdbGrid& owner) {
  SpliceBuffer buffer(stream_header(file, owner), source, {grid.map_bytes, owner.tree});
  std::istream stream(&buffer);
  const auto grids = openvdb::io::Stream(stream, /*delayLoad=*/false).getGrids();
  if (!grids || grids->size() != 1 || !grids->front() || !stream || !buffer.at_end()) {
    throw Error("it does not fill its part of the file; the file is damaged");
  }
  return grids->front();
}

openvdb::GridBase::Ptr load(ByteSource& source, const VdbFile& file, const VdbGrid& grid) {
  const VdbGrid& owner = tree_owner(source, file, grid);
  const detail::VdbTreeSize size = check_vdb_tree(source, owner, owner.tree.end);
  const std::string where =
      source.file().string() + ": grid '" + detail::printable(grid.name) + "': ";
  if (size.end != owner.tree.end) {
    throw Error(fmt::format("{}ends at byte {} instead of {}; the file is damaged", where, size.end,
                            owner.tree.end));
  }
  try {
    detail::start_openvdb();
    return load_checked(source, file, grid, owner);
  } catch (const std::bad_alloc&) {
    throw;
  } catch (const std::exception& e) {
    throw Error(where + e.what());
  }
}

/// OpenVDB's maps act on row vectors; asking where the axes go hides that.
Affine affine_map(const ByteSource& source, const VdbGrid& grid,
                  const openvdb::math::Transform& transform) {
  const auto map = transform.baseMap();
  Affine a;
  for (int c = 0; c < 3; ++c) {
    openvdb::Vec3d axis(0.0);
    axis[c] = 1;
    const openvdb::Vec3d image = map->applyJacobian(axis);
    for (int r = 0; r < 3; ++r) a.m[std::size_t(r)][c] = image[r];
  }
  const openvdb::Vec3d origin = map->applyMap(openvdb::Vec3d(0.0));
  a.t = {origin.x(), origin.y(), origin.z()};
  const Affine back = inverse(a);
  bool usable = is_finite(a.t) && is_finite(back.t);
  for (std::size_t r = 0; r < 3; ++r) usable &= is_finite(a.m[r]) && is_finite(back.m[r]);
  if (usable) return a;
  throw Error(source.file().string() + ": grid '" + detail::printable(grid.name) +
              "': its map to the world is not finite or flattens space; the file is damaged, or "
              "give the grid a transform with an inverse");
}

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
  throw Error(
      source.file().string() + ": grid '" + detail::printable(grid.name) +
      "': its active voxels do not fill the box that its metadata give; the file is damaged");
}

}  // namespace

std::vector<GridEntry> list_vdb(const std::filesystem::path& path) {
  ByteSource source(path);
  return detail::entries_of(choices(inspect_vdb(source)));
}

LoadedGrid read_vdb(const std::filesystem::path& path, const GridOptions& options) try {
  ByteSource source(path);
  VdbFile file = inspect_vdb(source);
  LoadedGrid loaded;
  GridReport& report = loaded.report;
  report.warnings = std::move(file.warnings);
  const std::vector<detail::GridChoice> list = choices(file);
  const VdbGrid& chosen = file.grids[choose_grid(path, list, options.grid, report.warnings)];
  report.grid = chosen.name;
  report.type = value_type(chosen);

  openvdb::GridBase::Ptr from = load(source, file, chosen);
  VoxelGrid& grid = loaded.grid;
  if (!chosen.base.empty()) grid.name = chosen.base;
  grid.index_to_world = affine_map(source, chosen, from->transform());
  const FloatTree::Ptr tree = take_tree(from);
  check_bbox(source, tree_owner(source, file, chosen), *tree);

  // Leaves are changed in place: the tiles first, while the background is as in the file.
  Found found = add_tiles(*tree, grid);
  found += add_bricks(*tree, grid);
  if (tree->background() > 0 && found.mirrored > 0) {
    throw Error(fmt::format(
        "{}: grid '{}' is a level set though it does not say so: its empty space holds {:f} "
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
