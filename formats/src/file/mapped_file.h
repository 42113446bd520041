// The bytes of a file, mapped for reading.
#pragma once

#include <cstddef>
#include <filesystem>
#include <span>

namespace pvol::formats::detail {

/// Must not be truncated while it is there: the system then ends the process with SIGBUS. Throws
/// Error for what is no file or cannot be read.
class MappedFile {
 public:
  explicit MappedFile(const std::filesystem::path& file);
  ~MappedFile();
  MappedFile(const MappedFile&) = delete;
  MappedFile& operator=(const MappedFile&) = delete;

  [[nodiscard]] std::span<const std::byte> bytes() const { return bytes_; }

  /// Gives back the memory of all pages; the system reads again what is used again.
  void forget_pages() const;

 private:
  std::span<const std::byte> bytes_;
};

}  // namespace pvol::formats::detail
