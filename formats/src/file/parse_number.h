// Numbers in text, the same in every locale.
#pragma once

#include <charconv>
#include <optional>
#include <string_view>
#include <system_error>

namespace pvol::formats::detail {

/// Of the whole text; nothing where it is none or one that double does not hold. What is too small
/// for a double is 0, "nan" and "inf" are numbers.
[[nodiscard]] inline std::optional<double> parse_number(std::string_view text) {
  if (text.starts_with('+')) text.remove_prefix(1);
  if (text.starts_with('+') || text.empty()) return {};
  double value = 0;
  const auto [end, fault] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (end != text.data() + text.size()) return {};
  if (fault == std::errc{}) return value;
  const bool tiny = text.find("e-") != text.npos || text.find("E-") != text.npos;
  if (fault == std::errc::result_out_of_range && tiny) return 0.0;
  return {};
}

/// The same of a whole number.
[[nodiscard]] inline std::optional<long long> parse_whole(std::string_view text) {
  if (text.starts_with('+')) text.remove_prefix(1);
  if (text.starts_with('+')) return {};
  long long value = 0;
  const auto [end, fault] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (text.empty() || end != text.data() + text.size() || fault != std::errc{}) return {};
  return value;
}

}  // namespace pvol::formats::detail
