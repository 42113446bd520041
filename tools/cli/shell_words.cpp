#include "cli/shell_words.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>

namespace pvol::cli {
namespace {

bool is_plain(char c) {
  return std::isalnum(static_cast<unsigned char>(c)) != 0 ||
         std::string_view("_@%+=:,./-").find(c) != std::string_view::npos;
}

/// $'...', for what would not stay on one line.
std::string escaped(const std::string& word) {
  std::string text = "$'";
  for (const char c : word) {
    if (std::iscntrl(static_cast<unsigned char>(c)) != 0) {
      text += fmt::format("\\{:03o}", static_cast<unsigned char>(c));
    } else {
      if (c == '\'' || c == '\\') text += '\\';
      text += c;
    }
  }
  return text + '\'';
}

}  // namespace

std::string shell_word(const std::string& word) {
  const auto control = [](char c) { return std::iscntrl(static_cast<unsigned char>(c)) != 0; };
  if (std::any_of(word.begin(), word.end(), control)) return escaped(word);
  if (!word.empty() && std::all_of(word.begin(), word.end(), is_plain)) return word;
  std::string text(1, '\'');
  for (const char c : word) {
    if (c == '\'') text += "'\\'";  // out of the quotes, one of them, and in again
    text += c;
  }
  return text + '\'';
}

std::string shell_line(const std::vector<std::string>& command) {
  std::string line;
  for (const std::string& word : command) {
    if (!line.empty()) line += ' ';
    line += shell_word(word);
  }
  return line;
}

}  // namespace pvol::cli
