#include "cli/root_folder.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <linux/landlock.h>
#include <sys/prctl.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdint>
#include <cstring>

#include "pvol/error.h"
#include "pvol/formats/vdb.h"

namespace pvol::cli {
namespace {

namespace fs = std::filesystem;

// What a rule may allow, by version of Landlock; headers of older kernels lack the last two.
constexpr std::uint64_t kReadFile = LANDLOCK_ACCESS_FS_READ_FILE;
constexpr std::uint64_t kRead = kReadFile | LANDLOCK_ACCESS_FS_READ_DIR;
constexpr std::uint64_t kFirst = (1ULL << 13) - 1;    // reading, writing, making, removing, running
constexpr std::uint64_t kMoveSince2 = 1ULL << 13;     // from one folder to another
constexpr std::uint64_t kShortenSince3 = 1ULL << 14;  // of files
constexpr std::uint64_t kRun = LANDLOCK_ACCESS_FS_EXECUTE;

[[noreturn]] void refuse(const char* what) {
  throw Error(
      fmt::format("--root needs Landlock, which this kernel does not offer ({}: {}); use Linux "
                  "5.13 or later with 'landlock' in /sys/kernel/security/lsm",
                  what, std::strerror(errno)));
}

/// A set of rules, which end with it unless they were put into force.
class Rules {
 public:
  explicit Rules(std::uint64_t handled) {
    const landlock_ruleset_attr attributes{.handled_access_fs = handled};
    fd_ = int(syscall(SYS_landlock_create_ruleset, &attributes, sizeof attributes, 0));
    if (fd_ < 0) refuse("landlock_create_ruleset");
  }
  ~Rules() { ::close(fd_); }
  Rules(const Rules&) = delete;
  Rules& operator=(const Rules&) = delete;

  /// Whether the file or folder is there, and all below it may be used so.
  [[nodiscard]] bool allow(const fs::path& path, std::uint64_t access) const {
    const int at = ::open(path.c_str(), O_PATH | O_CLOEXEC);
    if (at < 0) return false;
    const landlock_path_beneath_attr rule{.allowed_access = access, .parent_fd = at};
    const long added = syscall(SYS_landlock_add_rule, fd_, LANDLOCK_RULE_PATH_BENEATH, &rule, 0);
    ::close(at);
    return added == 0;
  }

  void enforce() const {
    if (prctl(PR_SET_NO_NEW_PRIVS, 1, 0, 0, 0) != 0) refuse("prctl");
    if (syscall(SYS_landlock_restrict_self, fd_, 0) != 0) refuse("landlock_restrict_self");
  }

 private:
  int fd_;
};

fs::path& folder_now() {  // beside the kernel's own rules, which hold for the process too
  static fs::path folder;
  return folder;
}

}  // namespace

void keep_below(const fs::path& folder) {
  std::error_code failure;
  const fs::path root = fs::canonical(folder, failure);
  if (failure || !fs::is_directory(root)) {
    throw Error(fmt::format("--root {}: there is no such folder", folder.string()));
  }
  const long version =
      syscall(SYS_landlock_create_ruleset, nullptr, 0, LANDLOCK_CREATE_RULESET_VERSION);
  if (version < 1) refuse("landlock_create_ruleset");
  const std::uint64_t all =
      kFirst | (version >= 2 ? kMoveSince2 : 0) | (version >= 3 ? kShortenSince3 : 0);
  const Rules rules(all);
  if (!rules.allow(root, all)) throw Error(fmt::format("--root {}: cannot be read", root.string()));
  // Libraries that are loaded later.
  for (const char* libraries : {"/usr", "/lib", "/lib64", "/bin"}) {
    (void)rules.allow(libraries, kRead | kRun);
  }
  if (const auto module = formats::vdb_module_folder()) (void)rules.allow(*module, kRead | kRun);
  for (const char* facts : {"/proc/meminfo", "/proc/self/statm"})
    (void)rules.allow(facts, kReadFile);
  (void)rules.allow("/sys/devices/system", kRead);
  for (const char* device : {"/dev/null", "/dev/tty", "/dev/urandom"}) {
    (void)rules.allow(device, kReadFile | LANDLOCK_ACCESS_FS_WRITE_FILE);
  }
  rules.enforce();
  folder_now() = root;
}

const fs::path& kept_below() { return folder_now(); }

bool is_kept(const fs::path& file) {
  const fs::path& root = kept_below();
  if (root.empty()) return true;
  const fs::path place = fs::weakly_canonical(fs::absolute(file));
  return std::mismatch(root.begin(), root.end(), place.begin(), place.end()).first == root.end();
}

}  // namespace pvol::cli
