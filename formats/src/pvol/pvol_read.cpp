// Reading .pvol files: header and table are checked whole before any chunk is looked at.
#include <fmt/format.h>

#include <algorithm>
#include <cstring>
#include <memory>
#include <new>

#include "file/mapped_file.h"
#include "pvol/error.h"
#include "pvol/pvol_chunks.h"

namespace pvol::formats {
namespace {

using namespace detail;
namespace fs = std::filesystem;

template <class T>
T copy_at(Bytes bytes, std::size_t offset) {
  T value;
  std::memcpy(&value, bytes.data() + offset, sizeof(T));
  return value;
}

std::string text(Id id) {
  const bool printable =
      std::all_of(id.begin(), id.end(), [](char c) { return c > 32 && c < 127; });
  return printable ? std::string(id.begin(), id.end()) : "with an unprintable name";
}

std::string expected(std::uint64_t found, std::uint64_t wanted) {
  return fmt::format("{}; expected {}", found, wanted);
}

FileHeader read_header(Bytes bytes, const std::string& name) {
  const std::size_t known = std::min(bytes.size(), kMagic.size());
  if (known < kMagic.size() || std::memcmp(bytes.data(), kMagic.data(), known) != 0) {
    refuse(name, "does not begin with the signature of a .pvol file");
  }
  if (bytes.size() < sizeof(FileHeader)) {
    refuse(name, fmt::format("a file of {} bytes is too short for a header", bytes.size()));
  }
  const auto h = copy_at<FileHeader>(bytes, 0);
  if (h.version < 1 || h.reader_version < 1 || h.reader_version > h.version) {
    refuse(name, fmt::format("header: format version {} for readers of version {} is impossible",
                             h.version, h.reader_version));
  }
  if (h.reader_version > kVersion) {
    throw Error(
        fmt::format("{}: a file of format version {}, which needs a reader of version {}; this one "
                    "has version {}. Use a newer pvol.",
                    name, h.version, h.reader_version, kVersion));
  }
  if (h.file_bytes != bytes.size()) {
    refuse(name, "header: file size " + expected(bytes.size(), h.file_bytes) +
                     ", so the file is truncated or has grown");
  }
  if (h.chunks > (bytes.size() - sizeof(FileHeader)) / sizeof(ChunkEntry)) {
    refuse(name, fmt::format("header: {} chunks do not fit into the file", h.chunks));
  }
  return h;
}

/// Header and table, with the checksum of both.
std::vector<ChunkEntry> read_table(Bytes bytes, const std::string& name) {
  const FileHeader h = read_header(bytes, name);
  const std::size_t end = sizeof(FileHeader) + h.chunks * sizeof(ChunkEntry);
  std::vector<std::byte> head(bytes.begin(), bytes.begin() + std::ptrdiff_t(end));
  std::memset(head.data() + offsetof(FileHeader, checksum), 0, sizeof h.checksum);
  if (checksum(head) != h.checksum) refuse(name, "header: the checksum does not match");

  std::vector<ChunkEntry> table(h.chunks);
  for (std::size_t i = 0; i < table.size(); ++i) {
    table[i] = copy_at<ChunkEntry>(bytes, sizeof(FileHeader) + i * sizeof(ChunkEntry));
  }
  return table;
}

/// Chunks follow each other in the table's order with zeros between: nothing overlaps, nothing is
/// left over.
void check_layout(Bytes bytes, const std::vector<ChunkEntry>& table, const std::string& name) {
  std::uint64_t end = sizeof(FileHeader) + table.size() * sizeof(ChunkEntry);
  for (const ChunkEntry& e : table) {
    const std::string place = name + ": chunk " + text(e.id);
    const std::uint64_t start = (end + kChunkAlignment - 1) / kChunkAlignment * kChunkAlignment;
    if (e.offset != start) refuse(place, "offset " + expected(e.offset, start));
    if (start > bytes.size() || e.stored_bytes > bytes.size() - start) {
      refuse(place, fmt::format("its {} bytes from {} extend past the end of the file",
                                e.stored_bytes, start));
    }
    const Bytes padding = bytes.subspan(end, start - end);
    if (std::any_of(padding.begin(), padding.end(), [](std::byte b) { return b != std::byte{}; })) {
      refuse(place, "the padding before it is not zero");
    }
    end = start + e.stored_bytes;
  }
  if (end != bytes.size()) refuse(name, "chunks end at " + expected(end, bytes.size()));
}

/// What later versions may add without harm has an id that begins in lower case.
bool is_ancillary(Id id) { return id[0] >= 'a' && id[0] <= 'z'; }

/// The file that is mapped; null: the bytes are the caller's.
using Owner = std::shared_ptr<const MappedFile>;

/// The chunks of a file, found and checked.
class Container {
 public:
  Container(Bytes bytes, std::string name, Owner owner = nullptr)
      : bytes_(bytes), name_(std::move(name)), owner_(std::move(owner)) {
    table_ = read_table(bytes_, name_);
    check_layout(bytes_, table_, name_);
    for (const ChunkEntry& e : table_) {
      const bool known = e.id == kMeta || e.id == kBounds || e.id == kDensity || e.id == kQuantised;
      if (!known && !is_ancillary(e.id)) {
        throw Error(name_ + ": chunk " + text(e.id) +
                    " is unknown to this version and cannot be skipped. Use a newer pvol.");
      }
    }
    for (const Id id : {kMeta, kBounds, kMicro, kShell, kDensity, kQuantised}) {
      const auto n =
          std::count_if(table_.begin(), table_.end(), [&](auto& e) { return e.id == id; });
      if (n > 1 || (n == 0 && (id == kMeta || id == kBounds))) {
        refuse(name_, fmt::format("chunk {} occurs {} times", text(id), n));
      }
    }
    if (has(kDensity) && has(kQuantised))
      refuse(name_, "found both DENS and DENQ; expected one of them");
  }

