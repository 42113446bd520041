#include "usda/usda_tokens.h"

#include <fmt/format.h>

#include <algorithm>

#include "file/byte_order_mark.h"
#include "file/byte_source.h"
#include "file/parse_number.h"
#include "pvol/error.h"
#include "pvol/formats/cloud.h"

namespace pvol::formats::detail {
namespace {

constexpr std::string_view kUsdaHeader = "#usda ", kOldHeader = "#sdf ";
constexpr std::uint64_t kMostUsdaBytes = std::uint64_t(1) << 32;

bool is_digit(char c) { return c >= '0' && c <= '9'; }

/// Also of letters beyond ASCII, which are written in several bytes.
bool is_letter(char c) {
  return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || c == '_' ||
         static_cast<unsigned char>(c) >= 0x80;
}

bool in_word(char c) { return is_letter(c) || is_digit(c) || c == ':' || c == '.'; }
bool in_number(char c) { return is_letter(c) || is_digit(c) || c == '.' || c == '+' || c == '-'; }

/// Up to the first character that is not one of these.
std::string_view run_of(std::string_view text, bool (*is_one)(char)) {
  return text.substr(0, std::size_t(std::ranges::find_if_not(text, is_one) - text.begin()));
}

std::string read_usda_text(const std::filesystem::path& file) {
  ByteSource source(file);
  if (source.size() > kMostUsdaBytes) {
    throw Error(file.string() + ": is larger than 4 GiB; keep large arrays in files of their own");
  }
  std::string text(source.size(), '\0');
  source.copy(0, source.size(), text.data());
  text.erase(0, byte_order_mark(text));
  const std::string name = file.string(), stem = file.stem().string();
  if (text.starts_with("PXR-USDC")) {
    // Those that end in .usda may be binary too.
    const std::string text_file = stem + (ending(file) == ".usda" ? ".text.usda" : ".usda");
    throw Error(fmt::format("{}: is a binary USD file; make text of it: usdcat -o {} {}", name,
                            text_file, name));
  }
  if (text.starts_with("PK\3\4")) {
    throw Error(
        fmt::format("{}: is a package; unpack it (it is a zip file), and make text of the "
                    "scene in it: usdcat -o {}.usda SCENE.usdc",
                    name, stem));
  }
  if (!text.starts_with(kUsdaHeader) && !text.starts_with(kOldHeader)) {
    throw Error(name + ":1:1: found no '#usda 1.0'; expected it at the beginning of the file");
  }
  return text;
}

}  // namespace

UsdTokens::UsdTokens(const std::filesystem::path& file)
    : file_(std::make_shared<const std::filesystem::path>(file)), text_(read_usda_text(file)) {
  next_ = scan();
}

UsdToken UsdTokens::take() {
  const UsdToken token = next_;
  if (token.kind != UsdToken::Kind::end) next_ = scan();
  return token;
}

bool UsdTokens::take_if(char mark) {
  if (!next_.is(mark)) return false;
  (void)take();
  return true;
}

void UsdTokens::need(char mark, const std::string& expected) {
  if (!take_if(mark)) fail(expected);
}

void UsdTokens::fail(const std::string& expected) const {
  const bool ends = next_.kind == UsdToken::Kind::end;
  fail_at(where(), ends ? "the end of the file" : fmt::format("'{}'", usd_shown(next_.text)),
          expected);
}

void UsdTokens::advance(std::size_t count) {
  const std::size_t end = std::min(at_ + count, text_.size());
  for (; at_ < end; ++at_) {
    if (text_[at_] == '\n') ++line_, line_begin_ = at_ + 1;
  }
}

void UsdTokens::skip_blanks() {
  while (at_ < text_.size()) {
    const std::string_view rest = std::string_view(text_).substr(at_);
    if (rest.front() == '#' || rest.starts_with("//")) {
      advance(std::min(rest.find('\n'), rest.size()));
    } else if (rest.starts_with("/*")) {
      const std::size_t end = rest.find("*/", 2);
      advance(end == rest.npos ? rest.size() : end + 2);
    } else if (std::string_view(" \t\r\n\f\v").find(rest.front()) != rest.npos) {
      advance(1);
    } else {
      return;
    }
  }
}

UsdToken UsdTokens::enclosed(UsdToken::Kind kind, std::string_view open, std::string_view close) {
  UsdToken token{kind, {}, 0, line_, at_ - line_begin_ + 1};
  const std::string_view text = text_;
  const std::size_t begin = at_ + open.size();
  const bool many_lines = close.size() > 1;
  for (std::size_t end = begin; end < text.size(); ++end) {
    if (text[end] == '\\' && kind == UsdToken::Kind::string) {
      ++end;  // what is escaped ends nothing
    } else if (text.substr(end).starts_with(close)) {
      token.text = text.substr(begin, end - begin);
      advance(end + close.size() - at_);
      return token;
    } else if (text[end] == '\n' && !many_lines) {
      break;
    }
  }
  fail_at(where(token), fmt::format("{} without an end", open),
          fmt::format("{}{}", close, many_lines ? "" : " on the same line"));
}

UsdToken UsdTokens::scan() {
  using Kind = UsdToken::Kind;
  skip_blanks();
  UsdToken token{Kind::end, {}, 0, line_, at_ - line_begin_ + 1};
  const std::string_view rest = std::string_view(text_).substr(at_);
  if (rest.empty()) return token;
  for (const std::string_view quote : {R"(""")", "'''", "\"", "'"}) {
    if (rest.starts_with(quote)) return enclosed(Kind::string, quote, quote);
  }
  for (const std::string_view at : {"@@@", "@"}) {
    if (rest.starts_with(at)) return enclosed(Kind::asset, at, at);
  }
  if (rest.front() == '<') return enclosed(Kind::path, "<", ">");
  if (is_letter(rest.front())) {
    token.kind = Kind::word, token.text = run_of(rest, in_word);
    const bool number = token.text == "inf" || token.text == "nan";
    if (number) token.kind = Kind::number, token.number = parse_number(token.text).value_or(0);
  } else if (is_digit(rest.front()) || std::string_view("+-.").find(rest.front()) != rest.npos) {
    token.kind = Kind::number, token.text = run_of(rest, in_number);
    const std::optional<double> number = parse_number(token.text);
    if (!number) fail_at(where(token), fmt::format("'{}'", usd_shown(token.text)), "a number");
    token.number = *number;
  } else {
    token.kind = Kind::mark, token.text = rest.substr(0, 1);
  }
  advance(token.text.size());
  return token;
}

std::string unescaped(std::string_view text) {
  std::string all;
  for (std::size_t i = 0; i < text.size(); ++i) {
    if (text[i] != '\\' || i + 1 == text.size()) {
      all += text[i];
      continue;
    }
    const char c = text[++i];
    all += c == 'n' ? '\n' : c == 't' ? '\t' : c == 'r' ? '\r' : c;
  }
  return all;
}

}  // namespace pvol::formats::detail
