#include "pvol/render/light_group.h"

#include <algorithm>

#include "pvol/render/aov.h"

namespace pvol {

bool is_group_name(std::string_view name) {
  constexpr std::string_view kLetters =
      "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789_";
  // Channels, the light of media, and parts of files.
  constexpr auto kTaken = std::to_array<std::string_view>(
      {"R", "G", "B", "A", "Z", "emission", "sums", "picture", "rgba", "CryptoObject"});
  const auto is_among = [&](const auto& names) {
    return std::ranges::find(names, name) != std::ranges::end(names);
  };
  if (name.empty() || name.find_first_not_of(kLetters) != std::string_view::npos) return false;
  return !is_among(kTaken) && !is_among(kOrderLayers) && !is_among(kHalfLayers) &&
         !is_among(kNoisyLayers) && std::ranges::find(kAovs, name, &AovRow::name) == kAovs.end();
}

}  // namespace pvol
