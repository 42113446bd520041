#include "file/mapped_file.h"

#include <fcntl.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <system_error>

#include "file/require_regular.h"
#include "pvol/error.h"

namespace pvol::formats::detail {
namespace {

[[noreturn]] void fail(const std::filesystem::path& file) {
  const char* limit =
      errno == ENOMEM ? "; all of a file counts for --memory-limit and ulimit -v: raise the limit"
                      : ".";
  throw Error(file.string() + ": cannot be read (" + std::generic_category().message(errno) + ")" +
              limit);
}

}  // namespace

MappedFile::MappedFile(const std::filesystem::path& file) {
  // Without O_NONBLOCK a pipe would keep its reader waiting.
  const int fd = ::open(file.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK);
  if (fd < 0) fail(file);
  struct stat info {};
  const bool is_file = ::fstat(fd, &info) == 0 && S_ISREG(info.st_mode);
  if (is_file && info.st_size > 0) {
    void* at = ::mmap(nullptr, std::size_t(info.st_size), PROT_READ, MAP_PRIVATE, fd, 0);
    if (at != MAP_FAILED) bytes_ = {static_cast<const std::byte*>(at), std::size_t(info.st_size)};
  }
  ::close(fd);
  if (!is_file) require_regular(file, info.st_mode);
  if (info.st_size > 0 && bytes_.empty()) fail(file);
}

MappedFile::~MappedFile() {
  if (!bytes_.empty()) ::munmap(const_cast<std::byte*>(bytes_.data()), bytes_.size());
}

void MappedFile::forget_pages() const {
  if (bytes_.empty()) return;
  ::madvise(const_cast<std::byte*>(bytes_.data()), bytes_.size(), MADV_DONTNEED);
}

}  // namespace pvol::formats::detail
