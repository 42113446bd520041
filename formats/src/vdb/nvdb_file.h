// What stands before the grids of a .nvdb file, and the bytes of one grid, decompressed.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include <nanovdb/NanoVDB.h>

#include "file/byte_source.h"
#include "file/grid_choice.h"

namespace pvol::formats::detail {

/// One grid of a file.
struct NvdbGrid {
  std::string name;  ///< unique: "density", "density[1]" where a name occurs again
  std::string base;  ///< without the index; may be empty
  nanovdb::GridType type = {};
  nanovdb::GridClass grid_class = {};
  std::uint16_t codec = 0;
  std::uint64_t size = 0;  ///< in memory
  ByteRange stored;        ///< in the file
};

/// The grids of a file, in its order. Throws Error for what is not a .nvdb file, is of another
/// version, damaged or cut off.
[[nodiscard]] std::vector<NvdbGrid> inspect_nvdb(ByteSource& source);

/// How people call the values: "float", "fp8", "vec3s", ...
[[nodiscard]] std::string nvdb_type(nanovdb::GridType type);

/// The grids as candidates for a density.
[[nodiscard]] std::vector<GridChoice> choices(const std::vector<NvdbGrid>& grids);

/// Memory with the alignment that nodes have.
struct alignas(NANOVDB_DATA_ALIGNMENT) NvdbBlock {
  char bytes[NANOVDB_DATA_ALIGNMENT];
};

/// A grid as NanoVDB has it in memory.
struct NvdbMemory {
  std::vector<NvdbBlock> blocks;
  std::uint64_t size = 0;
  std::string where;  ///< for messages

  [[nodiscard]] char* data() { return blocks.front().bytes; }
  [[nodiscard]] const char* data() const { return blocks.front().bytes; }

  /// Throws Error: the grid, what was found, and that the file is damaged.
  [[noreturn]] void fail(const std::string& found) const;

  /// The T at an offset, followed by `extra` bytes; throws Error where that is not all inside.
  template <class T>
  [[nodiscard]] const T& at(std::uint64_t offset, std::uint64_t extra = 0) const {
    if (offset > size || sizeof(T) > size - offset || extra > size - offset - sizeof(T) ||
        offset % alignof(T) != 0) {
      fail("a node lies outside the grid");
    }
    return *reinterpret_cast<const T*>(data() + offset);
  }
};

/// Reads and decompresses a grid. Throws Error where it does not become as large as it says.
[[nodiscard]] NvdbMemory decode_nvdb(ByteSource& source, const NvdbGrid& grid);

}  // namespace pvol::formats::detail
