#include "pbrt/pbrt_tokens.h"

#include <fmt/format.h>

#include <algorithm>

#include "file/byte_order_mark.h"
#include "file/byte_source.h"
#include "pvol/error.h"
#include "pvol/formats/cloud.h"

namespace pvol::formats::detail {
namespace {

std::string read_text(const std::filesystem::path& file) {
  if (ending(file) == ".gz") {
    throw Error(file.string() +
                ": is compressed; unpack it with gunzip, and use the unpacked name");
  }
  ByteSource source(file);
  std::string text(source.size(), '\0');
  source.copy(0, source.size(), text.data());
  return text;
}

}  // namespace

std::string PbrtWhere::text() const { return fmt::format("{}:{}", file ? *file : "", line); }

void fail_at(const PbrtWhere& where, const std::string& found, const std::string& expected) {
  throw Error(fmt::format("{}: found {}; expected {}", where.text(), found, expected));
}

PbrtTokens::PbrtTokens(const std::filesystem::path& file)
    : file_(file),
      name_(std::make_shared<const std::string>(file.string())),
      text_(std::make_shared<const std::string>(read_text(file))) {
  at_ = byte_order_mark(*text_);
}

void PbrtTokens::skip_blanks() {
  const std::string& text = *text_;
  for (; at_ < text.size(); ++at_) {
    if (text[at_] == '#') {
      at_ = std::min(text.find_first_of("\r\n", at_), text.size());
      if (at_ == text.size()) return;
    }
    const char c = text[at_];
    if (c == '\n' || (c == '\r' && text.compare(at_, 2, "\r\n") != 0))
      ++line_;
    else if (c != ' ' && c != '\t' && c != '\r' && c != '\f' && c != '\v')
      return;
  }
}

std::optional<PbrtToken> PbrtTokens::next() {
  skip_blanks();
  const std::string_view text = *text_;
  if (at_ == text.size()) return std::nullopt;
  const std::size_t begin = at_;
  const auto token = [&](PbrtToken::Kind kind, std::string_view said) {
    return PbrtToken{kind, said, where()};
  };
  if (text[at_] == '[') return token(PbrtToken::Kind::open, text.substr(at_++, 1));
  if (text[at_] == ']') return token(PbrtToken::Kind::close, text.substr(at_++, 1));
  if (text[at_] != '"') {
    at_ = std::min(text.find_first_of(" \t\r\n\f\v\"[]#", begin), text.size());
    return token(PbrtToken::Kind::word, text.substr(begin, at_ - begin));
  }
  const std::size_t end = text.find_first_of("\"\n", begin + 1);
  if (end == text.npos || text[end] == '\n') {
    fail_at(where(), "a string without an end", "a second quotation mark on the line");
  }
  at_ = end + 1;
  return token(PbrtToken::Kind::string, text.substr(begin + 1, end - begin - 1));
}

}  // namespace pvol::formats::detail
