// In place of OCIO configurations, where pvol is built without OpenColorIO.
#include "image/color_config.h"
#include "pvol/error.h"
#include "pvol/formats/screen.h"

namespace pvol::formats::detail {
namespace {

[[noreturn]] void fail(const std::string& what) {
  throw Error(what +
              ". Names of an OCIO configuration need OpenColorIO (Debian: libopencolorio-dev), "
              "without which this pvol was built");
}

}  // namespace

std::vector<std::string> views_of_config() { return {}; }

ScreenView find_view(const std::string& name, ColorSpace) {
  fail("there is no tone map '" + name + "'; expected srgb, neutral or filmic");
}

ColorSpace to_linear(std::span<Rgb>, const std::string& from) {
  std::string known;
  for (const std::string_view name : all_names<ColorSpace>()) {
    known += (known.empty() ? "" : ", ") + std::string(name);
  }
  fail("there is no colour space '" + from + "'; expected " + known);
}

}  // namespace pvol::formats::detail

std::string pvol::formats::color_config_id() { return {}; }
