// Damage to files, the same on every machine.
#pragma once

#include <cstdint>
#include <vector>

#include "pvol/math/rng.h"

namespace pvol::fuzz {

using Buffer = std::vector<std::uint8_t>;

/// Some number below `end`, which is above 0.
[[nodiscard]] std::size_t below(std::size_t end, Rng& rng);

/// Changes a file a little: flips bits, cuts it, overwrites a run with zeros, ones or a large
/// number, moves, erases or repeats a run, or goes on as another file does.
[[nodiscard]] Buffer mutate(Buffer bytes, const Buffer& other, Rng& rng);

}  // namespace pvol::fuzz
