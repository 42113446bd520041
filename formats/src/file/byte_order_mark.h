// The mark with which some editors begin texts.
#pragma once

#include <cstddef>
#include <string_view>

namespace pvol::formats::detail {

/// The bytes that a UTF-8 byte order mark takes at the start of a text: 3, or 0 without one.
[[nodiscard]] inline std::size_t byte_order_mark(std::string_view text) {
  constexpr std::string_view kMark = "\xEF\xBB\xBF";
  return text.starts_with(kMark) ? kMark.size() : 0;
}

}  // namespace pvol::formats::detail
