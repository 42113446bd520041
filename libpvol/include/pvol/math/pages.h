// Memory in large pages, for arrays that are read all over: the processor finds them by a few
// translations of addresses instead of thousands.
#pragma once

#include <cstddef>
#include <new>
#include <utility>
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

/// The same, whose elements have no value before they are set, so that the threads that set them
/// are the first to touch their pages: systems clear pages then, which takes longer than the rest.
template <class T>
struct UnsetPageAllocator : PageAllocator<T> {
  template <class U>
  struct rebind {
    using other = UnsetPageAllocator<U>;
  };
  UnsetPageAllocator() = default;
  template <class U>
  explicit UnsetPageAllocator(const UnsetPageAllocator<U>&) {}

  template <class U>
  void construct(U* p) noexcept {
    ::new (static_cast<void*>(p)) U;
  }
  template <class U, class... Args>
  void construct(U* p, Args&&... args) {
    ::new (static_cast<void*>(p)) U(std::forward<Args>(args)...);
  }
};

template <class T>
using UnsetPagedVector = std::vector<T, UnsetPageAllocator<T>>;

}  // namespace pvol
