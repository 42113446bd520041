// Stanford PLY: its vertices and faces. Turk. The PLY Polygon File Format. 1994.
#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cmath>

#include "file/mesh_read.h"
#include "file/parse_number.h"
#include "file/ply_header.h"
#include "pvol/error.h"

namespace pvol::formats::detail {
namespace {

/// The number that these bits are; double holds each of them exactly.
double decode(const PlyType& type, std::uint64_t bits) {
  if (type.is_float) {
    return type.bytes == 4 ? double(std::bit_cast<float>(std::uint32_t(bits)))
                           : std::bit_cast<double>(bits);
  }
  if (!type.is_signed) return double(bits);
  switch (type.bytes) {
    case 1:
      return std::int8_t(bits);
    case 2:
      return std::int16_t(bits);
    default:
      return std::int32_t(bits);
  }
}

/// The numbers of the file one after the other, whatever they are written in.
class PlyNumbers {
 public:
  PlyNumbers(const std::filesystem::path& file, const PlyHeader& header, std::string_view bytes)
      : file_(&file),
        encoding_(header.encoding),
        all_(bytes),
        at_(header.bytes),
        line_(header.lines + 1) {}

  /// What is read next, for messages.
  void set_place(const char* element, std::uint64_t number) {
    element_ = element, number_ = number;
  }

  [[noreturn]] void fail(const std::string& found, const std::string& expected) const {
    const std::string where = encoding_ == PlyEncoding::ascii ? fmt::format("line {}", line_)
                                                              : fmt::format("byte {}", at_);
    throw Error(fmt::format("{}: {}, {} {}: found {}; expected {}", file_->string(), where,
                            element_, number_, found, expected));
  }

  /// Refuses so many numbers of a type if the rest of the file is too short to hold them.
  void need(std::uint64_t count, const PlyType& type) const {
    const std::uint64_t left = all_.size() - at_;
    const bool is_text = encoding_ == PlyEncoding::ascii;  // a blank between two numbers
    if (count > (is_text ? (left + 1) / 2 : left / std::uint64_t(type.bytes))) {
      fail(fmt::format("{} bytes to the end of the file", left),
           fmt::format("{} further numbers; the file may be cut off", count));
    }
  }

  double next(const PlyType& type) {
    if (encoding_ == PlyEncoding::ascii) return next_word();
    need(1, type);
    const auto size = std::size_t(type.bytes);
    std::uint64_t bits = 0;
    for (std::size_t i = 0; i < size; ++i) {
      const bool big = encoding_ == PlyEncoding::big_endian;
      bits = bits << 8 | std::uint8_t(all_[at_ + (big ? i : size - 1 - i)]);
    }
    at_ += size;
    return decode(type, bits);
  }

  /// A number that counts or numbers something, below `end`.
  std::uint64_t next_whole(const PlyType& type, std::uint64_t end, const char* what) {
    if (encoding_ == PlyEncoding::ascii) skip_blanks();
    const std::size_t begin = at_;
    const double value = next(type);
    if (!(value >= 0 && value < double(end) && value == std::floor(value))) {
      at_ = begin;
      fail(fmt::format("{} {}", what, value), fmt::format("0 to {}", double(end) - 1));
    }
    return std::uint64_t(value);
  }

  void skip(std::uint64_t count, const PlyType& type) {
    need(count, type);
    if (encoding_ != PlyEncoding::ascii) {
      at_ += std::size_t(count) * std::size_t(type.bytes);
    } else {
      for (std::uint64_t i = 0; i < count; ++i) (void)next_word();
    }
  }

 private:
  static constexpr std::string_view kBlanks = " \t\r\n";

  void skip_blanks() {
    for (; at_ < all_.size() && kBlanks.find(all_[at_]) != kBlanks.npos; ++at_) {
      if (all_[at_] == '\n') ++line_;
    }
  }

  double next_word() {
    skip_blanks();
    const std::size_t end = std::min(all_.find_first_of(kBlanks, at_), all_.size());
    const std::string_view word = all_.substr(at_, end - at_);
    const auto number = parse_number(word);
    if (word.empty()) fail("the end of the file", "a number; the file may be cut off");
    if (!number) fail(fmt::format("'{}'", shown(word)), "a number");
    at_ = end;
    return *number;
  }

