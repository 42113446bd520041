// Scenes as usda text describes them: prims within prims, with attributes.
#pragma once

#include <compare>
#include <cstddef>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "usda/usda_where.h"

namespace pvol::formats::detail {

/// None: the value is blocked.
struct UsdNone {};
/// Numbers, tuples, matrices and arrays of them, one number after the other; true is 1.
struct UsdNumbers {
  std::vector<double> all{};
};
struct UsdStrings {
  std::vector<std::string> all{};
};
/// A file, a prim, or a prim of a file.
struct UsdTarget {
  std::string asset{}, path{};  ///< "": none
  bool is_retimed = false;      ///< whether its time is shifted or scaled
  auto operator<=>(const UsdTarget&) const = default;
};
struct UsdTargets {
  std::vector<UsdTarget> all{};
};
/// Only single strings are kept.
struct UsdDictionary {
  std::map<std::string, std::string> words{};
};
using UsdValue = std::variant<UsdNone, UsdNumbers, UsdStrings, UsdTargets, UsdDictionary>;

/// A list as a layer says it: what goes before and after that of weaker layers, and out of it.
template <class Item>
struct UsdList {
  std::vector<Item> first{}, last{}, gone{};
  bool replaces = false;  ///< whether nothing of weaker layers stays
  [[nodiscard]] bool empty() const { return first.empty() && last.empty(); }
};

/// Its items, the strongest first.
template <class Item>
[[nodiscard]] std::vector<Item> items_of(const UsdList<Item>& list) {
  std::vector<Item> all = list.first;
  all.insert(all.end(), list.last.begin(), list.last.end());
  return all;
}

struct UsdContent {
  std::optional<UsdValue> value{};
  std::vector<std::pair<double, UsdValue>> samples{};  ///< by time; they go before the value
  [[nodiscard]] bool empty() const { return !value && samples.empty(); }
};

/// An attribute, or a relationship, which has targets alone. Copies share what it says.
struct UsdAttribute {
  std::string type{};  ///< as "float3[]"; "rel" of a relationship
  UsdWhere where{};
  std::shared_ptr<const UsdContent> content = std::make_shared<const UsdContent>();
  UsdList<UsdTarget> targets{};                ///< what it is connected to, or leads to
  std::map<std::string, std::string> words{};  ///< metadata that are of use here
};

/// A datum about a prim or a layer.
struct UsdMetadatum {
  UsdValue value{};
  UsdWhere where{};
};

/// What else a prim is made of.
struct UsdArc {
  UsdTarget target{};       ///< a file, its absolute name, and a prim in it; "": its default prim
  std::ptrdiff_t kind = 0;  ///< the stronger ones have the lower numbers
  UsdWhere where{};
  std::strong_ordering operator<=>(const UsdArc& b) const { return target <=> b.target; }
};

struct UsdPrim {
  enum class Specifier { over, def, pattern };  ///< pattern: a class
  Specifier specifier = Specifier::over;
  std::string type{}, name{};
  UsdWhere where{};
  std::map<std::string, UsdMetadatum> metadata{};  ///< those that are of use here
  std::map<std::string, std::shared_ptr<const UsdAttribute>> attributes{};
  UsdList<std::string> schemas{};                    ///< that are applied to it
  UsdList<double> inactive{};                        ///< ids of a PointInstancer's instances
  std::map<std::ptrdiff_t, UsdList<UsdArc>> arcs{};  ///< by their kind
  std::vector<UsdPrim> children{};                   ///< each of another name
  std::vector<UsdPrim> variants{};  ///< of its variant sets, whose names are their types

  /// The child of a name, or null; valid until another one is added.
  [[nodiscard]] UsdPrim* child(const std::string& of_name);
  [[nodiscard]] const UsdPrim* child(const std::string& of_name) const;
  /// What is at a path below, "/World/cloud", or null; valid likewise.
  [[nodiscard]] const UsdPrim* at(const std::string& path) const;
  /// Adds one of a name that no other child has.
  UsdPrim& add(UsdPrim prim);

 private:
  std::map<std::string, std::size_t> by_name_{};
};

/// The word that a string of metadata says; "" without it.
[[nodiscard]] std::string word_of(const UsdPrim& prim, const std::string& metadatum);
/// The number; what is given without it.
[[nodiscard]] double number_of(const UsdPrim& prim, const std::string& metadatum, double otherwise);

/// A layer: a prim without a name, whose metadata are the layer's and whose children are its prims.
/// Sublayers are the arcs of the layer. What is of no use here is named in `notes`. Throws Error,
/// which names file, line and column, for what is not as the format has it.
[[nodiscard]] UsdPrim parse_usda(const std::filesystem::path& file, ImportNotes& notes);

}  // namespace pvol::formats::detail
