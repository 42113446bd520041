// What a prim is at a time.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "pvol/math/vec.h"
#include "usda/usda_prim.h"

namespace pvol::formats::detail {

/// The attributes of a prim at a frame: between samples they are mixed as USD does it, numbers that
/// have a fraction linearly, all else as it was before; before the first and after the last they
/// are as those. Getters mark what they find as used; `note_unused` names what nobody asked for.
/// Errors name the place of a value of another kind.
class UsdView {
 public:
  UsdView(const UsdPrim& prim, double frame) : prim_(&prim), frame_(frame) {}

  [[nodiscard]] const UsdPrim& prim() const { return *prim_; }
  [[nodiscard]] const UsdWhere& where() const { return prim_->where; }
  [[nodiscard]] double frame() const { return frame_; }

  /// The attribute of a name, or null.
  [[nodiscard]] const UsdAttribute* find(const std::string& name) const;
  /// Whether it says a value, at this time.
  [[nodiscard]] bool says(const std::string& name) const { return value(name).has_value(); }

  // What the attribute of a name says; without a value: what is given.
  [[nodiscard]] double number(const std::string& name, double otherwise) const;
  [[nodiscard]] bool flag(const std::string& name, bool otherwise) const;
  [[nodiscard]] std::string word(const std::string& name, const std::string& otherwise) const;
  [[nodiscard]] Vec3d vector(const std::string& name, Vec3d otherwise) const;

  /// All its numbers, so many for each element; none without it.
  [[nodiscard]] std::vector<double> numbers(const std::string& name, std::size_t each = 1) const;
  [[nodiscard]] std::vector<std::string> words(const std::string& name) const;
  [[nodiscard]] std::vector<Vec3d> vectors(const std::string& name) const;
  /// The prims that a relationship leads to.
  [[nodiscard]] std::vector<std::string> paths(const std::string& name) const;
  /// The file that it names, absolute; "" without one.
  [[nodiscard]] std::string file(const std::string& name) const;

  /// Marks attributes that do not change what pvol makes.
  void ignore(const std::string& name) const { used_.insert(name); }
  void note_unused(ImportNotes& notes) const;

 private:
  [[nodiscard]] std::optional<UsdValue> value(const std::string& name) const;

  const UsdPrim* prim_;
  double frame_;
  mutable std::set<std::string> used_{};
};

/// The value of an attribute at a frame; nothing where it has none or it is blocked.
[[nodiscard]] std::optional<UsdValue> value_at(const UsdAttribute& attribute, double frame);

/// The file of an asset, which is relative to the layer that says so.
[[nodiscard]] std::string file_of(const std::string& asset, const UsdWhere& where);

}  // namespace pvol::formats::detail
