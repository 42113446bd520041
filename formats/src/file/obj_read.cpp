// Wavefront OBJ: its vertices and faces.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "file/mesh_read.h"
#include "file/parse_number.h"
#include "pvol/error.h"

namespace pvol::formats::detail {
namespace {

/// Statements that say nothing of where triangles are.
constexpr std::array kIgnored{"vt",       "vn",     "vp",   "g",          "o",      "s",
                              "mg",       "usemtl", "l",    "mtllib",     "usemap", "maplib",
                              "p",        "bevel",  "lod",  "shadow_obj", "deg",    "c_interp",
                              "d_interp", "bmat",   "step", "cstype",     "curv",   "trace_obj",
                              "parm",     "curv2",  "trim", "hole",       "scrv",   "sp",
                              "end",      "con",    "call", "csh",        "ctech",  "stech"};

bool is_blank(char c) { return c == ' ' || c == '\t' || c == '\r' || c == '\f' || c == '\v'; }

/// A reader of a file line by line; lines that end in a backslash go on in the next.
class ObjReader {
 public:
  ObjReader(const std::filesystem::path& file, std::string_view text) : file_(&file), text_(text) {
    if (text_.starts_with("\xef\xbb\xbf")) text_.remove_prefix(3);
  }

  PolygonMesh read() {
    while (next_line()) {
      if (!words_.empty()) statement();
    }
    if (largest_ >= std::int64_t(mesh_.vertices.size())) {
      line_ = line_of_largest_;
      fail(fmt::format("vertex {}", largest_ + 1),
           fmt::format("at most {}, the number of vertices", mesh_.vertices.size()));
    }
    return std::move(mesh_);
  }

 private:
  [[noreturn]] void fail(const std::string& found, const std::string& expected) const {
    throw Error(
        fmt::format("{}:{}: found {}; expected {}", file_->string(), line_, found, expected));
  }

  /// The words of the next line, comments left out; false at the end of the file.
  bool next_line() {
    words_.clear();
    if (text_.empty()) return false;
    line_ = next_++;
    while (take_line()) ++next_;
    return true;
  }

  /// Adds the words of one line of the file; whether the statement goes on in the next one.
  bool take_line() {
    const std::size_t end = std::min(text_.find('\n'), text_.size());
    std::string_view line = text_.substr(0, end);
    text_.remove_prefix(std::min(end + 1, text_.size()));
    const std::size_t comment = line.find('#');
    line = line.substr(0, comment);
    while (!line.empty() && is_blank(line.back())) line.remove_suffix(1);
    const bool goes_on = comment == line.npos && line.ends_with('\\');
    if (goes_on) line.remove_suffix(1);
    while (!line.empty()) {
      const auto begin = std::ranges::find_if_not(line, is_blank);
      const auto stop = std::find_if(begin, line.end(), is_blank);
      if (begin != stop) words_.emplace_back(begin, stop);
      line = {stop, line.end()};
    }
    return goes_on && !text_.empty();
  }

  void statement() {
    const std::string_view kind = words_.front();
    if (kind == "v") {
      vertex();
    } else if (kind == "f" || kind == "fo") {
      face();
    } else if (kind == "surf") {
      fail("a free-form surface (surf)", "faces; convert it to polygons");
    } else if (std::ranges::find(kIgnored, kind) == kIgnored.end()) {
      fail(fmt::format("'{}'", shown(kind)), "a statement of Wavefront OBJ such as v or f");
    }
  }

  /// Weights and colours after the place are left out.
  void vertex() {
    if (words_.size() < 4) {
      fail(fmt::format("{} numbers after v", words_.size() - 1), "at least three");
    }
    Vec3d v;
    for (int axis = 0; axis < 3; ++axis) {
      const std::string_view word = words_[std::size_t(axis) + 1];
      const auto number = parse_number(word);
      if (!number || !std::isfinite(*number)) {
        fail(fmt::format("'{}'", shown(word)), "a finite number");
      }
      v[axis] = *number;
    }
    if (mesh_.vertices.size() == kMostVertices) fail("another vertex", "at most 2^32 - 1");
    mesh_.vertices.push_back(v);
  }

  void face() {
    if (words_.size() < 4) {
      fail(fmt::format("a face of {} vertices", words_.size() - 1), "at least three");
    }
    for (std::size_t i = 1; i < words_.size(); ++i) {
      mesh_.faces.corners.push_back(corner(words_[i]));
    }
    mesh_.faces.ends.push_back(mesh_.faces.corners.size());
  }

  /// Of "i", "i/t", "i/t/n" or "i//n" the vertex. Numbers begin at 1; negative ones count from the
  /// last vertex so far. Whether positive ones are there shows at the end of the file.
  std::uint32_t corner(std::string_view word) {
    const std::size_t slash = std::min(word.find('/'), word.size());
    const auto number = parse_whole(word.substr(0, slash));
    const bool rest_is_fine = word.find_first_not_of("0123456789-/", slash) == word.npos;
    if (!number || !rest_is_fine) {
      fail(fmt::format("'{}' in a face", shown(word)), "numbers such as 3, 3/1, 3/1/2 or 3//2");
    }
    const auto count = std::int64_t(mesh_.vertices.size());
    const std::int64_t index = *number > 0 ? *number - 1 : count + *number;
    if (*number == 0 || index < 0 || index >= std::int64_t(kMostVertices)) {
      fail(fmt::format("vertex {} in a face", *number),
           fmt::format("1 and up, or -1 to -{} for the vertices so far", count));
    }
    if (index > largest_) largest_ = index, line_of_largest_ = line_;
    return std::uint32_t(index);
  }

  const std::filesystem::path* file_;
  std::string_view text_;  // what is still to be read
  std::size_t line_ = 0, next_ = 1;
  std::vector<std::string_view> words_;
  PolygonMesh mesh_;
  std::int64_t largest_ = -1;  // of the vertices that faces ask for
  std::size_t line_of_largest_ = 0;
};

}  // namespace

PolygonMesh decode_obj(const std::filesystem::path& file, std::string_view text) {
  return ObjReader(file, text).read();
}

}  // namespace pvol::formats::detail