  [[nodiscard]] const std::vector<ChunkEntry>& table() const { return table_; }
  [[nodiscard]] bool has(Id id) const { return find(id) != nullptr; }
  [[nodiscard]] const std::string& name() const { return name_; }
  [[nodiscard]] const Owner& owner() const { return owner_; }

  /// The files within the file, once their checksums are found to be right.
  [[nodiscard]] std::vector<Container> fields() const {
    std::vector<Container> all;
    for (const ChunkEntry& e : table_) {
      if (e.id != kField) continue;
      const std::string place = fmt::format("{}: field at byte {}", name_, e.offset);
      if (e.codec != Codec::raw) refuse(place, "it is compressed as a whole");
      const Bytes stored = bytes_.subspan(e.offset, e.stored_bytes);
      if (checksum(stored) != e.checksum) refuse(place, "the checksum does not match");
      all.emplace_back(stored, place, owner_);
    }
    return all;
  }

  /// What decode_chunk makes of the chunk, once its checksum is found to be right.
  template <class Decode>
  [[nodiscard]] auto decode(Id id, const Decode& decode_chunk) const {
    const ChunkEntry& e = *find(id);
    const std::string place = fmt::format("{}: chunk {} at byte {}", name_, text(id), e.offset);
    const Bytes stored = bytes_.subspan(e.offset, e.stored_bytes);
    if (checksum(stored) != e.checksum) refuse(place, "the checksum does not match");
    ChunkReader chunk(e, stored, place, owner_);
    return decode_chunk(chunk);
  }

 private:
  [[nodiscard]] const ChunkEntry* find(Id id) const {
    const auto at = std::find_if(table_.begin(), table_.end(), [&](auto& e) { return e.id == id; });
    return at == table_.end() ? nullptr : &*at;
  }

