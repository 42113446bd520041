// .nvdb files. An uncompressed grid takes 300 kB or more, nearly all zeros, so that the corpus has
// compressed ones, and half of the mutations are made inside them.
#include <nanovdb/NanoVDB.h>
#include <zlib.h>

#include <cstring>
#include <random>
#include <vector>

#include "fuzz.h"
#include "pvol/formats/vdb.h"
#include "use_cloud.h"

extern "C" std::size_t LLVMFuzzerMutate(std::uint8_t* data, std::size_t size, std::size_t most);
extern "C" std::size_t LLVMFuzzerCustomMutator(std::uint8_t* data, std::size_t size,
                                               std::size_t most, unsigned seed);

namespace {

using Buffer = std::vector<std::uint8_t>;

/// A file of one grid, compressed by zlib: where its parts are.
constexpr std::size_t kSegment = 16, kEntry = 176;
constexpr std::size_t kSizeAt = kSegment, kStoredAt = kSegment + 8, kNameSizeAt = kSegment + 136;
constexpr std::uint16_t kZip = 1;
constexpr std::uint64_t kMostPlain = std::uint64_t(8) << 20;

template <class T>
T number(const Buffer& bytes, std::size_t at) {
  T value;
  std::memcpy(&value, bytes.data() + at, sizeof value);
  return value;
}

struct ZippedGrid {
  std::size_t at = 0;  ///< of its zlib stream in the file; 0: the file is of another kind
  Buffer plain;
};

ZippedGrid unzip(const Buffer& file) {
  ZippedGrid grid;
  if (file.size() < kSegment + kEntry || number<std::uint16_t>(file, 12) != 1 ||
      number<std::uint16_t>(file, 14) != kZip) {
    return grid;
  }
  const auto plain_bytes = number<std::uint64_t>(file, kSizeAt);
  const std::size_t at = kSegment + kEntry + number<std::uint32_t>(file, kNameSizeAt) + 8;
  if (at >= file.size() || plain_bytes > kMostPlain) return grid;
  grid.plain.resize(plain_bytes);
  uLongf size = plain_bytes;
  const int result = ::uncompress(grid.plain.data(), &size, file.data() + at, file.size() - at);
  if (result == Z_OK && size == plain_bytes) grid.at = at;
  return grid;
}

/// Puts the grid back, with right sizes.
void zip(const ZippedGrid& grid, Buffer& file) {
  uLongf packed = ::compressBound(grid.plain.size());
  file.resize(grid.at + packed);
  ::compress2(file.data() + grid.at, &packed, grid.plain.data(), grid.plain.size(), 1);
  file.resize(grid.at + packed);
  const std::uint64_t plain = grid.plain.size(), size = packed, stored = size + 8;
  std::memcpy(file.data() + kSizeAt, &plain, 8);
  std::memcpy(file.data() + kStoredAt, &stored, 8);
  std::memcpy(file.data() + grid.at - 8, &size, 8);
}

/// Mutates a few bytes in place, mostly where the grid has something.
void mutate(Buffer& plain, std::minstd_rand& random) {
  constexpr std::size_t kHead = 1024, kWindow = 64;
  if (plain.empty()) return;
  std::size_t at = random() % plain.size();
  if (random() % 2) at = random() % std::min(kHead, plain.size());
  while (at + 1 < plain.size() && plain[at] == 0 && random() % 4096) ++at;
  const std::size_t size = std::min<std::size_t>(random() % kWindow + 1, plain.size() - at);
  LLVMFuzzerMutate(plain.data() + at, size, size);
}

}  // namespace

extern "C" std::size_t LLVMFuzzerCustomMutator(std::uint8_t* data, std::size_t size,
                                               std::size_t most, unsigned seed) {
  std::minstd_rand random(seed);
  Buffer file(data, data + size);
  ZippedGrid grid = unzip(file);
  if (grid.at == 0 || random() % 2) return LLVMFuzzerMutate(data, size, most);
  mutate(grid.plain, random);
  zip(grid, file);
  if (file.size() > most) return LLVMFuzzerMutate(data, size, most);
  std::memcpy(data, file.data(), file.size());
  return file.size();
}

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace pvol::fuzz;
  const std::filesystem::path file = scratch_file("input.nvdb", {data, size});
  accepts([&] { use_grid(pvol::formats::read_nvdb(file).grid); });
  return 0;
}
