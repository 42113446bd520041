// Numbers in messages.
#pragma once

#include <string>

namespace pvol::detail {

/// As few characters as hold this many significant digits.
[[nodiscard]] std::string digits(double v, int count = 4);

}  // namespace pvol::detail
