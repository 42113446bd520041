// Checked reading of binary files: no read goes past the end, no length is believed before it is
// compared with the bytes that are left.
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <string>
#include <type_traits>
#include <vector>

namespace pvol::formats::detail {

/// Bytes [begin, end) of a file.
struct ByteRange {
  std::uint64_t begin = 0, end = 0;
  [[nodiscard]] std::uint64_t size() const { return end - begin; }
};

/// A regular file, read through a window that slides: one pass over a large file costs one
/// megabyte. Throws Error where the file cannot be opened or read.
class ByteSource {
 public:
  explicit ByteSource(std::filesystem::path file);
  ~ByteSource();
  ByteSource(const ByteSource&) = delete;
  ByteSource& operator=(const ByteSource&) = delete;

  [[nodiscard]] const std::filesystem::path& file() const { return file_; }
  [[nodiscard]] std::uint64_t size() const { return size_; }

  static constexpr std::size_t kWindow = std::size_t(1) << 20;

  /// `count` <= kWindow bytes at `position`, all of them inside the file; valid until the next
  /// call.
  const char* at(std::uint64_t position, std::size_t count);

  /// Copies any number of bytes, all of them inside the file.
  void copy(std::uint64_t position, std::uint64_t count, char* to);

 private:
  void read(std::uint64_t position, std::size_t count, char* to) const;

  std::filesystem::path file_;
  int descriptor_ = -1;
  std::uint64_t size_ = 0;
  std::vector<char> window_;
  ByteRange held_;  // what `window_` holds
};

/// Reads forward through a range of a file. Whatever does not fit into the range throws Error that
/// says the file is damaged or cut off, and where.
class ByteCursor {
 public:
  /// `place` is for messages, e.g. "the header" or "grid 'density'".
  ByteCursor(ByteSource& source, ByteRange range, std::string place)
      : source_(&source), range_(range), place_(std::move(place)) {}

  [[nodiscard]] std::uint64_t position() const { return range_.begin; }
  [[nodiscard]] std::uint64_t left() const { return range_.size(); }
  void set_place(std::string place) { place_ = std::move(place); }

  void skip(std::uint64_t count) {
    need(count);
    range_.begin += count;
  }

  /// `count` <= ByteSource::kWindow bytes, valid until the next call.
  const char* bytes(std::size_t count) {
    need(count);
    const char* b = source_->at(range_.begin, count);
    range_.begin += count;
    return b;
  }

  /// Copies any number of bytes.
  void copy(char* to, std::uint64_t count) {
    need(count);
    source_->copy(range_.begin, count, to);
    range_.begin += count;
  }

  /// The next sizeof(T) bytes as a little-endian number.
  template <class T>
  T value() {
    static_assert(std::is_arithmetic_v<T>);
    T v;
    std::memcpy(&v, bytes(sizeof(T)), sizeof(T));
    return v;
  }

  /// A 32-bit length and that many bytes.
  std::string string();

  /// Throws Error: "<file>: <place>, byte <position>: <found>".
  [[noreturn]] void fail(const std::string& found) const;

 private:
  void need(std::uint64_t count) const;

  ByteSource* source_;
  ByteRange range_;  // what is still to be read
  std::string place_;
};

}  // namespace pvol::formats::detail
