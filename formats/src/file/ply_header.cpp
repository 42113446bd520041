#include "file/ply_header.h"

#include <fmt/format.h>

#include <algorithm>

#include "file/mesh_read.h"
#include "file/parse_number.h"
#include "pvol/error.h"

namespace pvol::formats::detail {
namespace {

struct NamedType {
  const char* name;
  PlyType type;
};
constexpr NamedType kTypes[] = {
    {"char", {1, true}},          {"int8", {1, true}},          {"uchar", {1, false}},
    {"uint8", {1, false}},        {"short", {2, true}},         {"int16", {2, true}},
    {"ushort", {2, false}},       {"uint16", {2, false}},       {"int", {4, true}},
    {"int32", {4, true}},         {"uint", {4, false}},         {"uint32", {4, false}},
    {"float", {4, true, true}},   {"float32", {4, true, true}}, {"double", {8, true, true}},
    {"float64", {8, true, true}},
};

/// Reads the lines of a header.
class HeaderReader {
 public:
  HeaderReader(const std::filesystem::path& file, std::string_view bytes)
      : file_(&file), text_(bytes) {}

  PlyHeader read() {
    const std::size_t all = text_.size();
    next_line();
    if (words_.size() != 1 || words_[0] != "ply") fail("ply, the first line of PLY files");
    next_line();
    format();
    while (next_line()) {
      const std::string_view kind = words_.empty() ? "" : words_[0];
      if (kind == "end_header") {
        header_.bytes = all - text_.size();
        header_.lines = line_;
        return std::move(header_);
      }
      if (kind == "element")
        element();
      else if (kind == "property")
        property();
      else if (kind != "comment" && kind != "obj_info")
        fail("element, property or end_header");
    }
    fail("end_header; the file may be cut off");
  }

 private:
  [[noreturn]] void fail(const std::string& expected) const {
    const std::string found =
        line_text_.empty() ? "nothing" : fmt::format("'{}'", shown(line_text_));
    throw Error(
        fmt::format("{}:{}: found {}; expected {}", file_->string(), line_, found, expected));
  }

  /// False at the end of the file. A last line needs no end, which is for the data to miss.
  bool next_line() {
    words_.clear();
    line_text_ = {};
    ++line_;
    if (text_.empty()) return false;
    const std::size_t end = std::min(text_.find('\n'), text_.size());
    line_text_ = text_.substr(0, end);
    text_.remove_prefix(std::min(end + 1, text_.size()));
    if (line_text_.ends_with('\r')) line_text_.remove_suffix(1);
    for (std::string_view rest = line_text_; !rest.empty();) {
      const std::size_t length = std::min(rest.find_first_of(" \t"), rest.size());
      if (length > 0) words_.push_back(rest.substr(0, length));
      rest.remove_prefix(std::min(length + 1, rest.size()));
    }
    return true;
  }

  void format() {
    const bool fits = words_.size() == 3 && words_[0] == "format" && words_[2] == "1.0";
    if (fits && words_[1] == "ascii")
      header_.encoding = PlyEncoding::ascii;
    else if (fits && words_[1] == "binary_little_endian")
      header_.encoding = PlyEncoding::little_endian;
    else if (fits && words_[1] == "binary_big_endian")
      header_.encoding = PlyEncoding::big_endian;
    else
      fail("format ascii 1.0, binary_little_endian 1.0 or binary_big_endian 1.0");
  }

  void element() {
    const auto count = words_.size() == 3 ? parse_whole(words_[2]) : std::nullopt;
    if (!count || *count < 0) fail("element NAME NUMBER");
    const std::string name(words_[1]);
    if (std::ranges::find(header_.elements, name, &PlyElement::name) != header_.elements.end()) {
      fail("each element once");
    }
    header_.elements.push_back({name, std::uint64_t(*count), {}});
  }

  PlyType type(std::string_view name) const {
    const auto* found =
        std::ranges::find_if(kTypes, [&](const NamedType& t) { return t.name == name; });
    if (found == std::end(kTypes)) {
      fail("a type: char, uchar, short, ushort, int, uint, float or double");
    }
    return found->type;
  }

  void property() {
    if (header_.elements.empty()) fail("an element before its properties");
    PlyProperty p;
    if (words_.size() == 5 && words_[1] == "list") {
      p = {std::string(words_[4]), type(words_[3]), true, type(words_[2])};
      if (p.count.is_float) fail("a whole type for the number of values of a list");
    } else if (words_.size() == 3) {
      p = {std::string(words_[2]), type(words_[1])};
    } else {
      fail("property TYPE NAME or property list TYPE TYPE NAME");
    }
    PlyElement& element = header_.elements.back();
    if (element.find(p.name) != nullptr) fail("each property of an element once");
    element.properties.push_back(std::move(p));
  }

  const std::filesystem::path* file_;
  std::string_view text_;  // what is still to be read
  std::size_t line_ = 0;
  std::string_view line_text_;
  std::vector<std::string_view> words_;
  PlyHeader header_;
};

}  // namespace

const PlyProperty* PlyElement::find(std::string_view property) const {
  const auto found = std::ranges::find(properties, property, &PlyProperty::name);
  return found == properties.end() ? nullptr : &*found;
}

PlyHeader decode_ply_header(const std::filesystem::path& file, std::string_view bytes) {
  return HeaderReader(file, bytes).read();
}

}  // namespace pvol::formats::detail
