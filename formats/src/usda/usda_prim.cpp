#include "usda/usda_prim.h"

#include <algorithm>

namespace pvol::formats::detail {

UsdPrim* UsdPrim::child(const std::string& of_name) {
  const auto found = by_name_.find(of_name);
  return found == by_name_.end() ? nullptr : &children[found->second];
}

const UsdPrim* UsdPrim::child(const std::string& of_name) const {
  const auto found = by_name_.find(of_name);
  return found == by_name_.end() ? nullptr : &children[found->second];
}

const UsdPrim* UsdPrim::at(const std::string& path) const {
  const UsdPrim* prim = this;
  for (std::size_t at = 1; prim != nullptr && at < path.size();) {
    const std::size_t end = std::min(path.find('/', at), path.size());
    prim = prim->child(path.substr(at, end - at));
    at = end + 1;
  }
  return prim == this ? nullptr : prim;
}

UsdPrim& UsdPrim::add(UsdPrim prim) {
  by_name_.emplace(prim.name, children.size());
  return children.emplace_back(std::move(prim));
}

std::string word_of(const UsdPrim& prim, const std::string& metadatum) {
  const auto found = prim.metadata.find(metadatum);
  if (found == prim.metadata.end()) return "";
  const auto* words = std::get_if<UsdStrings>(&found->second.value);
  return words == nullptr || words->all.empty() ? "" : words->all.front();
}

double number_of(const UsdPrim& prim, const std::string& metadatum, double otherwise) {
  const auto found = prim.metadata.find(metadatum);
  if (found == prim.metadata.end()) return otherwise;
  const auto* numbers = std::get_if<UsdNumbers>(&found->second.value);
  return numbers == nullptr || numbers->all.empty() ? otherwise : numbers->all.front();
}

}  // namespace pvol::formats::detail
