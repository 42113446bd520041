#include "pvol/math/nearest_word.h"

#include <algorithm>
#include <numeric>
#include <vector>

namespace pvol {
namespace {

/// Levenshtein's distance, row by row.
std::size_t edit_distance(std::string_view a, std::string_view b) {
  std::vector<std::size_t> row(b.size() + 1);
  std::iota(row.begin(), row.end(), std::size_t{0});
  for (std::size_t i = 0; i < a.size(); ++i) {
    std::size_t diagonal = row[0];
    row[0] = i + 1;
    for (std::size_t j = 0; j < b.size(); ++j) {
      const std::size_t replace = diagonal + (a[i] == b[j] ? 0 : 1);
      diagonal = row[j + 1];
      row[j + 1] = std::min({replace, row[j] + 1, row[j + 1] + 1});
    }
  }
  return row.back();
}

}  // namespace

std::optional<std::string_view> nearest_word(std::string_view found,
                                             std::span<const std::string_view> words) {
  constexpr std::size_t kMostEdits = 2;
  std::size_t fewest = std::min(kMostEdits, found.size() / 2) + 1;
  std::optional<std::string_view> nearest;
  for (const std::string_view word : words) {
    const std::size_t edits = edit_distance(found, word);
    if (edits < fewest) fewest = edits, nearest = word;
  }
  return nearest;
}

}  // namespace pvol
