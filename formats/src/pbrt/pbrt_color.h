// pbrt's spectra as linear Rec.709.
#pragma once

#include <optional>

#include "pbrt/pbrt_description.h"

namespace pvol::formats::detail {

/// What a spectrum is of.
enum class PbrtSpectrum {
  light,        ///< of luminance 1, but for rgb, which stands for itself
  reflectance,  ///< reflectances and cross sections: values count
};

/// A spectral parameter; nothing without it. Spectra given by wavelength become what the CIE
/// observer sees of them: of lights as they are, of other things in the light of D65. Those of
/// files and of names that are not known are named and taken as white.
[[nodiscard]] std::optional<Rgb> color_of(const PbrtThing& thing, std::string_view name,
                                          PbrtSpectrum what, ImportNotes& notes);

/// A black body's light where its largest radiance by wavelength is 1, in the unit of pbrt's films:
/// the integral over the observer in nanometres.
[[nodiscard]] Rgb peak_normalised_blackbody(double kelvin);

}  // namespace pvol::formats::detail
