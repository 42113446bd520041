// The word that somebody meant.
#pragma once

#include <optional>
#include <span>
#include <string_view>

namespace pvol {

/// The one of the words that takes the fewest edits (characters put in, left out or replaced) to
/// become `found`; the first of several. None where it takes more than two, or more than half of
/// the characters found. Based on: Levenshtein. Binary codes capable of correcting deletions,
/// insertions and reversals. 1966.
[[nodiscard]] std::optional<std::string_view> nearest_word(std::string_view found,
                                                           std::span<const std::string_view> words);

}  // namespace pvol
