#include "largest_block.h"

#include <atomic>
#include <cstdlib>
#include <new>

namespace {

std::atomic<std::size_t> largest = 0;

}  // namespace

std::size_t pvol::fuzz::take_largest_block() { return ::largest.exchange(0); }

// These stand in for the standard library's, in shared libraries, too. std::stable_sort asks for
// its room without exceptions, and gives it back as any other.

void* operator new(std::size_t size, const std::nothrow_t&) noexcept {
  std::size_t seen = largest;
  while (seen < size && !largest.compare_exchange_weak(seen, size)) {
  }
  return std::malloc(size > 0 ? size : 1);
}

void* operator new(std::size_t size) {
  if (void* block = operator new(size, std::nothrow)) return block;
  throw std::bad_alloc();
}

void operator delete(void* block) noexcept { std::free(block); }

void operator delete(void* block, std::size_t) noexcept { std::free(block); }
