#include "pbrt/pbrt_params.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "file/mesh_read.h"

namespace pvol::formats::detail {
namespace {

const std::vector<double>& some_numbers(const PbrtParameter& p, std::size_t count) {
  if (p.numbers.size() < count) {
    fail_at(
        p.where,
        fmt::format("\"{} {}\" with {} numbers", shown(p.type), shown(p.name), p.numbers.size()),
        fmt::format("at least {}", count));
  }
  return p.numbers;
}

const std::string& some_string(const PbrtParameter& p) {
  if (p.strings.empty()) {
    fail_at(p.where, fmt::format("\"{} {}\"", shown(p.type), shown(p.name)),
            "a string in quotation marks");
  }
  return p.strings.front();
}

}  // namespace

void PbrtParameters::add(PbrtParameter parameter) {
  for (const PbrtParameter& p : all_) {
    if (p.name != parameter.name) continue;
    fail_at(parameter.where, fmt::format("\"{}\" a second time", shown(p.name)),
            "each parameter of a directive once");
  }
  all_.push_back(std::move(parameter));
  used_.push_back(false);
}

const PbrtParameter* PbrtParameters::find(std::string_view name) const {
  const auto found = std::ranges::find(all_, name, &PbrtParameter::name);
  if (found == all_.end()) return nullptr;
  used_[std::size_t(found - all_.begin())] = true;
  return &*found;
}

double PbrtParameters::number(std::string_view name, double otherwise) const {
  const PbrtParameter* p = find(name);
  return p ? some_numbers(*p, 1).front() : otherwise;
}

int PbrtParameters::whole(std::string_view name, int otherwise) const {
  constexpr double kMost = 1 << 30;
  const PbrtParameter* p = find(name);
  if (p == nullptr) return otherwise;
  const double value = some_numbers(*p, 1).front();
  if (value != std::floor(value) || std::abs(value) > kMost) {
    fail_at(p->where, fmt::format("{} {}", shown(name), value), "a whole number");
  }
  return int(value);
}

std::string PbrtParameters::word(std::string_view name, const std::string& otherwise) const {
  const PbrtParameter* p = find(name);
  return p ? some_string(*p) : otherwise;
}

bool PbrtParameters::flag(std::string_view name, bool otherwise) const {
  const PbrtParameter* p = find(name);
  return p ? some_string(*p) == "true" : otherwise;
}

Vec3d PbrtParameters::point(std::string_view name, Vec3d otherwise) const {
  const PbrtParameter* p = find(name);
  if (p == nullptr) return otherwise;
  const std::vector<double>& n = some_numbers(*p, 3);
  return {n[0], n[1], n[2]};
}

std::vector<double> PbrtParameters::numbers(std::string_view name) const {
  const PbrtParameter* p = find(name);
  return p ? p->numbers : std::vector<double>{};
}

std::vector<Vec3d> PbrtParameters::points(std::string_view name) const {
  const PbrtParameter* p = find(name);
  std::vector<Vec3d> all;
  if (p == nullptr) return all;
  const std::vector<double>& n = p->numbers;
  if (n.size() % 3 != 0) {
    fail_at(p->where, fmt::format("{} numbers in {}", n.size(), shown(name)), "three for a point");
  }
  for (std::size_t i = 0; i < n.size(); i += 3) all.push_back({n[i], n[i + 1], n[i + 2]});
  return all;
}

void PbrtParameters::note_unused(ImportNotes& notes, const std::string& what) const {
  for (std::size_t i = 0; i < all_.size(); ++i) {
    if (used_[i]) continue;
    notes.add(all_[i].where, fmt::format("{}: \"{}\" is left out", what, shown(all_[i].name)));
  }
}

}  // namespace pvol::formats::detail
