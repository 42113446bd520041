// Pages for people: self-contained HTML with nothing to load, in light and dark, on any screen.
#pragma once

#include <cstddef>
#include <filesystem>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace pvol::html {

/// Text as it may stand between tags and in quoted attributes. Bytes that are no UTF-8, as file
/// names may hold, and control characters become U+FFFD.
[[nodiscard]] std::string escape(std::string_view text);

/// A page is made of blocks, in order. All texts are escaped here, but those named `markup`.
struct Page {
  std::string title;
  std::string body;
};

void add_heading(Page& page, std::string_view text);
void add_paragraph(Page& page, std::string_view text);
/// A paragraph that stands out: the verdict of a report. `good` and `bad` also differ in their
/// sign, not in colour alone.
enum class Mood { plain, good, bad };
void add_verdict(Page& page, std::string_view text, Mood mood);

/// The first column is set left, as names, the others right, as numbers.
struct Table {
  std::string caption;
  std::vector<std::string> header;
  std::vector<std::vector<std::string>> rows;  ///< each as long as the header
  std::vector<std::size_t> marked;             ///< rows that stand out
};
void add_table(Page& page, const Table& table);

/// An <svg> or <img> with a line below it.
struct Figure {
  std::string markup;
  std::string caption;
};
void add_figure(Page& page, const Figure& figure);
/// Side by side where the screen is wide enough.
void add_figures(Page& page, std::span<const Figure> figures);

/// An <img> that holds the bytes of a PNG file; `description` is for those who cannot see it.
/// `crisp`: small pictures are enlarged pixel by pixel.
[[nodiscard]] std::string image(std::span<const std::byte> png, std::string_view description,
                                bool crisp);

/// What may be looked up, closed at first.
void add_details(Page& page, std::string_view summary, std::string_view text);

/// The whole document.
[[nodiscard]] std::string to_text(const Page& page);

/// Writes the document. Atomic; throws Error where writing fails.
void write_page(const std::filesystem::path& file, const Page& page);

}  // namespace pvol::html
