#include "usda/usda_view.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace pvol::formats::detail {
namespace {

/// Whether values between samples are mixed: of numbers that have a fraction.
bool is_mixed(const std::string& type) {
  for (const char* whole : {"int", "uint", "bool", "uchar", "rel", "token", "string", "asset"}) {
    if (type.starts_with(whole)) return false;
  }
  return true;
}

/// A unit quaternion, by the shorter turn.
void mix_turn(double* a, const double* b, double share) {
  double cosine = 0;
  for (std::size_t i = 0; i < 4; ++i) cosine += a[i] * b[i];
  const double sign = cosine < 0 ? -1 : 1, angle = std::acos(std::min(std::abs(cosine), 1.0));
  const double sine = std::sin(angle);
  const double from = sine > 1e-9 ? std::sin((1 - share) * angle) / sine : 1 - share;
  const double to = sine > 1e-9 ? std::sin(share * angle) / sine : share;
  for (std::size_t i = 0; i < 4; ++i) a[i] = from * a[i] + sign * to * b[i];
}

/// Arrays of different lengths are not mixed, as in USD.
UsdValue mixed(const UsdAttribute& attribute, const UsdValue& a, const UsdValue& b, double share) {
  const auto* from = std::get_if<UsdNumbers>(&a);
  const auto* to = std::get_if<UsdNumbers>(&b);
  if (from == nullptr || to == nullptr || from->all.size() != to->all.size() ||
      !is_mixed(attribute.type)) {
    return a;
  }
  UsdNumbers between = *from;
  if (attribute.type.starts_with("quat") && from->all.size() % 4 == 0) {
    for (std::size_t i = 0; i < between.all.size(); i += 4) {
      mix_turn(&between.all[i], &to->all[i], share);
    }
    return between;
  }
  for (std::size_t i = 0; i < between.all.size(); ++i) {
    between.all[i] += share * (to->all[i] - between.all[i]);
  }
  return between;
}

std::optional<UsdValue> unless_blocked(std::optional<UsdValue> value) {
  if (value && std::holds_alternative<UsdNone>(*value)) return std::nullopt;
  return value;
}

/// Declarations and arrays without elements do not.
bool says_something(const UsdContent& content) {
  if (content.empty() || !content.samples.empty()) return !content.empty();
  const auto* numbers = std::get_if<UsdNumbers>(&*content.value);
  return numbers == nullptr || !numbers->all.empty();
}

/// What renderers and programs have for themselves is named as one, as karma:*.
std::string group_of(const std::string& name) {
  const std::string first = name.substr(0, name.find(':'));
  const bool is_own = first == name || first == "inputs" || first == "primvars";
  return is_own ? name : first + ":*";
}

[[noreturn]] void fail_on(const UsdAttribute& a, const std::string& name, const std::string& found,
                          const std::string& expected) {
  fail_at(a.where, fmt::format("{} of {}", found, usd_shown(name)), expected);
}

}  // namespace

std::optional<UsdValue> value_at(const UsdAttribute& attribute, double frame) {
  const auto& samples = attribute.content->samples;
  if (samples.empty()) return unless_blocked(attribute.content->value);
  const auto after =
      std::ranges::upper_bound(samples, frame, {}, &std::pair<double, UsdValue>::first);
  if (after == samples.begin()) return unless_blocked(samples.front().second);
  const auto before = std::prev(after);
  if (after == samples.end()) return unless_blocked(before->second);
  const double share = (frame - before->first) / (after->first - before->first);
  if (!(share > 0)) return unless_blocked(before->second);
  return unless_blocked(mixed(attribute, before->second, after->second, share));
}

std::string file_of(const std::string& asset, const UsdWhere& where) {
  if (asset.empty()) return "";
  const std::filesystem::path folder = where.file ? where.file->parent_path() : "";
  return std::filesystem::absolute(folder / asset).lexically_normal().string();
}

const UsdAttribute* UsdView::find(const std::string& name) const {
  const auto found = prim_->attributes.find(name);
  if (found == prim_->attributes.end()) return nullptr;
  used_.insert(name);
  return found->second.get();
}

