#include "mutate.h"

#include <algorithm>
#include <cstring>
#include <iterator>

namespace pvol::fuzz {
namespace {

constexpr std::size_t kLongestRun = 64;

/// Some place in the bytes; half of them near the start, where the structure of a file is.
std::size_t place(const Buffer& bytes, Rng& rng) {
  constexpr std::size_t kStart = 512;
  const bool early = below(2, rng) == 0;
  return below(early ? std::min(bytes.size(), kStart) : bytes.size(), rng);
}

std::size_t run(const Buffer& bytes, std::size_t at, Rng& rng) {
  return std::min(below(kLongestRun, rng) + 1, bytes.size() - at);
}

void flip_bits(Buffer& bytes, Rng& rng) {
  for (std::size_t n = below(4, rng) + 1; n > 0; --n) {
    bytes[place(bytes, rng)] ^= std::uint8_t(1u << below(8, rng));
  }
}

void fill(Buffer& bytes, Rng& rng) {
  const std::size_t at = place(bytes, rng);
  const std::uint8_t value = below(2, rng) ? 0xff : 0;
  std::fill_n(bytes.begin() + std::ptrdiff_t(at), run(bytes, at, rng), value);
}

/// A number of 1 to 8 bytes, as counts, sizes and offsets are, near a power of two or any.
void put_number(Buffer& bytes, Rng& rng) {
  std::uint64_t value = rng.block().lo >> below(64, rng);
  if (below(2, rng)) value = (std::uint64_t(1) << below(64, rng)) + below(3, rng) - 1;
  const std::size_t at = place(bytes, rng);
  const std::size_t size = std::min(std::size_t(1) << below(4, rng), bytes.size() - at);
  std::memcpy(bytes.data() + at, &value, size);
}

void erase(Buffer& bytes, Rng& rng) {
  const auto at = bytes.begin() + std::ptrdiff_t(place(bytes, rng));
  bytes.erase(at, at + std::ptrdiff_t(run(bytes, std::size_t(at - bytes.begin()), rng)));
}

/// Copies a run to another place, over what is there or between.
void repeat(Buffer& bytes, Rng& rng) {
  const std::size_t from = place(bytes, rng), to = place(bytes, rng);
  const auto start = bytes.begin() + std::ptrdiff_t(from);
  const Buffer copy(start, start + std::ptrdiff_t(run(bytes, from, rng)));
  const auto target = bytes.begin() + std::ptrdiff_t(to);
  if (below(2, rng)) {
    bytes.insert(target, copy.begin(), copy.end());
  } else {
    std::copy_n(copy.begin(), std::min(copy.size(), bytes.size() - to), target);
  }
}

void go_on_as(const Buffer& other, Buffer& bytes, Rng& rng) {
  const std::size_t at = place(bytes, rng);
  if (other.size() <= at) return;
  bytes.resize(at);
  bytes.insert(bytes.end(), other.begin() + std::ptrdiff_t(at), other.end());
}

}  // namespace

std::size_t below(std::size_t end, Rng& rng) { return std::size_t(rng.block().lo % end); }

Buffer mutate(Buffer bytes, const Buffer& other, Rng& rng) {
  for (std::size_t n = below(3, rng) + 1; n > 0 && !bytes.empty(); --n) {
    switch (below(8, rng)) {
      case 0:
        bytes.resize(below(bytes.size(), rng));
        break;
      case 1:
        fill(bytes, rng);
        break;
      case 2:
      case 3:
        put_number(bytes, rng);
        break;
      case 4:
        erase(bytes, rng);
        break;
      case 5:
        repeat(bytes, rng);
        break;
      case 6:
        go_on_as(other, bytes, rng);
        break;
      default:
        flip_bits(bytes, rng);
    }
  }
  return bytes;
}

}  // namespace pvol::fuzz
