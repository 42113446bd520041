#include "usda/usda_merge.h"

#include <algorithm>

namespace pvol::formats::detail {
namespace {

using AttributePtr = std::shared_ptr<const UsdAttribute>;

/// A value covers weaker samples as well.
AttributePtr joined(const AttributePtr& strong, const AttributePtr& weak) {
  const bool takes_content = strong->content->empty() && !weak->content->empty();
  const bool takes_sources = strong->sources.empty() && !weak->sources.empty();
  if (!takes_content && !takes_sources) return strong;
  UsdAttribute both = *strong;
  if (takes_content) both.content = weak->content, both.where = weak->where;
  if (takes_sources) both.sources = weak->sources;
  return std::make_shared<const UsdAttribute>(std::move(both));
}

/// Schemas are those of all layers, choices of variants the strongest ones.
void merge_metadatum(UsdMetadatum& strong, const UsdMetadatum& weak) {
  auto* strings = std::get_if<UsdStrings>(&strong.value);
  const auto* more = std::get_if<UsdStrings>(&weak.value);
  if (strings != nullptr && more != nullptr) {
    strings->all.insert(strings->all.end(), more->all.begin(), more->all.end());
  }
  auto* table = std::get_if<UsdDictionary>(&strong.value);
  const auto* rest = std::get_if<UsdDictionary>(&weak.value);
  if (table != nullptr && rest != nullptr)
    table->words.insert(rest->words.begin(), rest->words.end());
}

/// Moves what lies under a path to another.
void move_path(std::string& path, const std::string& from, const std::string& to) {
  const bool under =
      path.starts_with(from) &&
      (path.size() == from.size() || path[from.size()] == '/' || path[from.size()] == '.');
  if (under) path.replace(0, from.size(), to);
}

/// The targets of a relationship; null of all else.
const UsdTargets* targets_of(const UsdAttribute& a) {
  return a.type == "rel" && a.content->value ? std::get_if<UsdTargets>(&*a.content->value)
                                             : nullptr;
}

AttributePtr moved(const AttributePtr& attribute, const std::string& from, const std::string& to) {
  UsdAttribute copy = *attribute;
  if (const UsdTargets* targets = targets_of(copy)) {
    UsdTargets changed = *targets;
    for (UsdTarget& t : changed.all) move_path(t.path, from, to);
    copy.content = std::make_shared<const UsdContent>(UsdContent{std::move(changed), {}});
  }
  for (UsdTarget& t : copy.sources) move_path(t.path, from, to);
  return std::make_shared<const UsdAttribute>(std::move(copy));
}

bool has_targets(const UsdAttribute& a) { return !a.sources.empty() || targets_of(a) != nullptr; }

/// About as many bytes as a copy takes.
std::size_t bytes_of(const UsdAttribute& a) {
  const UsdTargets* targets = targets_of(a);
  const std::size_t count = a.sources.size() + (targets == nullptr ? 0 : targets->all.size());
  return 64 + (count == 0 ? 0 : 256 + count * sizeof(UsdTarget));
}

std::size_t bytes_of(const UsdValue& value) {
  if (const auto* strings = std::get_if<UsdStrings>(&value)) return strings->all.size() * 64;
  if (const auto* table = std::get_if<UsdDictionary>(&value)) return table->words.size() * 128;
  if (const auto* numbers = std::get_if<UsdNumbers>(&value)) return numbers->all.size() * 8;
  return 64;
}

}  // namespace

void merge(UsdPrim& strong, UsdPrim weak) {
  using Specifier = UsdPrim::Specifier;
  if (strong.specifier == Specifier::over) strong.specifier = weak.specifier;
  if (strong.type.empty()) strong.type = weak.type;
  for (const auto& [name, metadatum] : weak.metadata) {
    const auto [at, is_new] = strong.metadata.try_emplace(name, metadatum);
    if (!is_new) merge_metadatum(at->second, metadatum);
  }
  for (const auto& [name, attribute] : weak.attributes) {
    const auto [at, is_new] = strong.attributes.try_emplace(name, attribute);
    if (!is_new) at->second = joined(at->second, attribute);
  }
  strong.arcs.insert(strong.arcs.end(), weak.arcs.begin(), weak.arcs.end());
  for (UsdPrim& child : weak.children) {
    UsdPrim* own = strong.child(child.name);
    if (own != nullptr) {
      merge(*own, std::move(child));
    } else {
      strong.add(std::move(child));
    }
  }
  for (UsdPrim& variant : weak.variants) strong.variants.push_back(std::move(variant));
}

void move_targets(UsdPrim& prim, const std::string& from, const std::string& to) {
  for (auto& [name, attribute] : prim.attributes) {
    if (has_targets(*attribute)) attribute = moved(attribute, from, to);
  }
  for (UsdPrim& child : prim.children) move_targets(child, from, to);
  for (UsdPrim& variant : prim.variants) move_targets(variant, from, to);
}

std::size_t bytes_of(const UsdPrim& prim) {
  std::size_t bytes = sizeof(UsdPrim) + 64 + prim.name.size() + prim.arcs.size() * sizeof(UsdArc);
  for (const auto& [name, attribute] : prim.attributes) bytes += name.size() + bytes_of(*attribute);
  for (const auto& [name, metadatum] : prim.metadata) bytes += 64 + bytes_of(metadatum.value);
  for (const UsdPrim& child : prim.children) bytes += bytes_of(child);
  for (const UsdPrim& variant : prim.variants) bytes += bytes_of(variant);
  return bytes;
}

}  // namespace pvol::formats::detail
