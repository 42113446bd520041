// How much a statistical test draws, and from which random numbers: set for a whole run by
// main.cpp's environment variables.
#pragma once

#include <concepts>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <string_view>

namespace pvol::proof {

/// The environment variable that asks for all samples: PVOL_TEST_SAMPLES=all, as tests/nightly sets
/// it.
inline constexpr const char* kSamplesVariable = "PVOL_TEST_SAMPLES";
/// The environment variable that shifts the seeds of all statistical tests: a number, 0 unless set.
inline constexpr const char* kSeedVariable = "PVOL_TEST_SEED";

/// Whether this is a run with all samples and all inputs.
[[nodiscard]] inline bool runs_all() {
  static const char* const wanted = std::getenv(kSamplesVariable);
  return wanted != nullptr && std::string_view(wanted) == "all";
}

/// The samples of a statistical test: `all` of them in tests/nightly, which finds an error of 1 %,
/// and on each commit a quarter, which finds one of 2 %, or 1 / `parts` where fewer find that. Not
/// for tests that compare bytes or counts.
template <std::integral T>
[[nodiscard]] T samples(T all, T parts = 4) {
  return runs_all() ? all : T((all + parts - 1) / parts);
}

/// Whether the input of this number, of many that are alike, has its turn: every `of`-th on each
/// commit, all in tests/nightly.
[[nodiscard]] inline bool has_turn(std::size_t number, std::size_t of = 2) {
  return runs_all() || number % of == 0;
}

/// The seed to use where a statistical test names `seed`: that one, or in a run with new random
/// numbers another.
[[nodiscard]] inline std::uint64_t seeded(std::uint64_t seed) {
  static const char* const shift = std::getenv(kSeedVariable);
  return shift == nullptr ? seed : seed + (std::strtoull(shift, nullptr, 10) << 40);
}

}  // namespace pvol::proof
