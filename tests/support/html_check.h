// Whether pages are well-formed, by Python's parsers.
#pragma once

#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <string>

namespace pvol::testing {

[[nodiscard]] inline bool has_python() {
  return std::system("python3 -c 'pass' > /dev/null 2>&1") == 0;
}

/// Fails where check_html.py refuses the page, whose name holds no quotes.
[[nodiscard]] inline ::testing::AssertionResult is_page(const std::filesystem::path& file) {
  const std::string command =
      "python3 \"" PVOL_CHECK_HTML "\" \"" + file.string() + "\"";  // says why on stderr
  if (std::system(command.c_str()) == 0) return ::testing::AssertionSuccess();
  return ::testing::AssertionFailure() << file << " is not well-formed";
}

}  // namespace pvol::testing