std::optional<UsdValue> UsdView::value(const std::string& name) const {
  const UsdAttribute* a = find(name);
  return a == nullptr ? std::nullopt : value_at(*a, frame_);
}

std::vector<double> UsdView::numbers(const std::string& name, std::size_t each) const {
  const std::optional<UsdValue> v = value(name);
  if (!v) return {};
  const UsdAttribute& a = *find(name);
  const auto* found = std::get_if<UsdNumbers>(&*v);
  if (found == nullptr) fail_on(a, name, "a value", "numbers");
  if (found->all.size() % each != 0) {
    fail_on(a, name, fmt::format("{} numbers", found->all.size()),
            fmt::format("{} for each element", each));
  }
  const bool finite = std::ranges::all_of(found->all, [](double x) { return std::isfinite(x); });
  if (!finite) fail_on(a, name, "a number", "finite numbers");
  return found->all;
}

double UsdView::number(const std::string& name, double otherwise) const {
  if (!says(name)) return otherwise;
  const std::vector<double> all = numbers(name);
  if (all.size() != 1) {
    fail_on(*find(name), name, fmt::format("{} numbers", all.size()), "one number");
  }
  return all.front();
}

bool UsdView::flag(const std::string& name, bool otherwise) const {
  return number(name, otherwise) != 0;
}

std::vector<std::string> UsdView::words(const std::string& name) const {
  const std::optional<UsdValue> v = value(name);
  if (!v) return {};
  if (const auto* found = std::get_if<UsdStrings>(&*v)) return found->all;
  const auto* none = std::get_if<UsdNumbers>(&*v);
  if (none == nullptr || !none->all.empty()) fail_on(*find(name), name, "a value", "strings");
  return {};
}

std::string UsdView::word(const std::string& name, const std::string& otherwise) const {
  const std::vector<std::string> all = words(name);
  return all.empty() ? otherwise : all.front();
}

std::vector<Vec3d> UsdView::vectors(const std::string& name) const {
  const std::vector<double> all = numbers(name, 3);
  std::vector<Vec3d> vectors;
  vectors.reserve(all.size() / 3);
  for (std::size_t i = 0; i < all.size(); i += 3) {
    vectors.emplace_back(all[i], all[i + 1], all[i + 2]);
  }
  return vectors;
}

Vec3d UsdView::vector(const std::string& name, Vec3d otherwise) const {
  if (!says(name)) return otherwise;
  const std::vector<Vec3d> all = vectors(name);
  if (all.size() != 1) {
    fail_on(*find(name), name, fmt::format("{} numbers", 3 * all.size()), "three numbers");
  }
  return all.front();
}

std::vector<std::string> UsdView::paths(const std::string& name) const {
  std::vector<std::string> paths;
  const UsdAttribute* a = find(name);
  if (a == nullptr) return paths;
  for (const UsdTarget& t : items_of(a->targets)) paths.push_back(t.path);
  return paths;
}

std::string UsdView::file(const std::string& name) const {
  const std::optional<UsdValue> v = value(name);
  if (!v) return "";
  const auto* targets = std::get_if<UsdTargets>(&*v);
  const bool one = targets != nullptr && targets->all.size() == 1;
  if (!one) fail_on(*find(name), name, "a value", "a file such as @cloud.vdb@");
  return file_of(targets->all.front().asset, find(name)->where);
}

void UsdView::note_unused(ImportNotes& notes) const {
  for (const auto& [name, attribute] : prim_->attributes) {
    // What all prims may have is read where they are met.
    const bool of_all = name.starts_with("xformOp") || name.starts_with("material:binding") ||
                        name == "visibility" || name == "purpose";
    const bool says = says_something(*attribute->content) || !attribute->targets.empty();
    if (of_all || !says || used_.contains(name)) continue;
    notes.add(attribute->where,
              fmt::format("{}: {} is left out", usd_shown(prim_->type), usd_shown(group_of(name))));
  }
}

}  // namespace pvol::formats::detail
