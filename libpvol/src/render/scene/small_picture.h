// A picture in fewer pixels, for finding out about the large one.
#pragma once

#include "pvol/render/options.h"

namespace pvol::detail {

/// The options with about so many pixels, 1 or more, for the crop that is rendered; never more than
/// it has. The crop of the small picture covers that of the large one. Its samples are those of the
/// whole picture, whatever part of them is rendered.
[[nodiscard]] RenderOptions in_small(RenderOptions options, int pixels);

}  // namespace pvol::detail
