#include "cli/local_copies.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdlib>
#include <string>
#include <system_error>
#include <utility>

#include "pvol/error.h"
#include "pvol/formats/atomic_file.h"

namespace pvol::cli {
namespace {

namespace fs = std::filesystem;

constexpr const char* kRecord = ".origin";
/// Left free for others beside a copy.
constexpr std::uint64_t kSpare = std::uint64_t{64} << 20;

[[noreturn]] void fail(const fs::path& file, const std::string& what) {
  throw Error(file.string() + ": " + what);
}

std::string text_of(int error) { return std::generic_category().message(error); }

/// What changes with a file's contents, and cannot be set back by its owner.
std::string identity_of(const fs::path& file) {
  struct stat s = {};
  if (::stat(file.c_str(), &s) != 0) return "";
  return fmt::format("{} {} {}.{:09} {}.{:09}", s.st_ino, s.st_size, s.st_mtim.tv_sec,
                     s.st_mtim.tv_nsec, s.st_ctim.tv_sec, s.st_ctim.tv_nsec);
}

/// What a copy's record says of the file that it was made of and of the copy itself; "" for none.
std::string record_of(const std::string& file, const fs::path& copy) {
  const std::string own = identity_of(copy);
  return own.empty() ? "" : file + '\n' + own + '\n';
}

/// A folder that holds copies can be written by its user alone.
void check_owner(const fs::path& folder) {
  struct stat s = {};
  if (::lstat(folder.c_str(), &s) != 0) fail(folder, text_of(errno));
  const std::string wrong = S_ISLNK(s.st_mode)        ? "is a link"
                            : !S_ISDIR(s.st_mode)     ? "is no folder"
                            : s.st_uid != ::geteuid() ? fmt::format("belongs to user {}", s.st_uid)
                            : (s.st_mode & 022) != 0  ? "can be written by other users"
                                                      : "";
  if (!wrong.empty()) {
    fail(folder, wrong + ", expected a folder of this user's that no other can write");
  }
}

/// A record that is open, and locked until it is closed.
class Record {
 public:
  explicit Record(const fs::path& file) : file_(file) {}
  ~Record() { close(); }
  Record(const Record&) = delete;
  Record& operator=(const Record&) = delete;

  /// Opens it, creating it where it is missing, and waits for a lock (LOCK_SH or LOCK_EX).
  void lock(int kind) {
    for (;;) {
      close();
      fd_ = ::open(file_.c_str(), O_RDWR | O_CREAT | O_CLOEXEC | O_NOFOLLOW, 0600);
      if (fd_ < 0) fail(file_, text_of(errno));
      (void)::flock(fd_, kind);  // without locks nothing is removed
      struct stat s = {};
      if (::fstat(fd_, &s) == 0 && s.st_nlink > 0) return;  // else it was removed meanwhile
    }
  }
  [[nodiscard]] std::string read() const {
    std::string text(512, '\0');
    const ssize_t size = ::pread(fd_, text.data(), text.size(), 0);
    text.resize(std::size_t(std::max<ssize_t>(size, 0)));
    return text;
  }
  void write(const std::string& text) const {
    if (::ftruncate(fd_, 0) != 0 || ::pwrite(fd_, text.data(), text.size(), 0) < 0) {
      fail(file_, text_of(errno));
    }
  }
  /// Notes that it was used now.
  void touch() const { (void)::futimens(fd_, nullptr); }
  /// Keeps others from removing the copy, and lets them read it.
  void share() const { (void)::flock(fd_, LOCK_SH); }
  [[nodiscard]] int release() { return std::exchange(fd_, -1); }

 private:
  void close() {
    if (fd_ >= 0) ::close(std::exchange(fd_, -1));
  }
  fs::path file_;
  int fd_ = -1;
};

/// Records of copies, those first that were not used for longest.
std::vector<fs::path> records_by_age(const fs::path& folder) {
  std::vector<std::pair<fs::file_time_type, fs::path>> all;
  std::error_code failed;
  for (fs::recursive_directory_iterator at(folder, failed), end; !failed && at != end;
       at.increment(failed)) {
    if (at->path().extension() == kRecord)
      all.emplace_back(at->last_write_time(failed), at->path());
  }
  std::sort(all.begin(), all.end());
  std::vector<fs::path> records;
  for (auto& [time, path] : all) records.push_back(std::move(path));
  return records;
}

/// Removes a copy and its record, unless a process uses it.
void evict(const fs::path& record) {
  const int fd = ::open(record.c_str(), O_RDWR | O_CLOEXEC | O_NOFOLLOW);
  if (fd < 0) return;
  if (::flock(fd, LOCK_EX | LOCK_NB) == 0) {
    std::error_code ignored;
    fs::remove(fs::path(record).replace_extension(), ignored);
    fs::remove(record, ignored);
  }
  ::close(fd);
}

bool has_free(const fs::path& folder, std::uint64_t bytes) {
  std::error_code failed;
  const fs::space_info space = fs::space(folder, failed);
  return failed || space.available >= bytes;
}

void make_copy(const fs::path& folder, const fs::path& file, const fs::path& copy) {
  if (!make_room(folder, fs::file_size(file) + kSpare)) fail(folder, text_of(ENOSPC));
  formats::write_atomically(copy, [&](const fs::path& aside) {
    fs::copy_file(file, aside, fs::copy_options::overwrite_existing);
  });
}

}  // namespace

fs::path local_folder(const fs::path& given) {
  if (given != "auto") return given;
  fs::path base = "/tmp";
  for (const char* name : {"SLURM_TMPDIR", "TMPDIR"}) {
    const char* const value = std::getenv(name);
    if (value == nullptr || *value == 0) continue;
    base = value;
    break;
  }
  const char* const user = std::getenv("USER");
  return base / fmt::format("pvol-{}", user ? std::string(user) : std::to_string(getuid()));
}

bool make_room(const fs::path& folder, std::uint64_t bytes) {
  if (has_free(folder, bytes)) return true;
  for (const fs::path& record : records_by_age(folder)) {
    evict(record);
    if (has_free(folder, bytes)) return true;
  }
  return false;
}

LocalCopies::LocalCopies(fs::path folder) : folder_(std::move(folder)) {
  std::error_code failed;
  if (folder_.has_parent_path()) fs::create_directories(folder_.parent_path(), failed);
  if (::mkdir(folder_.c_str(), 0700) != 0 && errno != EEXIST) fail(folder_, text_of(errno));
  check_owner(folder_);
}

LocalCopies::~LocalCopies() {
  for (const int fd : locks_) ::close(fd);
}

fs::path LocalCopies::copy(const fs::path& file) {
  const fs::path copy = folder_ / fs::absolute(file).lexically_normal().relative_path();
  try {
    fs::create_directories(copy.parent_path());
    Record record(copy.string() + kRecord);
    const auto holds = [&] {
      const std::string expected = record_of(identity_of(file), copy);
      return !expected.empty() && record.read() == expected;
    };
    record.lock(LOCK_SH);
    if (!holds()) {
      record.lock(LOCK_EX);
      if (!holds()) {
        const std::string before = identity_of(file);
        make_copy(folder_, file, copy);
        // Of a file that changed meanwhile the record says what it was before: it does not hold.
        record.write(record_of(before, copy));
      }
      record.share();
    }
    record.touch();
    locks_.push_back(record.release());
  } catch (const fs::filesystem_error& e) {
    throw Error(fmt::format("{}: cannot be copied to {}: {}", file.string(), folder_.string(),
                            e.code().message()));
  }
  return copy;
}

}  // namespace pvol::cli
