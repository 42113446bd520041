// What pictures in EXR files have in common, whatever they are read for.
#pragma once

#include <ImfInputFile.h>

#include <string>

namespace pvol::formats::detail {

/// Throws Error for what cannot be used as a picture, before any pixel is read: without R, G and B,
/// with primaries other than Rec.709, too large, or incomplete.
void check_picture(const Imf::InputFile& in);

}  // namespace pvol::formats::detail
