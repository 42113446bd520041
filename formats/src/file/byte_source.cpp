#include "file/byte_source.h"

#include <fmt/format.h>

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>

#include "file/require_regular.h"
#include "pvol/error.h"

namespace pvol::formats::detail {

namespace {

// Names of grids, types and metadata are short; a longer one is a damaged length.
constexpr std::uint32_t kLongestString = 1u << 16;

}  // namespace

ByteSource::ByteSource(std::filesystem::path file) : file_(std::move(file)) {
  // Without O_NONBLOCK, opening a pipe would wait for a writer.
  descriptor_ = ::open(file_.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK);
  if (descriptor_ < 0) {
    throw Error("cannot open " + file_.string() + ": " + std::strerror(errno));
  }
  struct stat info = {};
  if (::fstat(descriptor_, &info) != 0 || !S_ISREG(info.st_mode)) {
    ::close(descriptor_);
    require_regular(file_, info.st_mode);
  }
  size_ = std::uint64_t(info.st_size);
}

ByteSource::~ByteSource() { ::close(descriptor_); }

void ByteSource::read(std::uint64_t position, std::size_t count, char* to) const {
  while (count > 0) {
    const ssize_t got = ::pread(descriptor_, to, count, off_t(position));
    if (got < 0 && errno == EINTR) continue;
    if (got <= 0) {
      throw Error(fmt::format(
          "cannot read {} at byte {}: {}", file_.string(), position,
          (got < 0 ? std::strerror(errno) : "the file was truncated while it was read")));
    }
    to += got;
    position += std::uint64_t(got);
    count -= std::size_t(got);
  }
}

const char* ByteSource::at(std::uint64_t position, std::size_t count) {
  if (position < held_.begin || position + count > held_.end) {
    const std::uint64_t rest = size_ - position;
    const std::size_t fill = std::size_t(std::min<std::uint64_t>(kWindow, rest));
    window_.resize(std::size_t(std::min<std::uint64_t>(kWindow, size_)));
    held_ = {};
    read(position, fill, window_.data());
    held_ = {position, position + fill};
  }
  return window_.data() + (position - held_.begin);
}

void ByteSource::copy(std::uint64_t position, std::uint64_t count, char* to) {
  read(position, std::size_t(count), to);
}

std::string ByteCursor::string() {
  const std::uint32_t length = value<std::uint32_t>();
  if (length > kLongestString) {
    fail(fmt::format("a name of {} bytes; the file is damaged", length));
  }
  const char* b = bytes(length);
  return {b, length};
}

void ByteCursor::need(std::uint64_t count) const {
  if (count <= left()) return;
  fail(fmt::format("needs {} more bytes, but only {} are left; the file is damaged or cut off",
                   count, left()));
}

void ByteCursor::fail(const std::string& found) const {
  throw Error(
      fmt::format("{}: {}, byte {}: {}", source_->file().string(), place_, position(), found));
}

}  // namespace pvol::formats::detail
