// The bytes of a .pvol file as its reader and its writer share them; see FORMAT.md.
#pragma once

#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <iosfwd>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "pvol/formats/pvol_file.h"

namespace pvol::formats::detail {

static_assert(std::endian::native == std::endian::little,
              "structures are copied as they are; a big-endian machine needs byte swaps here");

using Bytes = std::span<const std::byte>;
using Id = std::array<char, 4>;

inline constexpr std::array<unsigned char, 8> kMagic = {0x89, 'P',  'V',  'L',
                                                        '\r', '\n', 0x1a, '\n'};
inline constexpr std::uint32_t kVersion = 3;  // the newest this one knows
inline constexpr Id kMeta = {'M', 'E', 'T', 'A'};
inline constexpr Id kBounds = {'B', 'N', 'D', 'S'};
inline constexpr Id kMicro = {'m', 'i', 'c', 'r'};
inline constexpr Id kShell = {'s', 'h', 'e', 'l'};
inline constexpr Id kDensity = {'D', 'E', 'N', 'S'};
inline constexpr Id kQuantised = {'D', 'E', 'N', 'Q'};
inline constexpr Id kField = {'f', 'i', 'l', 'd'};  // any number of them

inline constexpr std::uint64_t kChunkAlignment = 64;
inline constexpr std::size_t kFrameBytes = std::size_t(1) << 20;  // raw bytes of a zstd frame
inline constexpr std::size_t kMaxMetaBytes = std::size_t(1) << 20;
inline constexpr std::uint64_t kMaxTerminals = std::uint64_t(1) << 26;  // as `build_pyramid` allows

struct FileHeader {
  std::array<unsigned char, 8> magic = kMagic;
  std::uint32_t version = 1;         // the oldest that has all that is in the file
  std::uint32_t reader_version = 1;  // the oldest reader that understands the file
  std::uint64_t file_bytes = 0;
  std::uint32_t chunks = 0;
  std::uint32_t reserved = 0;
  std::uint64_t checksum = 0;  // of header and table, with 0 in this place
};
static_assert(sizeof(FileHeader) == 40);

enum class Codec : std::uint32_t { raw = 0, zstd = 1, shuffled_zstd = 2 };

struct ChunkEntry {
  Id id = {};
  Codec codec = Codec::raw;
  std::uint64_t offset = 0;
  std::uint64_t stored_bytes = 0;
  std::uint64_t raw_bytes = 0;
  std::uint64_t checksum = 0;  // of the stored bytes
};
static_assert(sizeof(ChunkEntry) == 40);

struct BoundsHeader {
  std::array<std::int32_t, 3> origin = {}, support_lo = {}, support_hi = {};
  float scale = 0;
  std::uint32_t levels = 0;
  std::uint32_t upper = 0;      // wide nodes of height 1 and more
  std::uint32_t lower = 0;      // wide nodes of height 0
  std::uint32_t terminals = 0;  // leaves and uniform cubes
};
static_assert(sizeof(BoundsHeader) == 56);

struct ShellHeader {
  std::uint32_t kind = 0;  // 0 hard, 1 soft
  std::uint32_t perturbations = 0;
  double bound = 0;
  std::uint64_t boxes = 0;
  std::int32_t depth = 0;
  std::uint32_t reserved = 0;
  std::array<float, 4> tightness = {};  // volume, hits, volume of the box, hits of the box
};
static_assert(sizeof(ShellHeader) == 48);

struct MicroHeader {
  std::uint32_t edge = 0;    // of a cube, in cells
  std::uint32_t leaves = 0;  // of the pyramid
  std::uint32_t open = 0;    // those of more than one density, which have codes
  std::uint32_t reserved = 0;
};
static_assert(sizeof(MicroHeader) == 16);

struct DensityHeader {
  std::uint32_t tiles = 0, bricks = 0;
};

struct QuantisedHeader {
  std::uint32_t precision = 0;  // 1 fp16, 2 fp8, 3 fpn
  std::int32_t exponent = 0;    // of fp16
  std::uint32_t tiles = 0, bricks = 0;
};
static_assert(sizeof(QuantisedHeader) == 16);

struct TileRecord {
  std::array<std::int32_t, 3> origin = {};
  std::int32_t edge = 0;
  float value = 0;
};
static_assert(sizeof(TileRecord) == 20);

/// Throws Error: place, what is wrong, and what to do.
[[noreturn]] void refuse(const std::string& place, const std::string& wrong);

/// XXH3-64.
[[nodiscard]] std::uint64_t checksum(Bytes bytes);

/// The raw bytes of a chunk in order. Checks on construction that the stored bytes hold as many raw
/// bytes as the table says, so that nobody takes memory for more.
class ChunkReader {
 public:
  /// The bytes have an owner that keeps them, or last as long as this.
  ChunkReader(const ChunkEntry& entry, Bytes stored, std::string place,
              std::shared_ptr<const void> owner = nullptr);

