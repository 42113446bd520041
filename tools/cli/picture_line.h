// Options about pictures, for tools that write some.
#pragma once

#include "cli/command_line.h"
#include "cli/picture_output.h"
#include "pvol/error.h"
#include "pvol/formats/image.h"
#include "pvol/math/keys.h"

namespace pvol::cli {

/// An option with one of an enumeration's names.
template <class Enum>
Option add_named(const CommandLine& app, const char* flag, Enum& to, const char* help) {
  const auto keep = [&to](const std::string& text) { to = *find_named<Enum>(text); };
  return app.add_option_function(flag, keep, help).type_name("NAME").check(fits(name_of<Enum>()));
}

/// A tone map of ours, or a view of the OCIO configuration, which only then is read.
inline Check is_tone_map() {
  return {[](const std::string& text) -> std::string {
            try {
              formats::validate({.tone_map = text});
              return {};
            } catch (const Error& e) {
              return e.what();
            }
          },
          fits(name_of<formats::ToneMap>()).words};
}

/// How a .png shows light.
inline void add_display(const CommandLine& app, formats::Display& display) {
  app.add_option("--exposure", display.exposure, "Exposure of the .png in stops (EV) [0]")
      .type_name("EV")
      .check(number_from(-100, 100, "a number from -100 to 100"));
  app.add_option("--tone-map", display.tone_map,
                 "How the .png shows radiance above the screen's white: srgb clips it, neutral "
                 "(Khronos) and filmic (Hable) compress it; or a view of the OCIO configuration "
                 "that $OCIO names, such as 'ACES 1.0' of the built-in one [srgb]")
      .type_name("NAME")
      .check(is_tone_map());
}

/// Names of a picture that is made of others; `help` is that of --output.
inline void add_output(const CommandLine& app, PictureOutput& to, const char* help) {
  app.add_option("-o,--output", to.exr, help).type_name("FILE").required();
  app.add_option("--png", to.png, "Name of the .png [the output's, ending in .png]")
      .type_name("FILE");
  app.add_flag("--no-png", to.no_png, "Write no .png");
  add_display(app, to.display);
}

}  // namespace pvol::cli
