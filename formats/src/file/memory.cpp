#include "pvol/formats/memory.h"

#include <fmt/format.h>
#include <sys/resource.h>
#include <sys/sysinfo.h>
#include <unistd.h>

#include <fstream>
#include <optional>

#include "pvol/error.h"

namespace pvol::formats {
namespace {

/// What the process may take at most, in bytes.
struct MemoryLimit {
  std::uint64_t most = 0;  ///< in all
  std::uint64_t left = 0;  ///< beside what it has taken
  bool set = false;        ///< by a limit of the address space; else it is what the machine has
};

/// Bytes of address space that the process has, and of them those in memory.
struct Taken {
  std::uint64_t space = 0, resident = 0;
};

Taken taken() {
  Taken t;
  std::ifstream("/proc/self/statm") >> t.space >> t.resident;
  const auto page = std::uint64_t(::sysconf(_SC_PAGESIZE));
  return {t.space * page, t.resident * page};
}

std::uint64_t less(std::uint64_t a, std::uint64_t b) { return a > b ? a - b : 0; }

std::string megabytes(std::uint64_t bytes) {
  return fmt::format("{} MB", (bytes + 999999) / 1000000);
}

/// Nothing where neither a limit nor the machine's memory is known.
std::optional<MemoryLimit> memory_limit() {
  const Taken now = taken();
  rlimit limit{};
  if (::getrlimit(RLIMIT_AS, &limit) == 0 && limit.rlim_cur != RLIM_INFINITY) {
    return MemoryLimit{limit.rlim_cur, less(limit.rlim_cur, now.space), true};
  }
  struct sysinfo info = {};
  if (::sysinfo(&info) != 0) return std::nullopt;
  const std::uint64_t all = (std::uint64_t(info.totalram) + info.totalswap) * info.mem_unit;
  return MemoryLimit{all, less(all, now.resident), false};
}

}  // namespace

void require_memory(std::uint64_t bytes, const std::string& what) {
  const std::optional<MemoryLimit> limit = memory_limit();
  if (!limit || bytes <= limit->left) return;
  throw Error(fmt::format("{} needs {} of memory, but of {} only {} are left; {}", what,
                          megabytes(bytes), megabytes(limit->most), megabytes(limit->left),
                          limit->set ? "raise the limit (--memory-limit, ulimit -v)"
                                     : "use a machine with more memory"));
}

}  // namespace pvol::formats
