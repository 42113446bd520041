#include "usda/usda_merge.h"

#include <algorithm>
#include <cstddef>
#include <iterator>
#include <set>

namespace pvol::formats::detail {
namespace {

using AttributePtr = std::shared_ptr<const UsdAttribute>;

template <class Item>
bool says_anything(const UsdList<Item>& list) {
  return list.replaces || !list.empty() || !list.gone.empty();
}

/// Does what a list says with a weaker one. What it names itself stays where it has it.
template <class Item>
void merge_list(UsdList<Item>& strong, const UsdList<Item>& weak) {
  if (strong.replaces || !says_anything(weak)) return;
  std::set<Item> named(strong.gone.begin(), strong.gone.end());
  named.insert(strong.first.begin(), strong.first.end());
  named.insert(strong.last.begin(), strong.last.end());
  const auto unnamed_of = [&](const std::vector<Item>& items) {
    std::vector<Item> unnamed;
    std::ranges::copy_if(items, std::back_inserter(unnamed),
                         [&](const Item& item) { return !named.contains(item); });
    return unnamed;
  };
  const std::vector<Item> first = unnamed_of(weak.first), gone = unnamed_of(weak.gone);
  const std::vector<Item> last = unnamed_of(weak.last);
  strong.first.insert(strong.first.end(), first.begin(), first.end());
  strong.last.insert(strong.last.begin(), last.begin(), last.end());
  strong.gone.insert(strong.gone.end(), gone.begin(), gone.end());
  strong.replaces = weak.replaces;
}

bool has_all_words(const UsdAttribute& strong, const UsdAttribute& weak) {
  return std::ranges::all_of(weak.words,
                             [&](const auto& word) { return strong.words.contains(word.first); });
}

/// A value covers weaker samples as well.
AttributePtr joined(const AttributePtr& strong, const AttributePtr& weak) {
  const bool takes_content = strong->content->empty() && !weak->content->empty();
  const bool takes_targets = !strong->targets.replaces && says_anything(weak->targets);
  if (!takes_content && !takes_targets && has_all_words(*strong, *weak)) return strong;
  UsdAttribute both = *strong;
  if (takes_content) both.content = weak->content, both.where = weak->where;
  merge_list(both.targets, weak->targets);
  both.words.insert(weak->words.begin(), weak->words.end());
  return std::make_shared<const UsdAttribute>(std::move(both));
}

/// Choices of variants are the strongest ones.
void merge_metadatum(UsdMetadatum& strong, const UsdMetadatum& weak) {
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

AttributePtr moved(const AttributePtr& attribute, const std::string& from, const std::string& to) {
  UsdAttribute copy = *attribute;
  for (auto* targets : {&copy.targets.first, &copy.targets.last, &copy.targets.gone}) {
    for (UsdTarget& t : *targets) move_path(t.path, from, to);
  }
  return std::make_shared<const UsdAttribute>(std::move(copy));
}

template <class Item>
std::size_t count_of(const UsdList<Item>& list) {
  return list.first.size() + list.last.size() + list.gone.size();
}

/// About as many bytes as a copy takes.
std::size_t bytes_of(const UsdAttribute& a) {
  const std::size_t count = count_of(a.targets);
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
  merge_list(strong.schemas, weak.schemas);
  merge_list(strong.inactive, weak.inactive);
  for (const auto& [kind, arcs] : weak.arcs) merge_list(strong.arcs[kind], arcs);
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
    if (count_of(attribute->targets) > 0) attribute = moved(attribute, from, to);
  }
  for (UsdPrim& child : prim.children) move_targets(child, from, to);
  for (UsdPrim& variant : prim.variants) move_targets(variant, from, to);
}

std::size_t bytes_of(const UsdPrim& prim) {
  std::size_t bytes = sizeof(UsdPrim) + 64 + prim.name.size();
  bytes += count_of(prim.schemas) * 64 + count_of(prim.inactive) * sizeof(double);
  for (const auto& [kind, arcs] : prim.arcs) bytes += 128 + count_of(arcs) * sizeof(UsdArc);
  for (const auto& [name, attribute] : prim.attributes) bytes += name.size() + bytes_of(*attribute);
  for (const auto& [name, metadatum] : prim.metadata) bytes += 64 + bytes_of(metadatum.value);
  for (const UsdPrim& child : prim.children) bytes += bytes_of(child);
  for (const UsdPrim& variant : prim.variants) bytes += bytes_of(variant);
  return bytes;
}

}  // namespace pvol::formats::detail
