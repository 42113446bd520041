// How deep tables nest in a TOML text, before it is parsed.
#pragma once

#include <cstddef>
#include <string_view>

namespace pvol::formats::detail {

/// Most tables and arrays inside each other. Trees of recipes take some 70.
inline constexpr std::size_t kDeepestToml = 256;

/// The line, from 1, on which keys with dots, arrays and inline tables first nest deeper than
/// kDeepestToml; 0 where they do not. The parser keeps to such a limit for brackets alone, and each
/// level of a key such as a.a.a.a costs it some stack: 100 kB of them end the program.
[[nodiscard]] std::size_t find_too_deep(std::string_view toml);

}  // namespace pvol::formats::detail
