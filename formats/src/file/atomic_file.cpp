// Writing aside, syncing and renaming, as POSIX promises it: a rename replaces a file in one step.
#include "pvol/formats/atomic_file.h"

#include <fmt/format.h>

#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <fstream>
#include <mutex>
#include <string>
#include <string_view>
#include <system_error>
#include <utility>

#include "pvol/error.h"

namespace pvol::formats {
namespace {

namespace fs = std::filesystem;

[[noreturn]] void fail(const std::string& what, const fs::path& file) {
  throw Error(file.string() + ": " + what + " (" + std::generic_category().message(errno) +
              "). Check that the folder exists and is writable, and that there is space.");
}

/// What a link points to that points to nothing yet; any other name as it is.
fs::path follow(fs::path file) {
  constexpr int kMostLinks = 40;  // as the system follows
  const fs::path given = file;
  std::error_code failed;
  for (int i = 0; fs::is_symlink(fs::symlink_status(file, failed)); ++i) {
    const fs::path to = fs::read_symlink(file, failed);
    if (failed || i == kMostLinks) {
      throw Error(given.string() + ": cannot be written: its links lead nowhere.");
    }
    file = file.parent_path() / to;  // which is `to` where that is absolute
  }
  return file;
}

/// The file to replace: where `file` is a link, what it points to. Devices, pipes and folders are
/// refused, since a rename would put a plain file in their place.
fs::path resolve(const fs::path& file) {
  std::error_code absent;
  const fs::file_status status = fs::status(file, absent);
  if (!fs::exists(status)) return follow(file);
  if (!fs::is_regular_file(status)) {
    throw Error(file.string() +
                ": cannot be written: it is a folder or a device, expected a file.");
  }
  return fs::canonical(file);
}

/// A file that is open and locked as long as this lives. A lock ends with its process, however that
/// ends: files beside without one are litter of the killed.
class LockedFile {
 public:
  explicit LockedFile(int descriptor) : descriptor_(descriptor) {}
  LockedFile(LockedFile&& o) noexcept : descriptor_(std::exchange(o.descriptor_, -1)) {}
  LockedFile& operator=(LockedFile&&) = delete;
  ~LockedFile() {
    if (descriptor_ >= 0) ::close(descriptor_);
  }
  [[nodiscard]] bool gone() const {
    struct stat info = {};
    return ::fstat(descriptor_, &info) == 0 && info.st_nlink == 0;
  }

 private:
  int descriptor_;
};

/// A file beside its target for as long as this lives, among those of the process: whoever ends it
/// can remove them.
class Aside {
 public:
  explicit Aside(const fs::path& path) : path_(path) {
    const std::scoped_lock lock(mutex_);
    next_ = std::exchange(all_, this);
  }
  ~Aside() {
    const std::scoped_lock lock(mutex_);
    Aside** link = &all_;
    while (*link != this) link = &(*link)->next_;
    *link = next_;
  }
  Aside(const Aside&) = delete;
  Aside& operator=(const Aside&) = delete;

  static void remove_all() {
    const std::scoped_lock lock(mutex_);
    for (const Aside* a = all_; a != nullptr; a = a->next_) ::unlink(a->path_.c_str());
  }

 private:
  static inline std::mutex mutex_;
  static inline Aside* all_ = nullptr;
  const fs::path& path_;
  Aside* next_;
};

constexpr const char* kAside = ".tmp-";

/// With what the names of files beside a target begin: its own, as far as there is room for more.
std::string start_of_asides(const fs::path& target) {
  constexpr std::size_t kMostAside = 200;  // of the 255 bytes that names have
  return target.filename().string().substr(0, kMostAside) + kAside;
}

/// Whether a file beside the target has a name that `create` gives: NAME.tmp-PROCESS-NUMBER.
bool is_aside(const std::string& name, const std::string& start) {
  if (!name.starts_with(start)) return false;
  const std::string_view rest = std::string_view(name).substr(start.size());
  const std::size_t dash = rest.find('-');
  const auto digits = [](std::string_view s) {
    return !s.empty() && s.find_first_not_of("0123456789") == std::string_view::npos;
  };
  return dash != std::string_view::npos && digits(rest.substr(0, dash)) &&
         digits(rest.substr(dash + 1));
}

/// Removes what writers of the same file left behind when they were killed.
void remove_litter(const fs::path& target) {
  const fs::path folder = target.has_parent_path() ? target.parent_path() : fs::path(".");
  const std::string start = start_of_asides(target);
  std::error_code failed, ignored;
  for (fs::directory_iterator at(folder, failed), end; !failed && at != end; at.increment(failed)) {
    if (!is_aside(at->path().filename().string(), start)) continue;
    const int fd = ::open(at->path().c_str(), O_RDONLY | O_CLOEXEC | O_NOFOLLOW | O_NONBLOCK);
    if (fd < 0) continue;
    const LockedFile file(fd);
    struct stat info = {};
    const bool plain = ::fstat(fd, &info) == 0 && S_ISREG(info.st_mode);
    if (plain && ::flock(fd, LOCK_EX | LOCK_NB) == 0) fs::remove(at->path(), ignored);
  }
}

/// A new, empty and locked file beside the target, under a name that no other writer has.
LockedFile create(const fs::path& target, fs::path& aside) {
  static std::atomic<int> number = 0;
  for (;;) {
    aside = target.parent_path() /
            fmt::format("{}{}-{}", start_of_asides(target), ::getpid(), ++number);
    const int fd =
        ::open(aside.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC | O_NOFOLLOW, 0666);
    if (fd < 0 && errno == EEXIST) continue;
    if (fd < 0) fail("cannot be created", aside);
    LockedFile file(fd);
    (void)::flock(fd, LOCK_EX);     // file systems without locks have no litter removed
    if (!file.gone()) return file;  // else another took it for litter before it was locked
  }
}

/// Gives a file that is to replace another the mode and, where it may, the group of that one.
void take_over_access(const fs::path& target, const fs::path& aside) {
  struct stat before = {}, now = {};
  if (::stat(target.c_str(), &before) != 0 || ::stat(aside.c_str(), &now) != 0) return;
  mode_t mode = before.st_mode & 0777;
  if (before.st_gid != now.st_gid && ::chown(aside.c_str(), uid_t(-1), before.st_gid) != 0) {
    mode &= ~mode_t(070) | (now.st_mode & 0070);  // what one group may do is not for another
  }
  (void)::chmod(aside.c_str(), mode);
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
  remove_litter(target);
  fs::path aside;
  const LockedFile lock = create(target, aside);
  const Aside listed(aside);
  try {
    write(aside);
    sync(aside, O_RDONLY);
    take_over_access(target, aside);
    if (::rename(aside.c_str(), target.c_str()) != 0) fail("cannot be renamed into place", aside);
  } catch (...) {
    std::error_code ignored;
    fs::remove(aside, ignored);
    throw;
  }
  sync(target.has_parent_path() ? target.parent_path() : fs::path("."), O_RDONLY | O_DIRECTORY);
}

void write_text_atomically(const fs::path& file, const std::string& text) {
  write_atomically(file, [&](const fs::path& aside) {
    std::ofstream out(aside, std::ios::binary);
    out << text;
    out.close();
    if (!out) throw Error(file.string() + ": cannot be written; check that the disk is not full");
  });
}

void abandon_writes() noexcept { Aside::remove_all(); }

}  // namespace pvol::formats
