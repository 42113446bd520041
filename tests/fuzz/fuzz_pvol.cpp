// .pvol files: what is read is written and read again the same, and rendered. Their checksums are
// made right first, or no damage would get past them.
#include <xxhash.h>

#include <cstring>
#include <vector>

#include "fuzz.h"
#include "pvol/pvol_chunks.h"
#include "use_cloud.h"

namespace {

using namespace pvol::fuzz;
using namespace pvol::formats;
using detail::Bytes;
using detail::ChunkEntry;
using detail::FileHeader;

/// Files may hold more than this once decompressed, but not here: zstd takes 20000 zeros in a byte.
constexpr std::uint64_t kMostRawBytes = std::uint64_t(4) << 20;

/// The table of a file, as far as it is there.
std::vector<ChunkEntry> table_of(Bytes file) {
  FileHeader header;
  if (file.size() < sizeof header) return {};
  std::memcpy(&header, file.data(), sizeof header);
  const std::size_t room = (file.size() - sizeof header) / sizeof(ChunkEntry);
  std::vector<ChunkEntry> table(std::min<std::size_t>(header.chunks, room));
  if (!table.empty()) {
    std::memcpy(table.data(), file.data() + sizeof header, table.size() * sizeof table[0]);
  }
  return table;
}

std::vector<std::byte> with_right_sums(Bytes file) {
  std::vector<std::byte> bytes(file.begin(), file.end());
  std::vector<ChunkEntry> table = table_of(file);
  if (table.empty()) return bytes;
  for (ChunkEntry& e : table) {
    if (e.offset > file.size() || e.stored_bytes > file.size() - e.offset) continue;
    e.checksum = XXH3_64bits(file.data() + e.offset, e.stored_bytes);
  }
  FileHeader header;
  std::memcpy(&header, file.data(), sizeof header);
  header.checksum = 0;
  const std::size_t table_bytes = table.size() * sizeof table[0];
  std::memcpy(bytes.data(), &header, sizeof header);
  std::memcpy(bytes.data() + sizeof header, table.data(), table_bytes);
  header.checksum = XXH3_64bits(bytes.data(), sizeof header + table_bytes);
  std::memcpy(bytes.data(), &header, sizeof header);
  return bytes;
}

/// What a file's chunks take once decompressed, as far as they tell the truth.
std::uint64_t raw_bytes(Bytes file) {
  std::uint64_t sum = 0;
  for (const ChunkEntry& e : table_of(file)) {
    if (e.raw_bytes > kMostRawBytes) return kMostRawBytes + 1;
    sum += e.raw_bytes;
  }
  return sum;
}

bool same_samples(const std::optional<pvol::VoxelGrid>& a,
                  const std::optional<pvol::VoxelGrid>& b) {
  if (!a || !b) return a.has_value() == b.has_value();
  if (a->bricks.size() != b->bricks.size() || a->tiles.size() != b->tiles.size()) return false;
  for (std::size_t i = 0; i < a->bricks.size(); ++i) {
    const pvol::Brick &x = a->bricks[i], &y = b->bricks[i];
    if (x.origin != y.origin) return false;
    if (!std::equal(x.values, x.values + pvol::kBrickSamples, y.values)) return false;
  }
  for (std::size_t i = 0; i < a->tiles.size(); ++i) {
    const pvol::Tile &x = a->tiles[i], &y = b->tiles[i];
    if (x.origin != y.origin || x.edge != y.edge || x.value != y.value) return false;
  }
  return true;
}

/// Bricks of zeros are not written.
void write_and_read_again(PvolFile content) {
  if (content.density) content.density = occupied(*content.density);
  const std::filesystem::path file = scratch_file("again.pvol", {});
  PvolFile again;
  const bool written = accepts([&] {
    write_pvol(file, content);
    again = read_pvol(file);
  });
  require(written, "what was read cannot be written or read again");
  require(same_samples(again.density, content.density), "the density reads back differently");
  require(again.pyramid == content.pyramid, "the bounds read back differently");
  require(again.shell == content.shell, "the shell reads back differently");
  require(again.micro == content.micro, "the micro-bounds read back differently");
  require(again.metadata.index_to_world == content.metadata.index_to_world,
          "the map reads back differently");
}

void read(Bytes file) {
  if (raw_bytes(file) > kMostRawBytes) return;
  PvolFile content;
  if (!accepts([&] { content = read_pvol(file, "input.pvol"); })) return;
  write_and_read_again(content);
  if (content.shell) use_shell(*content.shell);
  if (!content.density) return;
  accepts([&] {
    use_cloud(*content.density, content.pyramid, content.micro ? &*content.micro : nullptr);
  });
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const Bytes file = std::as_bytes(Input{data, size});
  read(file);
  read(with_right_sums(file));
  return 0;
}
