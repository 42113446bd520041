#include "usda/usda_merge.h"

#include <algorithm>

namespace pvol::formats::detail {
namespace {

using AttributePtr = std::shared_ptr<const UsdAttribute>;

bool says_value(const UsdAttribute& a) { return a.value || !a.samples.empty(); }

/// A value covers weaker samples as well.
AttributePtr joined(const AttributePtr& strong, const AttributePtr& weak) {
  const bool takes_value = !says_value(*strong) && says_value(*weak);
  const bool takes_sources = strong->sources.empty() && !weak->sources.empty();
  if (!takes_value && !takes_sources) return strong;
  UsdAttribute both = *strong;
  if (takes_value) both.value = weak->value, both.samples = weak->samples;
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

/// The path under another one; false where it does not lie under `from`.
bool move_path(std::string& path, const std::string& from, const std::string& to) {
  const bool under =
      path.starts_with(from) &&
      (path.size() == from.size() || path[from.size()] == '/' || path[from.size()] == '.');
  if (under) path.replace(0, from.size(), to);
  return under;
}

AttributePtr moved(const AttributePtr& attribute, const std::string& from, const std::string& to) {
  UsdAttribute copy = *attribute;
  bool changed = false;
  if (copy.value) {
    if (auto* targets = std::get_if<UsdTargets>(&*copy.value)) {
      for (UsdTarget& t : targets->all) changed = move_path(t.path, from, to) || changed;
    }
  }
  for (UsdTarget& t : copy.sources) changed = move_path(t.path, from, to) || changed;
  return changed ? std::make_shared<const UsdAttribute>(std::move(copy)) : attribute;
}

bool has_targets(const UsdAttribute& a) {
  return !a.sources.empty() || (a.value && std::holds_alternative<UsdTargets>(*a.value));
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

std::size_t size_of(const UsdPrim& prim) {
  std::size_t size = 1 + prim.attributes.size();
  for (const UsdPrim& child : prim.children) size += size_of(child);
  for (const UsdPrim& variant : prim.variants) size += size_of(variant);
  return size;
}

}  // namespace pvol::formats::detail
