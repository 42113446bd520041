#include "pvol/render/light_group.h"

#include <algorithm>
#include <array>

#include "pvol/render/aov.h"

namespace pvol {

bool is_group_name(std::string_view name) {
  constexpr std::string_view kLetters =
      "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789_";
  constexpr auto kTaken = std::to_array<std::string_view>(
      {"R", "G", "B", "A", "Z", "unscattered", "single", "multiple", "emission"});
  if (name.empty() || name.find_first_not_of(kLetters) != std::string_view::npos) return false;
  return std::ranges::find(kTaken, name) == kTaken.end() &&
         std::ranges::find(kAovs, name, &AovRow::name) == kAovs.end();
}

}  // namespace pvol
