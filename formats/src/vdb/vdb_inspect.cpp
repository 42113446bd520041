#include "vdb/vdb_inspect.h"

#include <fmt/format.h>

#include <algorithm>
#include <string_view>

#include "pvol/error.h"

namespace pvol::formats::detail {

namespace {

constexpr std::uint64_t kVdbMagic = 0x56444220;     // "VDB ", in 8 bytes
constexpr std::string_view kNanoMagic = "NanoVDB";  // and a digit
constexpr std::string_view kGzipMagic = "\x1f\x8b";
constexpr std::string_view kLfsStart = "version https://git-lfs";
constexpr std::uint64_t kHeaderBytes = 8 + 4 + 4 + 4 + 1 + 36;  // up to and with the UUID
constexpr char kIndexSeparator = 30;                            // between a name and its index
constexpr std::string_view kHalfSuffix = "_HalfFloat";

bool starts_with(ByteSource& source, std::string_view text) {
  return source.size() >= text.size() &&
         std::string_view(source.at(0, text.size()), text.size()) == text;
}

bool is_text(ByteSource& source) {
  const std::size_t n = std::size_t(std::min<std::uint64_t>(source.size(), 64));
  const std::string_view start(source.at(0, n), n);
  return std::all_of(start.begin(), start.end(),
                     [](char c) { return (c >= ' ' && c < 127) || c == '\n' || c == '\r'; });
}

/// Names what the file is instead of a .vdb file.
void check_magic(ByteSource& source) {
  const std::string where = source.file().string();
  if (source.size() == 0) throw Error(where + " is empty (0 bytes), not a .vdb file");
  if (starts_with(source, kLfsStart)) {
    throw Error(where + " is a Git LFS pointer, not the file itself; run 'git lfs pull' to get it");
  }
  if (starts_with(source, kNanoMagic)) {
    throw Error(where + " is a NanoVDB file, not an OpenVDB one; give it the ending .nvdb");
  }
  if (starts_with(source, kGzipMagic)) {
    throw Error(where + " is compressed by gzip; unpack it first: gunzip -c FILE > CLOUD.vdb");
  }
  if (is_text(source)) throw Error(where + " is a text file, not a .vdb file");
  std::uint64_t magic = 0;
  std::memcpy(&magic, source.at(0, std::min<std::size_t>(8, source.size())),
              std::min<std::size_t>(8, source.size()));
  if (magic != kVdbMagic) {
    throw Error(where + " is not a .vdb file: it does not begin with the bytes ' BDV'");
  }
  if (source.size() < kHeaderBytes) {
    throw Error(
        fmt::format("{} is cut off: it has {} bytes, less than the header of a .vdb file; copy or "
                    "download it again",
                    where, source.size()));
  }
}

void check_version(const ByteCursor& cursor, const VdbFile& file) {
  const std::string version = fmt::to_string(file.version);
  if (file.version > kNewestVdb) {
    cursor.fail(
        fmt::format("format version {} (OpenVDB {}.{}), but versions up to {} can be read; write "
                    "it again with OpenVDB 12 or older",
                    version, file.library_major, file.library_minor, kNewestVdb));
  }
  if (file.version < kOldestVdb) {
    cursor.fail(
        fmt::format("format version {}, but versions from {} (OpenVDB 1.1) can be read; the file "
                    "is damaged, or load and save it with a current OpenVDB tool",
                    version, kOldestVdb));
  }
}

/// What metadata can say about a grid; the rest is skipped.
void take_metadata(ByteCursor& cursor, VdbGrid* grid) {
  const std::uint32_t count = cursor.value<std::uint32_t>();
  std::array<std::int32_t, 6> bbox = {};
  int bbox_parts = 0;
  for (std::uint32_t i = 0; i < count; ++i) {
    const std::string name = cursor.string(), type = cursor.string();
    const std::uint32_t size = cursor.value<std::uint32_t>();
    if (grid && name == "class" && type == "string" && size <= 256) {
      grid->grid_class.assign(cursor.bytes(size), size);
    } else if (grid && name == "file_voxel_count" && type == "int64" && size == 8) {
      grid->voxel_count = cursor.value<std::uint64_t>();
    } else if (grid && (name == "file_bbox_min" || name == "file_bbox_max") && type == "vec3i" &&
               size == 12) {
      std::memcpy(bbox.data() + (name == "file_bbox_max" ? 3 : 0), cursor.bytes(12), 12);
      ++bbox_parts;
    } else {
      cursor.skip(size);
    }
  }
  if (grid && bbox_parts == 2) grid->active_bbox = bbox;
}

/// Skips a map; every type has a fixed size but the frustum, which ends with a second map.
void skip_map(ByteCursor& cursor, const std::string& type) {
  constexpr std::uint64_t kVector = 3 * 8, kMatrix = 16 * 8;
  if (type == "UniformScaleMap" || type == "ScaleMap") return cursor.skip(5 * kVector);
  if (type == "UniformScaleTranslateMap" || type == "ScaleTranslateMap") {
    return cursor.skip(6 * kVector);
  }
  if (type == "TranslationMap") return cursor.skip(kVector);
  if (type == "AffineMap" || type == "UnitaryMap") return cursor.skip(kMatrix);
  if (type == "NonlinearFrustumMap") {
    cursor.skip(2 * kVector + 8 + 8);  // box, taper, depth
    const std::string second = cursor.string();
    if (second != "NonlinearFrustumMap") return skip_map(cursor, second);
  }
  cursor.fail("a map of type '" + printable(type) + "', which does not exist; the file is damaged");
}

std::string label(const VdbGrid& grid) { return "grid '" + printable(grid.name) + "'"; }

void take_names(ByteCursor& cursor, VdbGrid& grid) {
  grid.key = cursor.string();
  const std::size_t separator = grid.key.rfind(kIndexSeparator);
  grid.base = grid.key.substr(0, separator);
  grid.name = grid.base;
  if (separator != std::string::npos) {
    grid.name += '[';
    grid.name.append(grid.key, separator + 1).push_back(']');
  }
  grid.type = cursor.string();
  if (grid.type.ends_with(kHalfSuffix)) {
    grid.type.resize(grid.type.size() - kHalfSuffix.size());
    grid.half = true;
  }
  grid.parent = cursor.string();
}

/// Compression, metadata and map: what stands before the tree.
void take_head(ByteCursor& cursor, VdbGrid& grid) {
  grid.compression = cursor.value<std::uint32_t>();
  if (grid.compression > (kVdbZip | kVdbActiveMask | kVdbBlosc)) {
    cursor.fail(fmt::format("unknown compression {}; the file is damaged", grid.compression));
  }
  take_metadata(cursor, &grid);
  grid.map_bytes.begin = cursor.position();
  grid.map = cursor.string();
  skip_map(cursor, grid.map);
  grid.map_bytes.end = cursor.position();
}

/// A grid of a file with offsets; returns where the next one begins.
std::uint64_t take_grid(ByteSource& source, std::uint64_t begin, VdbGrid& grid) {
  ByteCursor cursor(source, {begin, source.size()}, "the list of grids");
  take_names(cursor, grid);
  cursor.set_place(label(grid));
  const auto head = cursor.value<std::uint64_t>();
  const auto values = cursor.value<std::uint64_t>();
  const auto end = cursor.value<std::uint64_t>();
  if (end > source.size() && end < std::uint64_t(1) << 62) {
    throw Error(
        fmt::format("{}: {} ends at byte {}, but the file has {} bytes: it is cut off or damaged; "
                    "copy or download it again",
                    source.file().string(), label(grid), end, source.size()));
  }
  const bool own = grid.parent.empty();
  if (head != cursor.position() || end < head || end > source.size() ||
      (own && (values < head || values > end))) {
    cursor.fail(
        fmt::format("offsets {}, {}, {} are out of order; the file is damaged", head, values, end));
  }
  ByteCursor body(source, {head, end}, label(grid));
  take_head(body, grid);
  grid.tree = {body.position(), end};
  if (own) grid.values = values;
  if (!own && grid.tree.size() != 0) body.fail("bytes after its map; the file is damaged");
  return end;
}

/// The same where offsets are 0 (a file made for a stream): the tree must be walked to its end.
std::uint64_t take_streamed_grid(ByteSource& source, std::uint64_t begin, VdbGrid& grid) {
  ByteCursor cursor(source, {begin, source.size()}, "the list of grids");
  take_names(cursor, grid);
  cursor.set_place(label(grid));
  cursor.skip(3 * 8);
  take_head(cursor, grid);
  grid.tree = {cursor.position(), cursor.position()};
  if (grid.parent.empty()) grid.tree.end = check_vdb_tree(source, grid, source.size()).end;
  return grid.tree.end;
}

}  // namespace

VdbFile inspect_vdb(ByteSource& source) {
  check_magic(source);
  ByteCursor cursor(source, {8, source.size()}, "the header");
  VdbFile file;
  file.version = cursor.value<std::uint32_t>();
  file.library_major = cursor.value<std::uint32_t>();
  file.library_minor = cursor.value<std::uint32_t>();
  check_version(cursor, file);
  const auto has_offsets = cursor.value<std::uint8_t>();
  if (has_offsets > 1) cursor.fail("neither with nor without offsets; the file is damaged");
  cursor.skip(36);  // UUID
  take_metadata(cursor, nullptr);

  const auto count = cursor.value<std::uint32_t>();
  constexpr std::uint64_t kSmallestGrid = 48;  // descriptor, compression, number of metadata
  if (count == 0) cursor.fail("the file holds no grids");
  if (count > cursor.left() / kSmallestGrid) {
    cursor.fail(
        fmt::format("{} grids in {} bytes; the file is damaged or cut off", count, cursor.left()));
  }
  std::uint64_t position = cursor.position();
  file.grids.resize(count);
  for (VdbGrid& grid : file.grids) {
    position = has_offsets ? take_grid(source, position, grid)
                           : take_streamed_grid(source, position, grid);
  }
  if (position < source.size()) {
    file.warnings.push_back(
        fmt::format("{} bytes follow the last grid; they are ignored", source.size() - position));
  }
  return file;
}

const VdbGrid& tree_owner(const ByteSource& source, const VdbFile& file, const VdbGrid& grid) {
  if (grid.parent.empty()) return grid;
  const auto owner = std::find_if(file.grids.begin(), file.grids.end(), [&](const VdbGrid& other) {
    return other.key == grid.parent && other.parent.empty() && other.type == grid.type;
  });
  if (owner != file.grids.end()) return *owner;
  throw Error(source.file().string() + ": " + label(grid) + " shares the tree of grid '" +
              printable(grid.parent) + "', which is not there; the file is damaged");
}

std::string value_type(const VdbGrid& grid) {
  std::string_view type = grid.type;
  if (!type.starts_with("Tree_")) return grid.type;
  type.remove_prefix(5);
  if (type.starts_with("ptdataidx") || type.starts_with("ptidx")) return "points";
  if (type.ends_with("_5_4_3")) type.remove_suffix(6);
  if (grid.half && type == "float") return "half";
  return std::string(type) + (grid.half ? ", half" : "");
}

namespace {

std::string why_not_density(const VdbGrid& grid) {
  const std::string type = value_type(grid);
  if (grid.grid_class == "level set") {
    return "it is a level set, which holds distances to a surface and no density; convert it to a "
           "fog volume first";
  }
  if (type.starts_with("vec")) return "it holds vectors (" + type + "), not a density";
  if (type.starts_with("bool") || type.starts_with("mask")) {
    return "it holds on/off values (" + type + "), not a density";
  }
  if (type.starts_with("int") || type.starts_with("uint")) {
    return "it holds whole numbers (" + type + "), not a density; convert it to float first";
  }
  if (type.starts_with("points")) {
    return "it holds points; rasterise them to a float grid first";
  }
  if (grid.type != "Tree_float_5_4_3" && grid.type != "Tree_double_5_4_3") {
    return "its type '" + printable(grid.type) + "' is not a float or double tree of layout 5_4_3";
  }
  return grid.map == kFrustumMap ? kInFrustum : "";
}

}  // namespace

std::vector<GridChoice> choices(const VdbFile& file) {
  std::vector<GridChoice> list;
  for (const VdbGrid& grid : file.grids) {
    const bool level_set = grid.grid_class == "level set";
    list.push_back({grid.name, grid.base, value_type(grid) + (level_set ? ", level set" : ""),
                    why_not_density(grid)});
  }
  return list;
}

}  // namespace pvol::formats::detail
