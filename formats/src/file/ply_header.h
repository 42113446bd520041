// What the header of a PLY file announces.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

namespace pvol::formats::detail {

enum class PlyEncoding { ascii, little_endian, big_endian };

/// Numbers of one to eight bytes.
struct PlyType {
  int bytes = 4;
  bool is_signed = true, is_float = false;
};

struct PlyProperty {
  std::string name;
  PlyType type{};  ///< of the value, or of each value of a list
  bool is_list = false;
  PlyType count{};  ///< of a list
};

struct PlyElement {
  std::string name;
  std::uint64_t count = 0;
  std::vector<PlyProperty> properties;

  /// The first property of that name, or null.
  [[nodiscard]] const PlyProperty* find(std::string_view property) const;
};

struct PlyHeader {
  PlyEncoding encoding = PlyEncoding::ascii;
  std::vector<PlyElement> elements;
  std::size_t bytes = 0;  ///< of the header: where the data begin
  std::size_t lines = 0;
};

/// Throws Error, which names file and line, for a header that is none. Numbers of elements are what
/// the header says, not checked against the file.
[[nodiscard]] PlyHeader decode_ply_header(const std::filesystem::path& file,
                                          std::string_view bytes);

}  // namespace pvol::formats::detail
