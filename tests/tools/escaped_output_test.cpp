// Control characters that are written to terminals.
#include "cli/escaped_output.h"

#include <gtest/gtest.h>

#include <sstream>
#include <string>

namespace pvol::cli {
namespace escaped_output_test {

std::string written(const std::string& text) {
  std::ostringstream stream;
  {
    const EscapedOutput escaped(stream);
    stream << text;
  }
  return stream.str();
}

TEST(EscapedOutput, SpellsControlCharactersOutAndLeavesTheRest) {
  EXPECT_EQ(written("\x1b[31mred\x1b[0m\a\x7f"), "\\x1b[31mred\\x1b[0m\\x07\\x7f");
  const std::string plain = "a b\tc\r\n\xc3\xa9 \xe2\x82\xac \xf0\x9f\x98\x80 \xc2\xb2";
  EXPECT_EQ(written(plain), plain) << "UTF-8";
  EXPECT_EQ(written("\xc2\x9b"
                    "31m"),
            "\\x9b31m")
      << "the escape in one character";
  EXPECT_EQ(written("\xc2"), "\xc2") << "half of one";
  EXPECT_EQ(written(std::string("a\0b", 3)), "a\\x00b");
}

/// In whatever pieces it is written.
TEST(EscapedOutput, HoldsAcrossWrites) {
  std::ostringstream stream;
  {
    const EscapedOutput escaped(stream);
    for (const char c : std::string("\xc2\x9b\x1b\xc2\xb2")) stream << c;
    stream << 12 << '\x1b' << std::flush;
    EXPECT_EQ(stream.str(),
              "\\x9b\\x1b\xc2\xb2"
              "12\\x1b");
  }
  stream << '\x1b';
  EXPECT_TRUE(stream.str().ends_with('\x1b')) << "the stream is as before";
}

TEST(EscapedOutput, KeepsFailures) {
  std::ostringstream stream;
  {
    const EscapedOutput escaped(stream);
    stream.setstate(std::ios::badbit);
  }
  EXPECT_TRUE(stream.bad());
}

}  // namespace escaped_output_test
}  // namespace pvol::cli
