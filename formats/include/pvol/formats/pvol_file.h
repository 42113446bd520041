// Reading and writing .pvol files; FORMAT.md specifies every byte.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "pvol/bounds/pyramid.h"
#include "pvol/density/quantise.h"
#include "pvol/density/sample_count.h"
#include "pvol/density/voxel_grid.h"
#include "pvol/field/leaf_micro_bounds.h"
#include "pvol/math/names.h"
#include "pvol/shell/shell.h"

namespace pvol::formats {

/// Where the density came from, so that a file without embedded density finds it again.
struct Source {
  std::string file;         ///< as given to pvol-fit; relative paths are relative to the .pvol
  std::string grid;         ///< name of the grid in that file
  std::uint64_t bytes = 0;  ///< size of the file
  std::uint64_t hash = 0;   ///< XXH3-64 of the whole file
  /// Samples that are 0 in the density: NaN or infinite, and below 0.
  std::uint64_t non_finite = 0, negative = 0;
  std::string rounded_from{};  ///< type of the samples where a float does not hold it ("double")
};

struct Metadata {
  std::string grid_name = "density";
  Affine index_to_world;
  Source source;
  std::string unit;  ///< of the world, free text, e.g. "m"; empty where unknown
  std::map<std::string, std::string> options;  ///< of the fit, by name
  std::string written_by;                      ///< tool and version
  Quantisation quantisation{};                 ///< of the density; fp32: it is exact
  QuantisationError quantisation_error{};      ///< against the source
};

/// Everything in a .pvol file. Without `density` the source file is needed to render.
struct PvolFile {
  Metadata metadata;
  Pyramid pyramid;
  std::optional<VoxelGrid> density;        ///< name and map are those of the metadata
  std::optional<Shell> shell;              ///< around the support of the pyramid
  std::optional<LeafMicroBounds> micro{};  ///< of edge 2
  SampleCount count{};                     ///< of `density`, where it was read
  /// To be written in place of `density`, with precision and error in the metadata. Readers decode
  /// it: then `density` holds what the codes stand for.
  std::optional<QuantisedGrid> codes{};
  /// Further grids (flames, temperature) with bounds and maps of their own, told apart by
  /// metadata.grid_name. They have no fields themselves.
  std::vector<PvolFile> fields{};
  /// Of what was read from a file whose samples are used where they lie in it: gives back the
  /// memory of its pages, which the system reads again where they are used again. Else null.
  std::function<void()> forget_pages{};
};

/// Sizes in bytes of the parts of a file, as stored. The total includes padding and chunks of later
/// versions that this one skips.
struct PvolSizes {
  std::uint64_t header = 0, metadata = 0, bounds = 0, micro = 0, shell = 0, density = 0, fields = 0,
                total = 0;

  /// What no part accounts for.
  [[nodiscard]] std::uint64_t padding() const {
    return total - (header + metadata + bounds + micro + shell + density + fields);
  }
};

/// `none` makes files that any program can read without a decompressor, and whose samples, if they
/// are exact, are used where they lie in the mapped file.
enum class Compression { none, zstd };
[[nodiscard]] constexpr auto names(Compression) {
  return std::to_array<Named<Compression>>({
      {Compression::none, "none"},
      {Compression::zstd, "zstd"},
  });
}

/// Writes the file aside, syncs it and renames it: after an error the old file is still there. The
/// same content gives the same bytes (with the same zstd): density is stored in sorted order and
/// without bricks and tiles of zeros.
/// Throws Error for content that `read_pvol` would refuse, and where writing fails.
PvolSizes write_pvol(const std::filesystem::path& file, const PvolFile& content,
                     Compression compression = Compression::zstd);

/// Reads and validates everything: sizes, offsets, checksums, order of nodes, finite values. Memory
/// is that of the result, of the codes of a quantised density, and a megabyte for each thread;
/// samples that are exact and not compressed stay in the file, which is mapped as long as they are
/// used. The file must not be truncated meanwhile; replacing it, as `write_pvol` does, is safe.
/// Throws Error that names the file, the chunk, what was found and what was expected.
[[nodiscard]] PvolFile read_pvol(const std::filesystem::path& file);

/// The same from memory; `name` stands for the file in errors.
[[nodiscard]] PvolFile read_pvol(std::span<const std::byte> bytes, const std::string& name);

/// One grid of a file, without the fields beside it: the density where the name is empty or its
/// own, else the field of that name. Only what is returned is decoded. Throws Error that lists the
/// names for one that is not there.
[[nodiscard]] PvolFile read_pvol_grid(const std::filesystem::path& file, const std::string& name);

/// Names of a file's grids: first that of the density, then those of the fields.
struct PvolGridName {
  std::string name;
  bool empty = false;  ///< whether it is 0 everywhere
};
[[nodiscard]] std::vector<PvolGridName> list_pvol(const std::filesystem::path& file);

/// Sizes of the parts of a file whose header and chunk table are valid.
[[nodiscard]] PvolSizes measure_pvol(const std::filesystem::path& file);

/// XXH3-64 of a file's bytes, and its size.
struct FileHash {
  std::uint64_t hash = 0, bytes = 0;
};
[[nodiscard]] FileHash hash_file(const std::filesystem::path& file);

/// The bytes of a file's header and table, which tell whether two files hold the same, as their
/// checksums cover all else. Nothing else is read, so that damage elsewhere is not found. Throws
/// Error where they are not valid.
[[nodiscard]] std::string read_pvol_head(const std::filesystem::path& file);

}  // namespace pvol::formats
