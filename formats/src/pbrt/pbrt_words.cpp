#include "pbrt/pbrt_words.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "file/mesh_read.h"
#include "file/parse_number.h"
#include "pvol/error.h"

namespace pvol::formats::detail {
namespace {

constexpr std::size_t kDeepestFile = 64;  // files that include each other
constexpr std::size_t kMostFiles = 4096;  // read in all: a few lines could ask for endless work

constexpr std::array kNumeric{"integer", "float",  "point2",  "vector2", "point3", "point",
                              "vector3", "vector", "normal3", "normal",  "rgb",    "blackbody"};
constexpr std::array kOthers{"bool", "string", "texture", "spectrum"};

bool is_one_of(const auto& names, std::string_view name) {
  return std::ranges::find(names, name) != names.end();
}

}  // namespace

PbrtWords::PbrtWords(const std::filesystem::path& file)
    : folder_(file.parent_path()), named_{file} {
  files_.emplace_back(file);
  token_.where = files_.back().where();
}

bool PbrtWords::next() {
  if (ahead_) {
    ahead_ = false;
    return true;
  }
  while (!files_.empty()) {
    if (const auto found = files_.back().next()) {
      token_ = *found;
      return true;
    }
    last_ = files_.back().where();
    files_.pop_back();
  }
  return false;
}

const PbrtToken& PbrtWords::need(const char* expected) {
  if (!next()) fail_at(last_, "the end of the file", expected);
  return token_;
}

bool PbrtWords::next_is(PbrtToken::Kind kind) {
  ahead_ = next();
  return ahead_ && token_.kind == kind;
}

double PbrtWords::number() {
  const PbrtToken& t = need("a number");
  const auto value = t.kind == PbrtToken::Kind::word ? parse_number(t.text) : std::nullopt;
  if (!value || !std::isfinite(*value)) {
    fail_at(t.where, fmt::format("'{}'", shown(t.text)), "a finite number");
  }
  return *value;
}

Vec3d PbrtWords::vector() {
  const double x = number(), y = number();
  return {x, y, number()};
}

std::string PbrtWords::string(const char* expected) {
  const PbrtToken& t = need(expected);
  if (t.kind != PbrtToken::Kind::string) {
    fail_at(t.where, fmt::format("'{}'", shown(t.text)),
            std::string(expected) + " in quotation marks");
  }
  return std::string(t.text);
}

std::vector<double> PbrtWords::matrix() {
  const bool bracket = next_is(PbrtToken::Kind::open);
  if (bracket) next();
  std::vector<double> all(16);
  for (double& n : all) n = number();
  if (bracket && need("]").kind != PbrtToken::Kind::close) {
    fail_at(token_.where, fmt::format("'{}'", shown(token_.text)), "16 numbers and then ]");
  }
  return all;
}

void PbrtWords::value(PbrtParameter& p) {
  const PbrtToken& t = token_;
  const bool strings = !is_one_of(kNumeric, p.type);
  if (t.kind == PbrtToken::Kind::string && strings) {
    p.strings.emplace_back(t.text);
  } else if (t.kind == PbrtToken::Kind::word && p.type == "bool" &&
             (t.text == "true" || t.text == "false")) {
    p.strings.emplace_back(t.text);
  } else {
    const auto n = t.kind == PbrtToken::Kind::word ? parse_number(t.text) : std::nullopt;
    if (!n || !std::isfinite(*n) || (strings && p.type != "spectrum")) {
      fail_at(t.where, fmt::format("'{}'", shown(t.text)),
              fmt::format("a value of \"{} {}\"", p.type, shown(p.name)));
    }
    p.numbers.push_back(*n);
  }
}

PbrtParameter PbrtWords::parameter() {
  const std::string_view said = token_.text;
  const std::size_t begin = said.find_first_not_of(" \t");
  const std::size_t end = std::min(said.find_first_of(" \t", begin), said.size());
  const std::size_t name = said.find_first_not_of(" \t", end);
  PbrtParameter p{.type = {}, .name = {}, .where = token_.where, .numbers = {}, .strings = {}};
  if (begin != said.npos) p.type = said.substr(begin, end - begin);
  if (name != said.npos) {
    p.name = said.substr(name, said.find_last_not_of(" \t") + 1 - name);
  }
  if (p.name.empty() || (!is_one_of(kNumeric, p.type) && !is_one_of(kOthers, p.type))) {
    fail_at(p.where, fmt::format("\"{}\"", shown(said)),
            "a parameter such as \"float fov\", of type integer, float, point2, point3, vector3, "
            "normal, rgb, blackbody, spectrum, bool, string or texture");
  }
  if (need("the parameter's value").kind != PbrtToken::Kind::open) {
    value(p);
    return p;
  }
  while (need("]").kind != PbrtToken::Kind::close) value(p);
  return p;
}

std::vector<PbrtParameter> PbrtWords::parameters() {
  std::vector<PbrtParameter> all;
  while (next_is(PbrtToken::Kind::string)) {
    next();
    all.push_back(parameter());
    const PbrtParameter& p = all.back();
    if (p.name == "filename" && !p.strings.empty()) named_.push_back(folder_ / p.strings.front());
  }
  return all;
}

void PbrtWords::include(const std::string& name, const PbrtWhere& where) {
  std::filesystem::path file = folder_ / name;
  if (!std::filesystem::exists(file)) file = files_.back().file().parent_path() / name;
  if (files_.size() == kDeepestFile || ++read_ == kMostFiles) {
    fail_at(where, fmt::format("\"{}\" after {} files", shown(name), read_),
            "files that do not include each other, 4096 at most");
  }
  try {
    files_.emplace_back(file);
    named_.push_back(file);
  } catch (const Error& e) {
    throw Error(where.text() + ": " + e.what());
  }
}

}  // namespace pvol::formats::detail
