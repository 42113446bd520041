// The META chunk: where a cloud comes from, as JSON.
#include <fmt/format.h>

#include <charconv>
#include <nlohmann/json.hpp>

#include "pvol/error.h"
#include "pvol/pvol_chunks.h"

namespace pvol::formats::detail {
namespace {

using Json = nlohmann::json;

constexpr int kHashDigits = 16;
constexpr int kDeepestJson = 32;        // the parser has no limit, and printing overflows the stack
constexpr std::size_t kShownJson = 80;  // characters of a wrong value in messages

// JSON numbers are doubles to most readers, so that 64-bit hashes go as text.
std::string hex(std::uint64_t v) {
  std::string s(kHashDigits, '0');
  for (int i = kHashDigits - 1; i >= 0; --i, v >>= 4)
    s[std::size_t(i)] = "0123456789abcdef"[v & 15];
  return s;
}

/// An affine map that has an inverse.
bool is_usable(const Affine& a) {
  const Affine b = inverse(a);
  bool ok = is_finite(a.t) && is_finite(b.t);
  for (std::size_t r = 0; r < 3; ++r) ok = ok && is_finite(a.m[r]) && is_finite(b.m[r]);
  return ok;
}

Json to_json(const Affine& a) {
  Json rows = Json::array();
  for (int r = 0; r < 3; ++r) {
    const Vec3d& row = a.m[std::size_t(r)];
    rows.push_back({row.x, row.y, row.z, a.t[r]});
  }
  return rows;
}

/// How the density is kept, and how far that is off.
Json to_json(const Metadata& m) {
  const QuantisationError& e = m.quantisation_error;
  return {{"precision", name(m.quantisation.precision)},
          {"tolerance", m.quantisation.tolerance},
          {"absolute_error", e.absolute},
          {"relative_error", e.relative},
          {"mass_error", e.mass}};
}

/// A JSON object with checked access; `path` names it in errors.
struct Object {
  const Json& json;
  const std::string& place;
  std::string path;

  [[nodiscard]] const Json& at(const char* key) const {
    const auto found = json.find(key);
    if (found == json.end()) refuse(place, "the key " + path + key + " is missing");
    return *found;
  }

  [[noreturn]] void wrong(const char* key, const std::string& expected) const {
    std::string found = at(key).dump(-1, ' ', /*ensure_ascii=*/true);
    if (found.size() > kShownJson) found = found.substr(0, kShownJson) + "...";
    refuse(place, path + key + " is " + found + "; expected " + expected);
  }

  [[nodiscard]] std::string text(const char* key) const {
    if (!at(key).is_string()) wrong(key, "a string");
    return at(key).get<std::string>();
  }

  [[nodiscard]] std::uint64_t count(const char* key) const {
    if (!at(key).is_number_unsigned()) wrong(key, "a non-negative integer");
    return at(key).get<std::uint64_t>();
  }

  [[nodiscard]] double number(const char* key) const {
    if (!at(key).is_number()) wrong(key, "a number");
    return at(key).get<double>();
  }

  [[nodiscard]] std::uint64_t hash(const char* key) const {
    const std::string s = text(key);
    std::uint64_t v = 0;
    std::from_chars(s.data(), s.data() + s.size(), v, 16);
    if (s != hex(v)) wrong(key, "16 hexadecimal digits in lower case");
    return v;
  }

  [[nodiscard]] Object object(const char* key) const {
    if (!at(key).is_object()) wrong(key, "an object");
    return {at(key), place, path + key + "."};
  }

