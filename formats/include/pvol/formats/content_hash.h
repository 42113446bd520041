// Whether two files hold the same.
#pragma once

#include <filesystem>
#include <string>

namespace pvol::formats {

/// Of all bytes of a file, 32 hexadecimal digits (XXH3-128). Throws Error where it cannot be read.
[[nodiscard]] std::string content_hash(const std::filesystem::path& file);

/// Of a text.
[[nodiscard]] std::string text_hash(const std::string& text);

}  // namespace pvol::formats
