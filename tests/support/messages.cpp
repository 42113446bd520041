#include "support/messages.h"

#include <unistd.h>

#include <algorithm>
#include <cstdlib>
#include <fstream>
#include <map>
#include <sstream>
#include <stdexcept>

namespace pvol {
namespace {

using Pieces = std::vector<std::string>;

/// All that stands between separators.
Pieces split(const std::string& text, char separator) {
  Pieces pieces;
  std::istringstream in(text + separator);
  for (std::string piece; std::getline(in, piece, separator);) pieces.push_back(piece);
  return pieces;
}

/// Without blanks around it.
std::string trimmed(const std::string& line) {
  const std::size_t begin = std::min(line.find_first_not_of(' '), line.size());
  return line.substr(begin, line.find_last_not_of(' ') + 1 - begin);
}

Pieces lines_of(std::string text) {
  std::replace(text.begin(), text.end(), '\r', '\n');
  Pieces lines = split(text, '\n');
  std::transform(lines.begin(), lines.end(), lines.begin(), trimmed);
  return lines;
}

/// Lines `key: message`; others are comments or empty.
std::map<std::string, std::string> read_messages() {
  std::map<std::string, std::string> messages;
  std::ifstream in(PVOL_MESSAGES);
  for (std::string line; std::getline(in, line);) {
    const std::size_t colon = line.find(": ");
    if (line.starts_with('#') || colon == line.npos) continue;
    messages.emplace(line.substr(0, colon), line.substr(colon + 2));
  }
  return messages;
}

const std::string& message_of(const std::string& key) {
  static const std::map<std::string, std::string> messages = read_messages();
  const auto at = messages.find(key);
  if (at == messages.end()) throw std::out_of_range("tests/messages.txt has no key " + key);
  return at->second;
}

/// The parts between those `*` that stand for anything.
Pieces fixed_parts(const std::string& message, const std::vector<std::string>& filled) {
  Pieces parts = split(message, '*');
  if (filled.size() >= parts.size()) throw std::out_of_range("too few * in: " + message);
  for (const std::string& text : filled) {
    parts[1].insert(0, parts[0] + text);
    parts.erase(parts.begin());
  }
  return parts;
}

bool is(const std::string& line, const Pieces& parts) {
  if (parts.size() == 1) return line == parts[0];
  if (!line.starts_with(parts.front())) return false;
  std::size_t at = parts.front().size();
  for (std::size_t i = 1; i + 1 < parts.size(); ++i) {
    at = line.find(parts[i], at);
    if (at == line.npos) return false;
    at += parts[i].size();
  }
  return line.size() >= at + parts.back().size() && line.ends_with(parts.back());
}

/// In a file of this process alone: others run at the same time.
void record(const std::string& key, const std::string& text) {
  const char* folder = std::getenv("PVOL_SAID");
  if (folder == nullptr) return;
  std::ofstream out(std::string(folder) + '/' + std::to_string(getpid()), std::ios::app);
  out << key << '\0' << text << '\0';
}

}  // namespace

int times_said(const std::string& text, const std::string& key,
               const std::vector<std::string>& filled) {
  const Pieces parts = fixed_parts(message_of(key), filled);
  const Pieces lines = lines_of(text);
  return int(std::count_if(lines.begin(), lines.end(),
                           [&](const std::string& line) { return is(line, parts); }));
}

::testing::AssertionResult says(const std::string& text, const std::string& key,
                                const std::vector<std::string>& filled) {
  record(key, text);
  if (times_said(text, key, filled) > 0) return ::testing::AssertionSuccess();
  auto failure = ::testing::AssertionFailure()
                 << key << " is not said\n  expected: " << message_of(key);
  for (const std::string& part : filled) failure << "\n  with: " << part;
  return failure << "\n  found: " << (text.empty() ? "nothing" : text)
                 << "\nWhere the new wording is right: tests/accept_messages -R SUITE";
}

}  // namespace pvol
