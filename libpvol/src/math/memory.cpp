#include "math/memory.h"

#include <fstream>
#include <limits>

#if __has_include(<sys/resource.h>) && __has_include(<unistd.h>)
#include <sys/resource.h>
#include <unistd.h>
#endif

#include "math/digits.h"

namespace pvol::detail {
namespace {

constexpr std::uint64_t kUnknown = std::numeric_limits<std::uint64_t>::max();

/// Of the limit of the address space.
std::uint64_t free_space() {
#ifdef RLIMIT_AS
  rlimit limit{};
  if (::getrlimit(RLIMIT_AS, &limit) != 0 || limit.rlim_cur == RLIM_INFINITY) return kUnknown;
  std::uint64_t pages = 0;
  std::ifstream("/proc/self/statm") >> pages;
  const std::uint64_t taken = pages * std::uint64_t(::sysconf(_SC_PAGESIZE));
  return limit.rlim_cur > taken ? limit.rlim_cur - taken : 0;
#else
  return kUnknown;
#endif
}

/// Of the machine's memory, what others leave.
std::uint64_t available() {
  std::ifstream lines("/proc/meminfo");
  std::string name, unit;
  std::uint64_t size = 0, sum = 0;
  bool known = false;
  while (lines >> name >> size && std::getline(lines, unit)) {
    if (name != "MemAvailable:" && name != "SwapFree:") continue;
    known = known || name == "MemAvailable:";
    sum += size * 1024;
  }
  return known ? sum : kUnknown;
}

}  // namespace

std::uint64_t free_memory() {
  const std::uint64_t space = free_space();
  return space != kUnknown ? space : available();
}

void refuse_memory(const std::string& what, double bytes, std::uint64_t free) {
  throw NoMemory(what + " needs at least " + digits(bytes / 1e9, 3) + " GB of memory, but only " +
                 digits(double(free) / 1e9, 3) +
                 " GB are free; use a part of it, larger voxels, or a machine with more memory");
}

}  // namespace pvol::detail
