// The body of the random numbers of pvol/math/rng.h. Sources that draw them in earnest include it
// to have it in place; others call the one in rng.cpp.
#pragma once

#include "pvol/math/rng.h"

namespace pvol {

template <int kRounds>
[[gnu::always_inline]] inline typename PhiloxOf<kRounds>::Block PhiloxOf<kRounds>::block(
    std::uint64_t key, Block counter) {
  __extension__ using Product = unsigned __int128;
  for (int round = 0; round < kRounds; ++round) {
    const Product p = static_cast<Product>(counter.lo) * 0xd2b74407b1ce6e93u;  // paper, table 2
    counter = {static_cast<std::uint64_t>(p >> 64) ^ key ^ counter.hi,
               static_cast<std::uint64_t>(p)};
    key += 0x9e3779b97f4a7c15u;  // golden ratio, the paper's Weyl key schedule
  }
  return counter;
}

}  // namespace pvol
