// Parameters of pbrt's directives: "float fov" 45, "rgb L" [1 2 3], and so on.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "file/import_notes.h"
#include "pbrt/pbrt_tokens.h"
#include "pvol/math/vec.h"

namespace pvol::formats::detail {

struct PbrtParameter {
  std::string type, name;
  PbrtWhere where;
  std::vector<double> numbers;       ///< of numeric types, all finite
  std::vector<std::string> strings;  ///< of others; "true" and "false" of bool
};

/// The parameters of a directive. Getters mark what they find as used; `note_unused` names what
/// nobody asked for.
class PbrtParameters {
 public:
  void add(PbrtParameter parameter);

  /// The parameter of a name, or null.
  [[nodiscard]] const PbrtParameter* find(std::string_view name) const;

  // The first value of the parameter of that name; without: what is given. Errors name the place of
  // a parameter of another type or without a value.
  [[nodiscard]] double number(std::string_view name, double otherwise) const;
  [[nodiscard]] int whole(std::string_view name, int otherwise) const;
  [[nodiscard]] std::string word(std::string_view name, const std::string& otherwise) const;
  [[nodiscard]] bool flag(std::string_view name, bool otherwise) const;
  [[nodiscard]] Vec3d point(std::string_view name, Vec3d otherwise) const;

  /// All its numbers; none without the parameter.
  [[nodiscard]] std::vector<double> numbers(std::string_view name) const;
  /// The same of places, three numbers each.
  [[nodiscard]] std::vector<Vec3d> points(std::string_view name) const;

  /// Names the parameters that were not asked for, as "<what> <name>".
  void note_unused(ImportNotes& notes, const std::string& what) const;

 private:
  std::vector<PbrtParameter> all_;
  mutable std::vector<bool> used_;
};

/// A thing of a scene: its type, as "perspective", and its parameters.
struct PbrtThing {
  std::string type;
  PbrtParameters parameters;
  PbrtWhere where;
};

}  // namespace pvol::formats::detail
