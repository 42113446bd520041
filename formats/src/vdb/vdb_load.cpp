// A grid of a .vdb file by OpenVDB. The file is inspected first; OpenVDB then reads, as a stream
// with one grid, a header made here and the checked bytes of that grid's map and tree. So no other
// grid costs memory, and no metadata or offset of the file reaches OpenVDB.
#include "vdb/vdb_load.h"

#include <fmt/format.h>
#include <openvdb/io/Stream.h>

#include <algorithm>
#include <istream>
#include <mutex>
#include <streambuf>

#include "pvol/error.h"
#include "pvol/formats/memory.h"
#include "vdb/openvdb_start.h"

namespace pvol::formats::detail {

void start_openvdb() {
  static std::once_flag once;
  std::call_once(once, [] { openvdb::initialize(); });
}

namespace {

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

}  // namespace

openvdb::GridBase::Ptr load_vdb_grid(ByteSource& source, const VdbFile& file, const VdbGrid& grid) {
  const VdbGrid& owner = tree_owner(source, file, grid);
  const VdbTreeSize size = check_vdb_tree(source, owner, owner.tree.end);
  const std::string where = source.file().string() + ": grid '" + printable(grid.name) + "': ";
  if (size.end != owner.tree.end) {
    throw Error(fmt::format("{}ends at byte {} instead of {}; the file is damaged", where, size.end,
                            owner.tree.end));
  }
  // OpenVDB and blosc crash where memory ends while they read.
  constexpr std::uint64_t kBuffers = std::uint64_t{16} << 20;
  require_memory(size.memory + kBuffers,
                 source.file().string() + ": grid '" + printable(grid.name) + "'");
  try {
    start_openvdb();
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
  if (grid.map == kFrustumMap) {
    throw Error(source.file().string() + ": grid '" + printable(grid.name) + "': " + kInFrustum);
  }
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
  throw Error(source.file().string() + ": grid '" + printable(grid.name) +
              "': its map to the world is not finite or has no inverse; the file is damaged, or "
              "give the grid an invertible transform");
}

}  // namespace pvol::formats::detail
