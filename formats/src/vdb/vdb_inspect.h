// What a .vdb file says of itself, read and checked without OpenVDB.
//
// OpenVDB believes what it reads: truncated files load silently, lengths become allocations and
// offsets become writes past the end of buffers. So the file is walked here first, header,
// descriptors, metadata, maps and the whole structure of the tree that is wanted; OpenVDB then gets
// only bytes whose sizes are known to fit.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "file/byte_source.h"
#include "file/grid_choice.h"

namespace pvol::formats::detail {

/// Format versions that can be read: 222 (OpenVDB 1.1, 2013) is the oldest whose nodes say how they
/// are stored, 224 the newest that OpenVDB 10 knows.
inline constexpr std::uint32_t kOldestVdb = 222, kNewestVdb = 224;

/// Bits of VdbGrid::compression.
inline constexpr std::uint32_t kVdbZip = 1, kVdbActiveMask = 2, kVdbBlosc = 4;

/// A map of camera frustums, and why grids that have it cannot be used.
inline constexpr const char* kFrustumMap = "NonlinearFrustumMap";
inline constexpr const char* kInFrustum =
    "it lies in the frustum of a camera, which no affine map describes; resample it to a box";

/// One grid: its descriptor, the metadata that matter here, and where its parts are.
struct VdbGrid {
  std::string key;     ///< unique name as stored: the index follows a separator, not in brackets
  std::string name;    ///< unique name for people: "density", "density[1]"
  std::string base;    ///< without the index
  std::string type;    ///< of the tree, e.g. "Tree_float_5_4_3"
  bool half = false;   ///< values stored with 16 bits
  std::string parent;  ///< key of the grid whose tree this one shares; empty: its own

  std::uint32_t compression = 0;
  std::string grid_class;  ///< "fog volume", "level set", ..., empty where it does not say
  std::optional<std::uint64_t> voxel_count;                ///< active voxels
  std::optional<std::array<std::int32_t, 6>> active_bbox;  ///< min x y z, max x y z, inclusive

  std::string map;      ///< type of the map from index space to the world
  ByteRange map_bytes;  ///< its name and content
  ByteRange tree;       ///< topology and values; empty where it shares another grid's tree
  std::optional<std::uint64_t> values;  ///< where the values begin, if the file says so
};

struct VdbFile {
  std::uint32_t version = 0;
  std::uint32_t library_major = 0, library_minor = 0;
  std::vector<VdbGrid> grids;  ///< in the order of the file
  std::vector<std::string> warnings;
};

/// Header, descriptors, metadata and maps of all grids. Throws Error for what is not a .vdb file,
/// is of another version, damaged, cut off, or holds no grid.
[[nodiscard]] VdbFile inspect_vdb(ByteSource& source);

/// The grid whose tree `grid` uses: itself, or the one it shares it with.
[[nodiscard]] const VdbGrid& tree_owner(const ByteSource& source, const VdbFile& file,
                                        const VdbGrid& grid);

/// How people call the grid's values: "float", "half", "double", "vec3s", ...
[[nodiscard]] std::string value_type(const VdbGrid& grid);

/// The grids as candidates for a density.
[[nodiscard]] std::vector<GridChoice> choices(const VdbFile& file);

/// Size of a tree of scalars or vectors, from walking every node of it.
struct VdbTreeSize {
  std::uint64_t end = 0;            ///< first byte after the values
  std::uint64_t active_voxels = 0;  ///< tiles counted by their volume
  std::uint64_t memory = 0;         ///< bytes that OpenVDB takes for the tree, or a little less
};

/// Walks the structure of a grid's own tree that begins at grid.tree.begin and ends at or before
/// `limit`: child masks, compressed sizes, the masks of leaves, which are stored twice. Throws
/// Error where they do not fit together, where the values do not begin at grid.values, where the
/// number of active voxels is not grid.voxel_count, and for trees of other types.
[[nodiscard]] VdbTreeSize check_vdb_tree(ByteSource& source, const VdbGrid& grid,
                                         std::uint64_t limit);

}  // namespace pvol::formats::detail
