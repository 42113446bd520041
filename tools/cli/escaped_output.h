// Text on terminals that does what it says and nothing else.
#pragma once

#include <atomic>
#include <ostream>
#include <streambuf>

namespace pvol::cli {

/// While it is there, control characters that are written to a stream are spelt out, "\x1b" for an
/// escape: names of files and grids may hold sequences that recolour, retitle or mislead a
/// terminal. Line ends, returns and tabs pass, and so does all else of UTF-8.
class EscapedOutput : private std::streambuf {
 public:
  explicit EscapedOutput(std::ostream& stream);
  ~EscapedOutput() override;
  EscapedOutput(const EscapedOutput&) = delete;
  EscapedOutput& operator=(const EscapedOutput&) = delete;

 private:
  int_type overflow(int_type c) override;
  std::streamsize xsputn(const char* text, std::streamsize size) override;
  int sync() override;
  bool put(unsigned char c);
  bool spell(unsigned char c);
  bool put_held();

  std::ostream& stream_;
  std::streambuf* to_;
  // The first byte of the control characters 0x80 to 0x9f in UTF-8, and of others. Threads may
  // write to one stream at the same time.
  std::atomic<bool> holds_c2_ = false;
};

}  // namespace pvol::cli
