// Groups of lights: those of one name share a layer in pictures.
#pragma once

#include <string_view>

#include "pvol/math/keys.h"

namespace pvol {

/// Whether a layer may have this name in files without being taken for another: letters, digits and
/// underscores, and neither a colour channel's nor an AOV's.
[[nodiscard]] bool is_group_name(std::string_view name);

[[nodiscard]] inline const char* expect_group(const Value& v) {
  const std::string* name = v.word();
  return name->empty() || is_group_name(*name)
             ? nullptr
             : "letters, digits and underscores, and not the name of another layer or channel";
}

/// The row of a light's group, for `--aov lights`.
template <auto kMember>
[[nodiscard]] constexpr auto group_key() {
  return key<kMember>({.key = "group",
                       .metavar = "NAME",
                       .limits = any_text().also(expect_group),
                       .help = "Name of the layer that all lights of this group share with --aov "
                               "lights; sky is the layer of the sky"});
}

}  // namespace pvol
