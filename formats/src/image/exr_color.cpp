#include "image/exr_color.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <ImfChromaticities.h>
#include <ImfStandardAttributes.h>

#include "pvol/error.h"

namespace pvol::formats::detail {

Primaries primaries_of(const Imf::Header& header) {
  if (!Imf::hasChromaticities(header)) return pvol::primaries_of(ColorSpace::rec709);
  const Imf::Chromaticities& c = Imf::chromaticities(header);
  const auto of = [](const Imath::V2f& v) { return Chromaticity{double(v.x), double(v.y)}; };
  return {of(c.red), of(c.green), of(c.blue), of(c.white)};
}

ColorSpace space_of(const Imf::Header& header) {
  const Primaries p = primaries_of(header);
  if (const auto space = find_space(p)) return *space;
  throw Error(fmt::format(
      "has primaries of no colour space that is known here (red {:g}, {:g}; green {:g}, "
      "{:g}; blue {:g}, {:g}; white {:g}, {:g}); convert it to one of {}",
      p.red.x, p.red.y, p.green.x, p.green.y, p.blue.x, p.blue.y, p.white.x, p.white.y,
      fmt::join(all_names<ColorSpace>(), ", ")));
}

void add_primaries(ColorSpace space, Imf::Header& header) {
  const Primaries p = pvol::primaries_of(space);
  const auto of = [](Chromaticity c) { return Imath::V2f(float(c.x), float(c.y)); };
  Imf::addChromaticities(header,
                         Imf::Chromaticities(of(p.red), of(p.green), of(p.blue), of(p.white)));
}

}  // namespace pvol::formats::detail
