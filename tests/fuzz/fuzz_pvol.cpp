// .pvol files: what is read is written and read again the same, and rendered. Their checksums are
// made right first, or no damage would get past them.
#include <xxhash.h>

#include <cstring>
#include <vector>

#include "fuzz.h"
#include "pvol/formats/color.h"
#include "pvol/formats/field_names.h"
#include "pvol/formats/velocity.h"
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

/// Fields are files of their own.
std::vector<std::byte> with_right_sums(Bytes file, int depth = 0) {
  std::vector<std::byte> bytes(file.begin(), file.end());
  std::vector<ChunkEntry> table = table_of(file);
  if (table.empty()) return bytes;
  for (ChunkEntry& e : table) {
    if (e.offset > file.size() || e.stored_bytes > file.size() - e.offset) continue;
    if (e.id == detail::kField && depth == 0) {
      const auto field = with_right_sums(file.subspan(e.offset, e.stored_bytes), 1);
      std::copy(field.begin(), field.end(), bytes.begin() + std::ptrdiff_t(e.offset));
    }
    e.checksum = XXH3_64bits(bytes.data() + e.offset, e.stored_bytes);
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
std::uint64_t raw_bytes(Bytes file, int depth = 0) {
  std::uint64_t sum = 0;
  for (const ChunkEntry& e : table_of(file)) {
    if (e.raw_bytes > kMostRawBytes) return kMostRawBytes + 1;
    sum += e.raw_bytes;
    const bool inside = e.offset <= file.size() && e.stored_bytes <= file.size() - e.offset;
    if (e.id == detail::kField && depth == 0 && inside) {
      sum += raw_bytes(file.subspan(e.offset, e.stored_bytes), 1);
    }
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

void require_same(const PvolFile& again, const PvolFile& content) {
  require(same_samples(again.density, content.density), "the density reads back differently");
  require(again.pyramid == content.pyramid, "the bounds read back differently");
  require(again.shell == content.shell, "the shell reads back differently");
  require(again.micro == content.micro, "the micro-bounds read back differently");
  require(again.metadata.index_to_world == content.metadata.index_to_world,
          "the map reads back differently");
  require(again.fields.size() == content.fields.size(), "there are other fields");
  for (std::size_t i = 0; i < content.fields.size(); ++i) {
    require_same(again.fields[i], content.fields[i]);
  }
}

/// What goes by the fields.
void use_fields(const std::filesystem::path& file) {
  accepts([&] { (void)read_velocity(file, ""); });
  accepts([&] {
    const std::string name = usual_color_grid(grids_of(file));
    if (!name.empty()) (void)read_color(file, name);
  });
}

/// Bricks of zeros are not written.
void write_and_read_again(PvolFile content) {
  const auto tidy = [](PvolFile& f) {
    if (f.density) f.density = occupied(*f.density);
  };
  tidy(content);
  for (PvolFile& field : content.fields) tidy(field);
  const std::filesystem::path file = scratch_file("again.pvol", {});
  PvolFile again;
  const bool written = accepts([&] {
    write_pvol(file, content);
    again = read_pvol(file);
  });
  require(written, "what was read cannot be written or read again");
  require_same(again, content);
  if (!content.fields.empty()) use_fields(file);
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
