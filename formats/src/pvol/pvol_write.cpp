// Writing .pvol files: chunk after chunk, the header last.
#include <algorithm>
#include <cstring>
#include <fstream>
#include <sstream>

#include "pvol/error.h"
#include "pvol/formats/atomic_file.h"
#include "pvol/pvol_chunks.h"

namespace pvol::formats {
namespace {

using namespace detail;

void write(std::ostream& out, const std::vector<std::byte>& bytes) {
  out.write(reinterpret_cast<const char*>(bytes.data()), std::streamsize(bytes.size()));
}

/// Writes zeros up to the next multiple of kChunkAlignment, the offset of the next chunk.
std::uint64_t pad(std::ostream& out, std::uint64_t end) {
  const std::uint64_t padding = (kChunkAlignment - end % kChunkAlignment) % kChunkAlignment;
  const std::array<char, kChunkAlignment> zeros{};
  out.write(zeros.data(), std::streamsize(padding));
  return end + padding;
}

/// Compressed only where that is smaller: small chunks stay readable without zstd.
ChunkEntry write_small(std::ostream& out, Id id, Bytes raw, std::uint64_t offset,
                       Compression compression) {
  Codec codec = Codec::raw;
  if (compression == Compression::zstd && compressed_bytes(raw) < raw.size()) codec = Codec::zstd;
  ChunkWriter chunk(out, id, codec, offset);
  chunk.write(raw);
  return chunk.finish();
}

/// Header and table for these chunks.
std::vector<std::byte> make_header(const std::vector<ChunkEntry>& table) {
  FileHeader header;
  header.chunks = std::uint32_t(table.size());
  for (const ChunkEntry& e : table) {
    if (e.id == kMicro || e.id == kQuantised) header.version = std::max(header.version, 2u);
    if (e.id == kQuantised) header.reader_version = 2;
    if (e.id == kField) header.version = kVersion;
  }
  header.file_bytes = table.back().offset + table.back().stored_bytes;
  const std::size_t table_bytes = table.size() * sizeof(ChunkEntry);
  std::vector<std::byte> bytes(sizeof header + table_bytes);
  std::memcpy(bytes.data(), &header, sizeof header);
  std::memcpy(bytes.data() + sizeof header, table.data(), table_bytes);
  header.checksum = checksum(bytes);
  std::memcpy(bytes.data(), &header, sizeof header);
  return bytes;
}

std::vector<ChunkEntry> write_file(std::ostream& out, const PvolFile& content,
                                   Compression compression, const std::string& place);

/// A field as a file of its own.
std::string file_bytes(const PvolFile& field, Compression compression, const std::string& place) {
  std::ostringstream out(std::ios::binary);
  (void)write_file(out, field, compression, place + ": field '" + field.metadata.grid_name + "'");
  return std::move(out).str();
}

/// Refuses fields that readers would.
void check_fields(const PvolFile& content, const std::string& place) {
  std::vector<std::string> names{content.metadata.grid_name};
  for (const PvolFile& field : content.fields) {
    const std::string& name = field.metadata.grid_name;
    if (!field.fields.empty()) throw Error(place + ": a field cannot have fields itself.");
    if (std::find(names.begin(), names.end(), name) != names.end()) {
      throw Error(place + ": two grids are called '" + name + "'; names must differ.");
    }
    names.push_back(name);
  }
}

std::vector<ChunkEntry> write_chunks(std::ostream& out, const PvolFile& content,
                                     Compression compression, const std::string& place) {
  if (content.density && content.codes) {
    throw Error(place + ": a file holds either samples or codes for them, not both.");
  }
  check_fields(content, place);
  Metadata metadata = content.metadata;
  if (content.codes) {
    metadata.quantisation = content.codes->how;
    metadata.quantisation_error = content.codes->error;
  }
  const std::string meta = encode_metadata(metadata, content.pyramid.look_up, place);
  const std::vector<std::byte> bounds = encode_bounds(content.pyramid, place);
  const bool packed = compression == Compression::zstd;
  const std::size_t chunks = 2 + (content.micro ? 1 : 0) + (content.shell ? 1 : 0) +
                             (content.density || content.codes ? 1 : 0) + content.fields.size();
  std::vector<ChunkEntry> table(chunks);
  write(out, make_header(table));  // to be written again, once sizes and sums are known
  table.clear();
  std::uint64_t end = sizeof(FileHeader) + chunks * sizeof(ChunkEntry);
  const auto place_next = [&] { return pad(out, end); };
  const auto add = [&](const ChunkEntry& entry) {
    table.push_back(entry);
    end = entry.offset + entry.stored_bytes;
  };

  add(write_small(out, kMeta, std::as_bytes(std::span(meta)), place_next(), Compression::none));
  add(write_small(out, kBounds, bounds, place_next(), compression));
  if (content.micro) {
    ChunkWriter micro(out, kMicro, packed ? Codec::zstd : Codec::raw, place_next());
    encode_micro(*content.micro, content.pyramid, micro, place);
    add(micro.finish());
  }
  if (content.shell) {
    const std::vector<std::byte> shell = encode_shell(*content.shell, content.pyramid, place);
    add(write_small(out, kShell, shell, place_next(), Compression::none));
  }
  if (content.density) {
    ChunkWriter density(out, kDensity, packed ? Codec::shuffled_zstd : Codec::raw, place_next());
    encode_density(*content.density, content.pyramid, density, place);
    add(density.finish());
  }
  if (content.codes) {
    const bool half = content.codes->how.precision == Precision::fp16;
    const Codec codec = half ? Codec::shuffled_zstd : Codec::zstd;
    ChunkWriter density(out, kQuantised, packed ? codec : Codec::raw, place_next());
    encode_quantised(*content.codes, content.pyramid, density, place);
    add(density.finish());
  }
  for (const PvolFile& field : content.fields) {
    const std::string bytes = file_bytes(field, compression, place);
    ChunkWriter chunk(out, kField, Codec::raw, place_next());
    chunk.write(std::as_bytes(std::span(bytes)));
    add(chunk.finish());
  }
  return table;
}

std::vector<ChunkEntry> write_file(std::ostream& out, const PvolFile& content,
                                   Compression compression, const std::string& place) {
  const std::vector<ChunkEntry> table = write_chunks(out, content, compression, place);
  out.seekp(0);
  write(out, make_header(table));
  return table;
}

}  // namespace

PvolSizes write_pvol(const std::filesystem::path& file, const PvolFile& content,
                     Compression compression) {
  PvolSizes sizes;
  write_atomically(file, [&](const std::filesystem::path& aside) {
    std::ofstream out(aside, std::ios::binary | std::ios::trunc);
    const std::vector<ChunkEntry> table = write_file(out, content, compression, file.string());
    out.close();
    if (!out)
      throw Error(file.string() +
                  ": cannot be written completely; check that there is space on the disk");
    sizes = measure(table);
  });
  return sizes;
}

}  // namespace pvol::formats
