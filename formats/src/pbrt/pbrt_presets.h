// Matter that pbrt knows by name.
#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "pvol/math/vec.h"

namespace pvol::formats::detail {

/// Cross sections per mm, with scattering as if it were isotropic.
struct PbrtPreset {
  const char* name;
  Rgb scattering, absorption;
};

/// The one of a name; nothing of others.
[[nodiscard]] std::optional<PbrtPreset> preset_of(std::string_view name);

/// All names, for messages.
[[nodiscard]] std::string preset_names();

}  // namespace pvol::formats::detail