  [[nodiscard]] Affine map(const char* key) const {
    const char* expected = "three rows of four numbers that form an invertible map";
    const Json& rows = at(key);
    if (!rows.is_array() || rows.size() != 3) wrong(key, expected);
    Affine a;
    for (int r = 0; r < 3; ++r) {
      const Json& row = rows[std::size_t(r)];
      if (!row.is_array() || row.size() != 4) wrong(key, expected);
      for (const Json& v : row) {
        if (!v.is_number()) wrong(key, expected);
      }
      a.m[std::size_t(r)] = {row[0].get<double>(), row[1].get<double>(), row[2].get<double>()};
      a.t[r] = row[3].get<double>();
    }
    if (!is_usable(a)) wrong(key, expected);
    return a;
  }
};

void read_quantisation(const Object& density, Metadata& m) {
  const std::string precision = density.text("precision");
  for (const Precision p : {Precision::fp16, Precision::fp8, Precision::fpn}) {
    if (precision == name(p)) m.quantisation.precision = p;
  }
  if (m.quantisation.precision == Precision::fp32) density.wrong("precision", "fp16, fp8 or fpn");
  m.quantisation.tolerance = density.number("tolerance");
  m.quantisation_error = {density.number("absolute_error"), density.number("relative_error"),
                          density.number("mass_error")};
}

/// META's list of the interpolants for which bounds hold.
Json interpolants(LookUp made) {
  Json list = Json::array({"nearest", "trilinear"});
  if (made == LookUp::tricubic) list.push_back("tricubic");
  if (made == LookUp::procedural) list.push_back("procedural");
  return list;
}

LookUp look_up_of(const Object& root) {
  for (const auto made : {LookUp::trilinear, LookUp::tricubic, LookUp::procedural}) {
    if (root.at("interpolation") == interpolants(made)) return made;
  }
  root.wrong("interpolation",
             "[\"nearest\",\"trilinear\"] or that with \"tricubic\" or \"procedural\" at the end");
}

Json parse(const std::vector<char>& bytes, const std::string& place) {
  const auto check_depth = [&](int depth, Json::parse_event_t, const Json&) {
    if (depth <= kDeepestJson) return true;
    refuse(place, fmt::format("JSON of more than {} levels", kDeepestJson));
  };
  try {
    return Json::parse(bytes.begin(), bytes.end(), check_depth);
  } catch (const Json::exception& e) {
    refuse(place, std::string("not JSON (") + e.what() + ")");
  }
}

}  // namespace

std::string encode_metadata(const Metadata& m, LookUp bounds_made_for, const std::string& place) {
  if (!is_usable(m.index_to_world)) {
    throw Error(place + ": the map from index to world space has no inverse or is not finite.");
  }
  Json json;
  json["grid"] = m.grid_name;
  json["index_to_world"] = to_json(m.index_to_world);
  json["interpolation"] = interpolants(bounds_made_for);
  json["unit"] = m.unit;
  json["source"] = {{"file", m.source.file},
                    {"grid", m.source.grid},
                    {"bytes", m.source.bytes},
                    {"xxh3_64", hex(m.source.hash)}};
  if (m.source.non_finite > 0) json["source"]["non_finite"] = m.source.non_finite;
  if (m.source.negative > 0) json["source"]["negative"] = m.source.negative;
  if (!m.source.rounded_from.empty()) json["source"]["rounded_from"] = m.source.rounded_from;
  json["options"] = Json::object();
  for (const auto& [key, value] : m.options) json["options"][key] = value;
  json["written_by"] = m.written_by;
  if (m.quantisation.precision != Precision::fp32) json["density"] = to_json(m);
  try {
    std::string s = json.dump() + "\n";
    if (s.size() <= kMaxMetaBytes) return s;
  } catch (const Json::exception&) {
    throw Error(place + ": a name or an option is not UTF-8 text, which the file cannot hold.");
  }
  throw Error(fmt::format("{}: the metadata take more than {} bytes.", place, kMaxMetaBytes));
}

DecodedMetadata decode_metadata(ChunkReader& chunk) {
  if (chunk.raw_bytes() > kMaxMetaBytes) {
    refuse(chunk.place(),
           fmt::format("{} bytes; expected at most {}", chunk.raw_bytes(), kMaxMetaBytes));
  }
  std::vector<char> bytes(std::size_t(chunk.raw_bytes()));
  chunk.read(bytes);
  const Json json = parse(bytes, chunk.place());
  if (!json.is_object()) refuse(chunk.place(), "not a JSON object");

  const Object root{json, chunk.place(), ""};
  Metadata m;
  m.grid_name = root.text("grid");
  m.index_to_world = root.map("index_to_world");
  const LookUp bounds_made_for = look_up_of(root);
  m.unit = root.text("unit");
  const Object source = root.object("source");
  m.source.file = source.text("file");
  m.source.grid = source.text("grid");
  m.source.bytes = source.count("bytes");
  m.source.hash = source.hash("xxh3_64");
  if (source.json.contains("non_finite")) m.source.non_finite = source.count("non_finite");
  if (source.json.contains("negative")) m.source.negative = source.count("negative");
  if (source.json.contains("rounded_from")) m.source.rounded_from = source.text("rounded_from");
  const Object options = root.object("options");
  for (const auto& [key, value] : options.json.items()) {
    if (!value.is_string()) refuse(chunk.place(), "options." + key + " is not a string");
    m.options[key] = value.get<std::string>();
  }
  m.written_by = root.text("written_by");
  if (json.contains("density")) read_quantisation(root.object("density"), m);
  return {std::move(m), bounds_made_for};
}

}  // namespace pvol::formats::detail