  /// Fills `to`; refuses where less is left.
  void read(std::span<std::byte> to);

  template <class T>
  void read(std::vector<T>& to) {
    read(std::as_writable_bytes(std::span<T>(to)));
  }
  template <class T>
  [[nodiscard]] T get() {
    T value;
    read(std::as_writable_bytes(std::span<T>(&value, 1)));
    return value;
  }

  /// The next `size` bytes where they lie, and who keeps them; nothing where they are compressed
  /// or nobody keeps them: read them then.
  struct InPlace {
    Bytes bytes;
    std::shared_ptr<const void> owner;
  };
  [[nodiscard]] std::optional<InPlace> take_in_place(std::uint64_t size);

  [[nodiscard]] std::uint64_t raw_bytes() const { return entry_.raw_bytes; }
  [[nodiscard]] const std::string& place() const { return place_; }

 private:
  void require(std::uint64_t size) const;
  void find_frames(Bytes rest);
  void decode_frame(Bytes frame, std::span<std::byte> to) const;
  [[nodiscard]] std::size_t decode_whole_frames(std::span<std::byte> to);
  void decode_next_frame();

  ChunkEntry entry_;
  std::vector<Bytes> frames_;  // of a compressed chunk
  std::size_t next_frame_ = 0;
  Bytes frame_;  // raw bytes still to be read of the current frame, or of a chunk as it is
  std::uint64_t left_;
  std::vector<std::byte> buffer_;
  std::string place_;
  std::shared_ptr<const void> owner_;
};

/// Appends one chunk to a stream: raw bytes in, its table entry out.
class ChunkWriter {
 public:
  ChunkWriter(std::ostream& out, Id id, Codec codec, std::uint64_t offset);
  ~ChunkWriter();

  void write(Bytes raw);
  template <class T>
  void put(const T& value) {
    write(std::as_bytes(std::span<const T>(&value, 1)));
  }
  /// Writes what is pending.
  [[nodiscard]] ChunkEntry finish();

 private:
  void write_frame();
  void store(Bytes bytes);

  struct State;  // zstd's and xxHash's
  std::unique_ptr<State> state_;
  std::ostream& out_;
  ChunkEntry entry_;
  std::vector<std::byte> buffer_;
};

/// The size of a chunk's bytes under Codec::zstd.
[[nodiscard]] std::uint64_t compressed_bytes(Bytes raw);

/// Sizes of the parts, from a table.
[[nodiscard]] PvolSizes measure(const std::vector<ChunkEntry>& table);

/// META.
struct DecodedMetadata {
  Metadata metadata;
  LookUp bounds_made_for;  ///< Pyramid::interpolation
};
[[nodiscard]] std::string encode_metadata(const Metadata& metadata, LookUp bounds_made_for,
                                          const std::string& place);
[[nodiscard]] DecodedMetadata decode_metadata(ChunkReader& chunk);

/// BNDS.
[[nodiscard]] std::vector<std::byte> encode_bounds(const Pyramid& pyramid,
                                                   const std::string& place);
[[nodiscard]] Pyramid decode_bounds(ChunkReader& chunk, LookUp made_for);

/// micr.
void encode_micro(const LeafMicroBounds& micro, const Pyramid& pyramid, ChunkWriter& chunk,
                  const std::string& place);
[[nodiscard]] LeafMicroBounds decode_micro(ChunkReader& chunk, const Pyramid& pyramid);

/// shel. The box is the support of the pyramid.
[[nodiscard]] std::vector<std::byte> encode_shell(const Shell& shell, const Pyramid& pyramid,
                                                  const std::string& place);
[[nodiscard]] Shell decode_shell(ChunkReader& chunk, const Pyramid& pyramid);

struct CountedGrid {
  VoxelGrid grid;
  SampleCount count;
};

/// DENS. The samples must lie in leaves of the pyramid.
void encode_density(const VoxelGrid& grid, const Pyramid& pyramid, ChunkWriter& chunk,
                    const std::string& place);
[[nodiscard]] CountedGrid decode_density(ChunkReader& chunk, const Pyramid& pyramid);

/// DENQ. The metadata must state the same precision.
void encode_quantised(const QuantisedGrid& grid, const Pyramid& pyramid, ChunkWriter& chunk,
                      const std::string& place);
[[nodiscard]] CountedGrid decode_quantised(ChunkReader& chunk, const Pyramid& pyramid,
                                           const Metadata& metadata);

}  // namespace pvol::formats::detail
