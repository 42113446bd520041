// Writing aside, syncing and renaming, as POSIX promises it: a rename replaces a file in one step.
#include "pvol/formats/atomic_file.h"

#include <fmt/format.h>

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <string>
#include <system_error>

#include "pvol/error.h"

namespace pvol::formats {
namespace {

namespace fs = std::filesystem;

[[noreturn]] void fail(const std::string& what, const fs::path& file) {
  throw Error(file.string() + ": " + what + " (" + std::generic_category().message(errno) +
              "). Check that the folder exists, that it can be written and that there is space.");
}

/// The file to replace: where `file` is a link, what it points to. Devices, pipes and folders are
/// refused, since a rename would put a plain file in their place.
fs::path resolve(const fs::path& file) {
  std::error_code absent;
  const fs::file_status status = fs::status(file, absent);
  if (!fs::exists(status)) return file;
  if (!fs::is_regular_file(status)) {
    throw Error(file.string() + ": cannot be written: it is a folder or a device, not a file.");
  }
  return fs::canonical(file);
}

void create(const fs::path& file) {
  const int fd = ::open(file.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC | O_NOFOLLOW, 0666);
  if (fd < 0) fail("cannot be created", file);
  ::close(fd);
}

/// Waits until a file or a folder's entries are on the disk.
void sync(const fs::path& path, int flags) {
  const int fd = ::open(path.c_str(), flags | O_CLOEXEC);
  if (fd < 0) fail("cannot be opened for syncing", path);
  const int result = ::fsync(fd);
  // Some file systems cannot sync a folder and say so; their rename is as safe as they make it.
  const bool failed = result != 0 && errno != EINVAL && errno != EROFS;
  const int saved = errno;
  ::close(fd);
  errno = saved;
  if (failed) fail("cannot be synced to the disk", path);
}

}  // namespace

void write_atomically(const fs::path& file, const std::function<void(const fs::path&)>& write) {
  const fs::path target = resolve(file);
  fs::path aside = target;
  aside += fmt::format(".tmp-{}", ::getpid());
  create(aside);
  try {
    write(aside);
    sync(aside, O_RDONLY);
    if (::rename(aside.c_str(), target.c_str()) != 0) fail("cannot be renamed into place", aside);
  } catch (...) {
    std::error_code ignored;
    fs::remove(aside, ignored);
    throw;
  }
  sync(target.has_parent_path() ? target.parent_path() : fs::path("."), O_RDONLY | O_DIRECTORY);
}

}  // namespace pvol::formats
