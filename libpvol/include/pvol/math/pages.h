// Memory in large pages, for arrays that are read all over: the processor finds them by a few
// translations of addresses instead of thousands.
#pragma once

#include <cstddef>
#include <vector>

namespace pvol {

namespace detail {
/// Memory for `bytes` bytes, aligned to 64 or more: in pages of 2 MiB where there are enough of
/// them and the system has such pages. Throws std::bad_alloc.
[[nodiscard]] void* allocate_pages(std::size_t bytes);
void free_pages(void* memory, std::size_t bytes) noexcept;
}  // namespace detail

/// An allocator of such memory.
template <class T>
struct PageAllocator {
  using value_type = T;

  PageAllocator() = default;
  template <class U>
  explicit PageAllocator(const PageAllocator<U>&) {}

  [[nodiscard]] T* allocate(std::size_t n) {
    return static_cast<T*>(detail::allocate_pages(n * sizeof(T)));
  }
  void deallocate(T* p, std::size_t n) noexcept { detail::free_pages(p, n * sizeof(T)); }
  friend bool operator==(const PageAllocator&, const PageAllocator&) { return true; }
};

template <class T>
using PagedVector = std::vector<T, PageAllocator<T>>;

}  // namespace pvol
