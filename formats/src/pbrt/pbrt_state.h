// What holds for the things that pbrt's directives make: transforms, medium, material.
#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "pbrt/pbrt_description.h"

namespace pvol::formats::detail {

struct PbrtState {
  Affine ctm{};                     ///< the current transform
  bool sets_start = true;           ///< whether transforms are those of the shutter's opening
  std::string inside{}, outside{};  ///< media
  PbrtThing material{};
  std::optional<std::string> material_name{};  ///< by NamedMaterial, whose place `material` has
  std::optional<PbrtThing> area_light{};
  bool reversed = false;
  std::map<std::string, std::vector<PbrtParameter>> defaults{};  ///< of Attribute, by target
};

/// From the world to a camera that looks along its +z with y up, x to the right.
[[nodiscard]] Affine look_at(Vec3d eye, Vec3d target, Vec3d up);

/// Turn by degrees about an axis of any length > 0, against the clock as seen from its tip in
/// right-handed coordinates.
[[nodiscard]] Affine rotation(double degrees, Vec3d axis);

/// Of 16 numbers, column by column, as Transform has them; nothing where the last row is not 0, 0,
/// 0 and a number.
[[nodiscard]] std::optional<Affine> affine_of(const std::vector<double>& numbers);

}  // namespace pvol::formats::detail
