// Reports as pages for people: self-contained HTML with nothing to load, in light and dark, on any
// screen.
#pragma once

#include <cstddef>
#include <filesystem>
#include <span>
#include <string>
#include <string_view>

#include "report/document.h"

namespace pvol::html {

/// Text as it may stand between tags and in quoted attributes. Bytes that are no UTF-8, as file
/// names may hold, and control characters become U+FFFD.
[[nodiscard]] std::string escape(std::string_view text);

/// An <img> that holds the bytes of a PNG file; `description` is for those who cannot see it.
/// `crisp`: small pictures are enlarged pixel by pixel.
[[nodiscard]] std::string image(std::span<const std::byte> png, std::string_view description,
                                bool crisp);

/// The whole page. All texts of the document are escaped here, but the markup of figures.
[[nodiscard]] std::string to_page(const report::Document& document);

/// Writes the page. Atomic; throws Error where writing fails.
void write_page(const std::filesystem::path& file, const report::Document& document);

}  // namespace pvol::html