  const std::filesystem::path* file_;
  PlyEncoding encoding_;
  std::string_view all_;
  std::size_t at_, line_;
  const char* element_ = "";
  std::uint64_t number_ = 0;
};

/// Of a list with at most as many values as the file has bytes.
std::uint64_t next_count(PlyNumbers& numbers, const PlyProperty& list) {
  const std::uint64_t count = numbers.next_whole(list.count, std::uint64_t(1) << 32, "a list of");
  numbers.need(count, list.type);
  return count;
}

void skip_property(PlyNumbers& numbers, const PlyProperty& p) {
  numbers.skip(p.is_list ? next_count(numbers, p) : 1, p.type);
}

void read_vertices(PlyNumbers& numbers, const PlyElement& element, PolygonMesh& mesh) {
  for (const char* axis : {"x", "y", "z"}) {
    const PlyProperty* p = element.find(axis);
    if (p == nullptr || p->is_list) {
      numbers.fail(fmt::format("vertices without {}", axis), "properties x, y and z");
    }
  }
  if (element.count > kMostVertices) {
    numbers.fail(fmt::format("{} vertices", element.count), "at most 2^32 - 1");
  }
  const PlyType least{1};
  numbers.need(3 * element.count, least);
  mesh.vertices.reserve(element.count);
  for (std::uint64_t i = 0; i < element.count; ++i) {
    numbers.set_place("vertex", i);
    Vec3d v;
    for (const PlyProperty& p : element.properties) {
      const int axis = p.name == "x" ? 0 : p.name == "y" ? 1 : p.name == "z" ? 2 : 3;
      if (axis == 3)
        skip_property(numbers, p);
      else
        v[axis] = numbers.next(p.type);
    }
    if (!is_finite(v)) {
      numbers.fail(fmt::format("({}, {}, {})", v.x, v.y, v.z), "finite coordinates before here");
    }
    mesh.vertices.push_back(v);
  }
}

void read_faces(PlyNumbers& numbers, const PlyElement& element, std::uint64_t vertices,
                Polygons& faces) {
  const PlyProperty* list = element.find("vertex_indices");
  if (list == nullptr) list = element.find("vertex_index");
  if (list == nullptr || !list->is_list || list->type.is_float) {
    numbers.fail("faces without vertices", "a list of integers vertex_indices (or vertex_index)");
  }
  for (std::uint64_t i = 0; i < element.count; ++i) {
    numbers.set_place("face", i);
    for (const PlyProperty& p : element.properties) {
      if (&p != list) {
        skip_property(numbers, p);
        continue;
      }
      const std::uint64_t count = next_count(numbers, p);
      if (vertices == 0) numbers.fail("a face", "no faces, since there are no vertices");
      if (count < 3) numbers.fail(fmt::format("{} vertices", count), "at least three");
      for (std::uint64_t c = 0; c < count; ++c) {
        faces.corners.push_back(
            std::uint32_t(numbers.next_whole(p.type, vertices, "the number of a vertex")));
      }
      faces.ends.push_back(faces.corners.size());
    }
  }
}

void skip_element(PlyNumbers& numbers, const PlyElement& element) {
  if (element.properties.empty()) return;
  for (std::uint64_t i = 0; i < element.count; ++i) {
    numbers.set_place("element", i);
    for (const PlyProperty& p : element.properties) skip_property(numbers, p);
  }
}

}  // namespace

PolygonMesh decode_ply(const std::filesystem::path& file, std::string_view bytes) {
  const PlyHeader header = decode_ply_header(file, bytes);
  PlyNumbers numbers(file, header, bytes);
  const auto element = [&](std::string_view name) {
    const auto found = std::ranges::find(header.elements, name, &PlyElement::name);
    return found == header.elements.end() ? nullptr : &*found;
  };
  const PlyElement* const vertices = element("vertex");
  if (vertices == nullptr || element("face") == nullptr) {
    throw Error(fmt::format("{}: has no element {}; expected elements vertex and face{}",
                            file.string(), vertices == nullptr ? "vertex" : "face",
                            element("tristrips") ? ", not strips: convert it to triangles" : ""));
  }
  PolygonMesh mesh;
  for (const PlyElement& e : header.elements) {
    numbers.set_place(e.name.c_str(), 0);
    if (e.name == "vertex")
      read_vertices(numbers, e, mesh);
    else if (e.name == "face")
      read_faces(numbers, e, vertices->count, mesh.faces);
    else
      skip_element(numbers, e);
  }
  return mesh;
}

}  // namespace pvol::formats::detail
