// Text in lines for terminals.
#pragma once

#include <sstream>
#include <string>

namespace pvol::cli {

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
