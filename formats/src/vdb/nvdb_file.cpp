#include "vdb/nvdb_file.h"

#include <fmt/format.h>

#include <blosc.h>
#include <zlib.h>

#include <algorithm>
#include <map>
#include <string_view>

#include "pvol/error.h"

namespace pvol::formats::detail {

using nanovdb::GridClass;
using nanovdb::GridType;

namespace {

constexpr std::string_view kSegmentMagic = "NanoVDB0";
constexpr std::uint32_t kMajorVersion = NANOVDB_MAJOR_VERSION_NUMBER;
enum Codec : std::uint16_t { kPlain = 0, kZip = 1, kBlosc = 2 };

std::string why_not_density(const NvdbGrid& e) {
  if (e.grid_class == GridClass::LevelSet) {
    return "it is a level set, which holds distances to a surface and no density; convert it to a "
           "fog volume first";
  }
  switch (e.type) {
    case GridType::Float:
    case GridType::Double:
    case GridType::Fp4:
    case GridType::Fp8:
    case GridType::Fp16:
    case GridType::FpN:
      return {};
    default:
      return "it holds " + nvdb_type(e.type) + " values, not a density";
  }
}

void check_start(ByteSource& source) {
  constexpr std::string_view kAnyMagic = "NanoVDB", kVdbStart = " BDV", kGzipMagic = "\x1f\x8b";
  const std::string where = source.file().string();
  if (source.size() == 0) throw Error(where + " is empty (0 bytes), not a .nvdb file");
  const auto n = std::size_t(std::min<std::uint64_t>(source.size(), kSegmentMagic.size()));
  const std::string_view start(source.at(0, n), n);
  if (start.starts_with(kGzipMagic)) {
    throw Error(where + " is compressed by gzip; unpack it first: gunzip -c FILE > CLOUD.nvdb");
  }
  if (start.starts_with(kVdbStart)) {
    throw Error(where + " is an OpenVDB file, not a NanoVDB one; give it the ending .vdb");
  }
  if (!start.starts_with(kAnyMagic)) {
    throw Error(where + " is not a .nvdb file: it does not begin with 'NanoVDB'");
  }
  if (n == kSegmentMagic.size() && start != kSegmentMagic) {
    throw Error(where + " is of a newer NanoVDB ('" + printable(std::string(start)) +
                "' instead of '" + std::string(kSegmentMagic) +
                "'); convert the original .vdb file instead");
  }
}

void check_version(const ByteCursor& cursor, std::uint32_t version) {
  const std::uint32_t major = version >> 21, minor = version >> 10 & 0x7ff;
  if (major == kMajorVersion) return;
  cursor.fail(
      fmt::format("NanoVDB version {}.{}, but {} is expected; write the file again with a current "
                  "NanoVDB, or convert the original .vdb file",
                  major, minor, kMajorVersion));
}

NvdbGrid take_entry(ByteCursor& cursor, std::uint16_t segment_codec) {
  NvdbGrid e;
  e.size = cursor.value<std::uint64_t>();
  e.stored.end = cursor.value<std::uint64_t>();  // its size, until it is placed
  cursor.skip(2 * 8);                            // hash of the name, active voxels
  e.type = GridType(cursor.value<std::uint32_t>());
  e.grid_class = GridClass(cursor.value<std::uint32_t>());
  cursor.skip(48 + 24 + 24);  // boxes, voxel size
  const auto name_size = cursor.value<std::uint32_t>();
  cursor.skip(16 + 12 + 2 + 2 + 4);  // counts, codec, padding, version
  constexpr std::uint32_t kLongestName = 1u << 16;
  if (name_size > kLongestName) cursor.fail("a name that is too long; the file is damaged");
  e.base.assign(cursor.bytes(name_size), name_size);
  e.base.resize(std::min(e.base.size(), e.base.find('\0')));
  e.codec = segment_codec;
  return e;
}

/// No codec makes data smaller than this, so a grid cannot be larger either.
void check_size(const ByteCursor& cursor, const NvdbGrid& e) {
  constexpr std::uint64_t kBestRatio[] = {1, 1032, 256};  // plain, zlib, LZ4 in Blosc
  const std::uint64_t stored = e.stored.size();
  const bool fits =
      e.codec == kPlain ? e.size == stored : e.size / kBestRatio[e.codec] <= stored && e.size > 0;
  if (fits && stored <= cursor.left()) return;
  cursor.fail(fmt::format(
      "a grid of {} bytes, stored in {}, of which {} are left; the file is damaged or cut off",
      e.size, stored, std::min(stored, cursor.left())));
}

/// Grids that share a name get an index, as OpenVDB does it.
void number_names(std::vector<NvdbGrid>& entries) {
  std::map<std::string, int> count, next;
  for (const NvdbGrid& e : entries) ++count[e.base];
  for (NvdbGrid& e : entries) {
    e.name = e.base;
    if (count[e.base] == 1 && !e.base.empty()) continue;
    e.name.append("[").append(fmt::to_string(next[e.base]++)).append("]");
  }
}

constexpr std::uint64_t kBloscPiece = std::uint64_t(1) << 30;  // what Blosc gets at once

void decode_blosc(ByteCursor& cursor, NvdbMemory& memory) {
  for (std::uint64_t done = 0; done < memory.size;) {
    const auto size = cursor.value<std::uint64_t>();
    const std::uint64_t plain = std::min(kBloscPiece, memory.size - done);
    if (size > cursor.left() || size < BLOSC_MIN_HEADER_LENGTH) {
      memory.fail(fmt::format("a compressed piece of {} bytes", size));
    }
    std::vector<char> packed(size);
    cursor.copy(packed.data(), size);
    std::size_t bytes = 0;
    if (blosc_cbuffer_validate(packed.data(), size, &bytes) != 0 || bytes != plain ||
        blosc_decompress_ctx(packed.data(), memory.data() + done, plain, 1) != int(plain)) {
      memory.fail("a compressed piece cannot be decoded");
    }
    done += plain;
  }
}

void decode_zip(ByteCursor& cursor, NvdbMemory& memory) {
  const auto size = cursor.value<std::uint64_t>();
  if (size > cursor.left()) memory.fail(fmt::format("compressed data of {} bytes", size));
  std::vector<Bytef> packed(size);
  cursor.copy(reinterpret_cast<char*>(packed.data()), size);
  uLongf plain = memory.size;
  if (uncompress(reinterpret_cast<Bytef*>(memory.data()), &plain, packed.data(), size) != Z_OK ||
      plain != memory.size) {
    memory.fail("its compressed data cannot be decoded");
  }
}

/// Blosc's data say how large they become; damaged sizes are found before memory is taken.
void check_first_piece(ByteCursor cursor, const NvdbGrid& e, const NvdbMemory& memory) {
  cursor.skip(8 + 4);  // its size in the file, versions and flags
  const auto plain = cursor.value<std::uint32_t>();
  if (plain != std::min(kBloscPiece, e.size)) memory.fail("a compressed piece has the wrong size");
}

}  // namespace

std::string nvdb_type(GridType type) {
  constexpr const char* kNames[] = {
      "unknown", "float", "double", "int16", "int32", "int64", "vec3s", "vec3d", "mask",  "half",
      "uint32",  "bool",  "rgba8",  "fp4",   "fp8",   "fp16",  "fpN",   "vec4s", "vec4d", "index"};
  const auto i = std::size_t(type);
  return i < std::size(kNames) ? kNames[i] : fmt::format("type {}", i);
}

std::vector<GridChoice> choices(const std::vector<NvdbGrid>& grids) {
  std::vector<GridChoice> list;
  for (const NvdbGrid& e : grids) {
    const bool level_set = e.grid_class == GridClass::LevelSet;
    list.push_back(
        {e.name, e.base, nvdb_type(e.type) + (level_set ? ", level set" : ""), why_not_density(e)});
  }
  return list;
}

std::vector<NvdbGrid> inspect_nvdb(ByteSource& source) {
  check_start(source);
  std::vector<NvdbGrid> entries;
  ByteCursor cursor(source, {0, source.size()}, "the list of grids");
  while (cursor.left() > 0) {
    if (std::string_view(cursor.bytes(8), 8) != kSegmentMagic) {
      cursor.fail("found no start of grids; the file is damaged");
    }
    check_version(cursor, cursor.value<std::uint32_t>());
    const auto count = cursor.value<std::uint16_t>();
    const auto codec = cursor.value<std::uint16_t>();
    if (codec > kBlosc) cursor.fail("unknown compression; the file is damaged");
    const std::size_t first = entries.size();
    for (int i = 0; i < count; ++i) entries.push_back(take_entry(cursor, codec));
    for (std::size_t i = first; i < entries.size(); ++i) {
      check_size(cursor, entries[i]);
      const std::uint64_t begin = cursor.position();
      cursor.skip(entries[i].stored.size());
      entries[i].stored = {begin, cursor.position()};
    }
  }
  number_names(entries);
  return entries;
}

void NvdbMemory::fail(const std::string& found) const {
  throw Error(where + found + "; the file is damaged");
}

NvdbMemory decode_nvdb(ByteSource& source, const NvdbGrid& e) {
  NvdbMemory memory;
  memory.size = e.size;
  memory.where = source.file().string() + ": grid '" + printable(e.name) + "': ";
  ByteCursor cursor(source, e.stored, "grid '" + printable(e.name) + "'");
  if (e.codec == kBlosc) check_first_piece(cursor, e, memory);
  memory.blocks.resize(std::size_t(e.size / sizeof(NvdbBlock) + 1));
  if (e.codec == kPlain) cursor.copy(memory.data(), e.size);
  if (e.codec == kZip) decode_zip(cursor, memory);
  if (e.codec == kBlosc) decode_blosc(cursor, memory);
  if (cursor.left() > 0) memory.fail("bytes are left after decoding");
  return memory;
}

}  // namespace pvol::formats::detail
