// Options about pictures, for tools that write some.
#pragma once

#include "cli/command_line.h"
#include "pvol/formats/image.h"
#include "pvol/math/keys.h"

namespace pvol::cli {

/// An option with one of an enumeration's names.
template <class Enum>
Option add_named(const CommandLine& app, const char* flag, Enum& to, const char* help) {
  const auto keep = [&to](const std::string& text) { to = *find_named<Enum>(text); };
  return app.add_option_function(flag, keep, help).type_name("NAME").check(fits(name_of<Enum>()));
}

/// How a .png shows light.
inline void add_display(const CommandLine& app, double& exposure, formats::ToneMap& tone_map) {
  app.add_option("--exposure", exposure, "Exposure of the .png in stops (EV) [0]")
      .type_name("EV")
      .check(number_from(-100, 100, "a number from -100 to 100"));
  add_named(app, "--tone-map", tone_map,
            "How the .png shows radiance above the screen's white: srgb clips it, neutral "
            "(Khronos) and filmic (Hable) compress it [srgb]");
}

}  // namespace pvol::cli