  Bytes bytes_;
  std::string name_;
  Owner owner_;
  std::vector<ChunkEntry> table_;
};

}  // namespace

PvolSizes detail::measure(const std::vector<ChunkEntry>& table) {
  PvolSizes sizes;
  sizes.header = sizeof(FileHeader) + table.size() * sizeof(ChunkEntry);
  sizes.total = sizes.header;
  for (const ChunkEntry& e : table) {
    if (e.id == kMeta) sizes.metadata = e.stored_bytes;
    if (e.id == kBounds) sizes.bounds = e.stored_bytes;
    if (e.id == kMicro) sizes.micro = e.stored_bytes;
    if (e.id == kShell) sizes.shell = e.stored_bytes;
    if (e.id == kDensity || e.id == kQuantised) sizes.density = e.stored_bytes;
    if (e.id == kField) sizes.fields += e.stored_bytes;
    sizes.total = e.offset + e.stored_bytes;
  }
  return sizes;
}

namespace {

/// All chunks but the fields.
PvolFile read_grid(const Container& file, const std::string& name) {
  PvolFile content;
  DecodedMetadata metadata = file.decode(kMeta, decode_metadata);
  content.metadata = std::move(metadata.metadata);
  content.pyramid = file.decode(
      kBounds, [&](ChunkReader& c) { return decode_bounds(c, metadata.bounds_made_for); });
  if (file.has(kMicro)) {
    content.micro =
        file.decode(kMicro, [&](ChunkReader& c) { return decode_micro(c, content.pyramid); });
  }
  if (file.has(kShell)) {
    content.shell =
        file.decode(kShell, [&](ChunkReader& c) { return decode_shell(c, content.pyramid); });
  }
  const auto take = [&](CountedGrid density) {
    content.density = std::move(density.grid);
    content.count = density.count;
  };
  if (file.has(kDensity)) {
    take(file.decode(kDensity, [&](ChunkReader& c) { return decode_density(c, content.pyramid); }));
  }
  if (file.has(kQuantised)) {
    take(file.decode(kQuantised, [&](ChunkReader& c) {
      return decode_quantised(c, content.pyramid, content.metadata);
    }));
  }
  if (!content.density && content.metadata.quantisation.precision != Precision::fp32) {
    refuse(name, "the metadata describe a quantised density, which is missing");
  }
  if (content.density) {
    if (const Owner& owner = file.owner(); owner != nullptr && content.density->owner == owner) {
      content.forget_pages = [owner] { owner->forget_pages(); };
    }
    content.density->name = content.metadata.grid_name;
    content.density->index_to_world = content.metadata.index_to_world;
  }
  return content;
}

std::string name_of(const Container& file) {
  return file.decode(kMeta, decode_metadata).metadata.grid_name;
}

struct NamedField {
  std::string name;
  Container file;
};

/// The fields of a file, each a file of its own.
std::vector<NamedField> fields_of(const Container& file) {
  std::vector<NamedField> fields;
  std::vector<std::string> names{name_of(file)};
  for (Container& field : file.fields()) {
    if (field.has(kField)) refuse(field.name(), "a field has fields itself");
    const std::string name = name_of(field);
    if (std::find(names.begin(), names.end(), name) != names.end()) {
      refuse(field.name(), "a second grid is called '" + name + "'");
    }
    names.push_back(name);
    fields.push_back({name, std::move(field)});
  }
  return fields;
}

/// f(), where running out of memory is the file's fault.
template <class F>
auto within_memory(const std::string& name, const F& f) {
  try {
    return f();
  } catch (const std::bad_alloc&) {
    throw Error(name + ": not enough memory for the content of the file.");
  }
}

PvolFile read_all(const Container& file, const std::string& name) {
  PvolFile content = read_grid(file, name);
  for (const NamedField& field : fields_of(file)) {
    content.fields.push_back(read_grid(field.file, field.file.name()));
  }
  return content;
}

/// The container of a file, which stays mapped as long as samples in it are used.
Container map_file(const fs::path& file) {
  const auto mapped = std::make_shared<const MappedFile>(file);
  return {mapped->bytes(), file.string(), mapped};
}

}  // namespace

PvolFile read_pvol(std::span<const std::byte> bytes, const std::string& name) {
  return within_memory(name, [&] { return read_all(Container(bytes, name), name); });
}

PvolFile read_pvol(const fs::path& file) {
  return within_memory(file.string(), [&] { return read_all(map_file(file), file.string()); });
}

PvolFile read_pvol_grid(const fs::path& path, const std::string& name) {
  return within_memory(path.string(), [&] {
    const Container file = map_file(path);
    const Metadata own = file.decode(kMeta, decode_metadata).metadata;
    // Also by the name that it had in the source.
    if (name.empty() || name == own.grid_name || name == own.source.grid) {
      return read_grid(file, path.string());
    }
    std::string names = '"' + own.grid_name + '"';
    for (const NamedField& field : fields_of(file)) {
      if (field.name == name) return read_grid(field.file, field.file.name());
      names += ", \"" + field.name + '"';
    }
    throw Error(path.string() + ": holds the grid " + names + ", not \"" + name +
                "\"; fit another file to that grid");
  });
}

std::vector<PvolGridName> list_pvol(const fs::path& path) {
  const MappedFile mapped(path);
  const Container file(mapped.bytes(), path.string());
  // By its header alone: every render asks, and bounds are decoded where they are used.
  const auto is_empty = [](const Container& c) {
    return c.decode(kBounds, [](ChunkReader& r) { return r.get<BoundsHeader>().levels == 0; });
  };
  std::vector<PvolGridName> all{{name_of(file), is_empty(file)}};
  for (const NamedField& field : fields_of(file)) {
    all.push_back({field.name, is_empty(field.file)});
  }
  return all;
}

PvolSizes measure_pvol(const fs::path& file) {
  const MappedFile mapped(file);
  return measure(Container(mapped.bytes(), file.string()).table());
}

FileHash hash_file(const fs::path& file) {
  const MappedFile mapped(file);
  return {checksum(mapped.bytes()), mapped.bytes().size()};
}

std::string read_pvol_head(const fs::path& file) {
  const MappedFile mapped(file);
  const Container checked(mapped.bytes(), file.string());
  const Bytes head = mapped.bytes().first(measure(checked.table()).header);
  return {reinterpret_cast<const char*>(head.data()), head.size()};
}

}  // namespace pvol::formats
