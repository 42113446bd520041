#include "pvol/math/pages.h"

#include <new>

#if __has_include(<sys/mman.h>)
#include <sys/mman.h>
#endif

namespace pvol::detail {
namespace {

constexpr std::size_t kPage = std::size_t(2) << 20;

/// Smaller arrays would leave too much of their last page unused.
[[nodiscard]] bool is_large(std::size_t bytes) { return bytes >= kPage / 2; }

}  // namespace

void* allocate_pages(std::size_t bytes) {
  if (!is_large(bytes)) return ::operator new(bytes, std::align_val_t{64});
  const std::size_t whole = (bytes + kPage - 1) / kPage * kPage;
  void* const memory = ::operator new(whole, std::align_val_t{kPage});
#ifdef MADV_HUGEPAGE
  (void)madvise(memory, whole, MADV_HUGEPAGE);  // advice is all that it is
#endif
  return memory;
}

void free_pages(void* memory, std::size_t bytes) noexcept {
  ::operator delete(memory, std::align_val_t{is_large(bytes) ? kPage : 64});
}

}  // namespace pvol::detail
