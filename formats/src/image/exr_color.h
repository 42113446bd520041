// The primaries of colours in EXR files.
#pragma once

#include <ImfHeader.h>

#include "pvol/math/color_space.h"

namespace pvol::formats::detail {

/// Those of the attribute "chromaticities", and without it those of Rec.709.
[[nodiscard]] Primaries primaries_of(const Imf::Header& header);

/// The space of a film. Throws Error for primaries that belong to none.
[[nodiscard]] ColorSpace space_of(const Imf::Header& header);

void add_primaries(ColorSpace space, Imf::Header& header);

}  // namespace pvol::formats::detail
