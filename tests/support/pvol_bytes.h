// .pvol files taken apart and put together again with right sums, for tests that forge them.
#pragma once

#include <xxhash.h>
#include <zstd.h>

#include <algorithm>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <optional>
#include <string>
#include <vector>

#include "pvol/pvol_chunks.h"

namespace pvol::test {

inline std::vector<std::byte> load(const std::filesystem::path& file) {
  std::vector<std::byte> bytes(std::filesystem::file_size(file));
  std::ifstream(file, std::ios::binary)
      .read(reinterpret_cast<char*>(bytes.data()), std::streamsize(bytes.size()));
  return bytes;
}

inline void save(const std::filesystem::path& file, const std::vector<std::byte>& bytes) {
  std::ofstream(file, std::ios::binary)
      .write(reinterpret_cast<const char*>(bytes.data()), std::streamsize(bytes.size()));
}

inline std::uint64_t xxh3(formats::detail::Bytes bytes) {
  return XXH3_64bits(bytes.data(), bytes.size());
}

inline std::vector<std::byte> zstd(formats::detail::Bytes raw) {
  std::vector<std::byte> packed(ZSTD_compressBound(raw.size()));
  packed.resize(ZSTD_compress(packed.data(), packed.size(), raw.data(), raw.size(), 1));
  return packed;
}

/// 32 bytes a line.
inline std::string hex(const std::vector<std::byte>& bytes) {
  std::string s;
  for (std::size_t i = 0; i < bytes.size(); ++i) {
    if (i % 32 == 0) s += '\n';
    s += "0123456789abcdef"[std::to_integer<unsigned>(bytes[i] >> 4)];
    s += "0123456789abcdef"[std::to_integer<unsigned>(bytes[i] & std::byte{15})];
  }
  return s;
}

struct PvolBytes {
  struct Chunk {
    formats::detail::ChunkEntry entry;  // offset, stored size and sum are made by `bytes`
    std::vector<std::byte> stored;
    std::optional<std::uint64_t> forged_offset, forged_stored;
  };
  formats::detail::FileHeader header;
  std::optional<std::uint32_t> forged_count;
  std::byte padding{0};
  std::vector<Chunk> chunks;

  explicit PvolBytes(const std::vector<std::byte>& file) {
    std::memcpy(&header, file.data(), sizeof header);
    for (std::size_t i = 0; i < header.chunks; ++i) {
      Chunk c;
      std::memcpy(&c.entry, file.data() + sizeof header + i * sizeof c.entry, sizeof c.entry);
      const auto start = file.begin() + std::ptrdiff_t(c.entry.offset);
      c.stored.assign(start, start + std::ptrdiff_t(c.entry.stored_bytes));
      chunks.push_back(c);
    }
  }

  /// The file with its sizes, offsets and sums made right, except where they are forged.
  [[nodiscard]] std::vector<std::byte> bytes() const {
    const std::size_t table_end = sizeof header + chunks.size() * sizeof(Chunk::entry);
    std::vector<std::byte> out(table_end);
    std::vector<formats::detail::ChunkEntry> table;
    for (const Chunk& c : chunks) {
      out.resize((out.size() + 63) / 64 * 64, padding);
      formats::detail::ChunkEntry e = c.entry;
      e.offset = c.forged_offset.value_or(out.size());
      e.stored_bytes = c.forged_stored.value_or(c.stored.size());
      e.checksum = xxh3(c.stored);
      table.push_back(e);
      out.insert(out.end(), c.stored.begin(), c.stored.end());
    }
    formats::detail::FileHeader h = header;
    h.file_bytes = out.size();
    h.chunks = forged_count.value_or(std::uint32_t(chunks.size()));
    h.checksum = 0;
    std::memcpy(out.data(), &h, sizeof h);
    if (!table.empty()) {
      std::memcpy(out.data() + sizeof h, table.data(), table.size() * sizeof table[0]);
    }
    h.checksum = xxh3(formats::detail::Bytes(out).first(table_end));
    std::memcpy(out.data(), &h, sizeof h);
    return out;
  }

  // Changes of chunks that are not compressed.
  void set(std::size_t chunk, std::vector<std::byte> raw) {
    chunks[chunk].stored = std::move(raw);
    chunks[chunk].entry.raw_bytes = chunks[chunk].stored.size();
  }
  template <class T>
  void put(std::size_t chunk, std::size_t at, T value) {
    std::memcpy(chunks[chunk].stored.data() + at, &value, sizeof value);
  }
  void replace_text(std::size_t chunk, const std::string& from, const std::string& to) {
    const std::vector<std::byte>& stored = chunks[chunk].stored;
    std::string s(reinterpret_cast<const char*>(stored.data()), stored.size());
    s.replace(s.find(from), from.size(), to);
    const formats::detail::Bytes raw = std::as_bytes(std::span(s));
    set(chunk, {raw.begin(), raw.end()});
  }
  void swap(std::size_t chunk, std::size_t a, std::size_t b, std::size_t n) {
    std::byte* data = chunks[chunk].stored.data();
    std::swap_ranges(data + a, data + a + n, data + b);
  }
  void copy(std::size_t chunk, std::size_t from, std::size_t to, std::size_t n) {
    std::byte* data = chunks[chunk].stored.data();
    std::memmove(data + to, data + from, n);
  }
  [[nodiscard]] std::size_t size(std::size_t chunk) const { return chunks[chunk].stored.size(); }

  // Offsets of the arrays in BNDS, the second chunk.
  [[nodiscard]] formats::detail::BoundsHeader bounds() const {
    formats::detail::BoundsHeader b;
    std::memcpy(&b, chunks[1].stored.data(), sizeof b);
    return b;
  }
  [[nodiscard]] std::size_t stops() const {
    return sizeof bounds() + 8 * std::size_t(bounds().upper + bounds().lower);
  }
  [[nodiscard]] std::size_t lows() const { return stops() + 8 * std::size_t(bounds().upper); }
  [[nodiscard]] std::size_t highs() const { return lows() + 2 * std::size_t(bounds().terminals); }
  [[nodiscard]] std::size_t groups() const { return highs() + 2 * std::size_t(bounds().terminals); }
};

}  // namespace pvol::test
