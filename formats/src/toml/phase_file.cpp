#include "toml/phase_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <string>

#include "pvol/error.h"

namespace pvol::formats {
namespace {

namespace fs = std::filesystem;

constexpr std::uintmax_t kLargestFile = std::uintmax_t{4} << 20;
constexpr std::size_t kShownLine = 40;  // bytes of a line that is refused

[[noreturn]] void refuse(const std::string& where, const std::string& found,
                         const std::string& expected) {
  throw Error(fmt::format("{}: {}; expected {}", where, found, expected));
}

/// Takes the first word of a line, up to a blank or comma, as a number.
bool take_number(std::string_view& line, double& number) {
  line.remove_prefix(std::min(line.find_first_not_of(" \t"), line.size()));
  const auto [end, error] = std::from_chars(line.data(), line.data() + line.size(), number);
  line.remove_prefix(std::size_t(end - line.data()));
  return error == std::errc{} && std::isfinite(number) &&
         (line.empty() || line.find_first_of(" \t,") == 0);
}

/// Angle and value of a line.
std::array<double, 2> read_point(std::string_view line, const std::string& where) {
  const std::string_view whole = line.substr(0, kShownLine);
  std::array<double, 2> point{};
  bool ok = take_number(line, point[0]);
  line.remove_prefix(std::min(line.find_first_not_of(" \t"), line.size()));
  if (line.starts_with(',')) line.remove_prefix(1);
  ok = ok && take_number(line, point[1]);
  if (!ok || line.find_first_not_of(" \t") != line.npos) {
    refuse(where, "found " + toml_string(whole),
           "an angle in degrees and a value, as in 12.5 0.03");
  }
  if (point[0] < 0 || point[0] > 180) {
    refuse(where, fmt::format("the angle is {}", point[0]), "degrees in [0, 180]");
  }
  if (point[1] < 0)
    refuse(where, fmt::format("the value is {}", point[1]), "a number of at least 0");
  return point;
}

/// The points of a file, each with its place.
TomlArray read_points(const std::string& file, const std::string& name) {
  std::ifstream stream(file, std::ios::binary);
  TomlArray points;
  double before = -1;
  std::string text;
  for (std::size_t number = 1; std::getline(stream, text); ++number) {
    std::string_view line = std::string_view(text).substr(0, text.find('#'));
    if (line.ends_with('\r')) line.remove_suffix(1);
    if (line.find_first_not_of(" \t") == line.npos) continue;
    const std::string where = fmt::format("{}:{}", file, number);
    const std::array<double, 2> point = read_point(line, where);
    if (point[0] <= before) {
      refuse(where, fmt::format("the angle is {} after {}", point[0], before),
             "ascending angles: sort the lines and remove duplicates");
    }
    before = point[0];
    const std::string point_name = fmt::format("{}[{}]", name, points.size() + 1);
    TomlArray pair;
    for (const double v : point) {
      pair.push_back({"", fmt::format("{}[{}]", point_name, pair.size() + 1), "", where, v});
    }
    points.push_back({"", point_name, "", where, std::move(pair)});
  }
  if (stream.bad()) throw Error(file + ": reading failed; check the disk");
  if (points.empty()) refuse(file, "has no points", "lines of an angle in degrees and a value");
  return points;
}

void load(TomlValue& value) {
  const std::string file = std::get<std::string>(value.value);
  const std::string named =
      fmt::format("{}: {} names {}", value.where, value.name, toml_string(file));
  std::error_code ignored;
  if (!fs::is_regular_file(file, ignored) || !std::ifstream(file)) {
    throw Error(named + ", which cannot be read; check the name and its permissions");
  }
  if (fs::file_size(file, ignored) > kLargestFile) {
    throw Error(named + ", which has more than 4 MiB; reduce the number of points");
  }
  value.value = read_points(file, value.name);
  value.where = file;
}

}  // namespace

void load_phase_files(TomlTable& table) {
  for (TomlValue& member : table.members) {
    if (member.key == kPhaseTable) {
      if (std::holds_alternative<std::string>(member.value)) {
        load(member);
      } else if (!std::holds_alternative<TomlArray>(member.value)) {
        table.fail(kPhaseTable, "an array of points [angle, value], or the name of a file of them");
      }
    } else if (auto* inner = std::get_if<TomlTable>(&member.value)) {
      load_phase_files(*inner);
    } else if (auto* array = std::get_if<TomlArray>(&member.value)) {
      for (TomlValue& item : *array) {
        if (auto* row = std::get_if<TomlTable>(&item.value)) load_phase_files(*row);
      }
    }
  }
}

}  // namespace pvol::formats
