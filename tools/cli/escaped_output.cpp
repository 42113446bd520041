#include "cli/escaped_output.h"

#include <array>

namespace pvol::cli {
namespace {

constexpr unsigned char kC2 = 0xc2;

}  // namespace

EscapedOutput::EscapedOutput(std::ostream& stream) : stream_(stream), to_(stream.rdbuf(this)) {}

EscapedOutput::~EscapedOutput() {
  (void)EscapedOutput::sync();
  const auto state = stream_.rdstate();
  stream_.rdbuf(to_);  // which clears the state
  stream_.setstate(state);
}

EscapedOutput::int_type EscapedOutput::overflow(int_type c) {
  if (traits_type::eq_int_type(c, traits_type::eof())) return traits_type::not_eof(c);
  return put(static_cast<unsigned char>(traits_type::to_char_type(c))) ? c : traits_type::eof();
}

std::streamsize EscapedOutput::xsputn(const char* text, std::streamsize size) {
  std::streamsize done = 0;
  while (done < size && put(static_cast<unsigned char>(text[done]))) ++done;
  return done;
}

int EscapedOutput::sync() { return put_held() ? to_->pubsync() : -1; }

bool EscapedOutput::put_held() {
  return !holds_c2_.exchange(false) || to_->sputc(char(kC2)) != traits_type::eof();
}

bool EscapedOutput::spell(unsigned char c) {
  constexpr const char* kDigits = "0123456789abcdef";
  const std::array<char, 4> text{'\\', 'x', kDigits[c >> 4], kDigits[c & 15]};
  return to_->sputn(text.data(), text.size()) == std::streamsize(text.size());
}

bool EscapedOutput::put(unsigned char c) {
  if (holds_c2_ && c >= 0x80 && c < 0xa0) {
    holds_c2_ = false;
    return spell(c);
  }
  if (!put_held()) return false;
  if (c == kC2) return holds_c2_ = true;
  const bool is_control = (c < 0x20 && c != '\n' && c != '\r' && c != '\t') || c == 0x7f;
  if (is_control) return spell(c);
  return to_->sputc(char(c)) != traits_type::eof();
}

}  // namespace pvol::cli
