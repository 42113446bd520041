// Text in columns and lines for terminals.
#pragma once

#include <sstream>
#include <string>

namespace pvol::cli {

/// The text at the left or the right end of a column; a text too long takes what it needs and has
/// one blank on the column's other side.
[[nodiscard]] inline std::string left_in(const std::string& text, std::size_t width) {
  return text + std::string(text.size() < width ? width - text.size() : 1, ' ');
}
[[nodiscard]] inline std::string right_in(const std::string& text, std::size_t width) {
  return std::string(text.size() < width ? width - text.size() : 1, ' ') + text;
}

/// The words in lines of at most `width` columns, each line ended; those after the first begin with
/// `indent`.
[[nodiscard]] inline std::string wrapped(const std::string& text, std::size_t width = 110,
                                         const std::string& indent = "") {
  std::istringstream words(text);
  std::string lines, line, word;
  while (words >> word) {
    if (!line.empty() && line.size() + 1 + word.size() > width) {
      lines += line + '\n';
      line = indent + word;
    } else {
      line += (line.empty() ? "" : " ") + word;
    }
  }
  return lines + line + '\n';
}

}  // namespace pvol::cli
