// Whether pages are well-formed, by Python's parsers.
#pragma once

#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <string>

namespace pvol::testing {

/// The page without its embedded pictures, whose base64 may spell any word.
[[nodiscard]] inline std::string without_pictures(std::string page) {
  const std::string opening = ";base64,";
  for (std::size_t at = 0; (at = page.find(opening, at)) != std::string::npos;) {
    at += opening.size();
    page.erase(at, page.find_first_of("\"')", at) - at);
  }
  return page;
}

/// Fails where check_html.py refuses the page, whose name holds no quotes.
[[nodiscard]] inline ::testing::AssertionResult is_page(const std::filesystem::path& file) {
  const std::string command =
      PVOL_PYTHON " \"" PVOL_CHECK_HTML "\" \"" + file.string() + "\"";  // says why on stderr
  if (std::system(command.c_str()) == 0) return ::testing::AssertionSuccess();
  return ::testing::AssertionFailure() << file << " is not well-formed";
}

}  // namespace pvol::testing
