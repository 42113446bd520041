// The part of an image that is rendered.
#pragma once

#include "pvol/render/options.h"

namespace pvol::detail {

/// A part of an image, in pixels.
struct ImagePart {
  int x, y, width, height;
};

/// The one that is rendered. What is decided and prepared is that of the whole image, so that its
/// parts have the same pixels.
[[nodiscard]] inline ImagePart image_part(const RenderOptions& o) {
  return {o.crop_x, o.crop_y, o.crop_width ? o.crop_width : o.width - o.crop_x,
          o.crop_height ? o.crop_height : o.height - o.crop_y};
}

}  // namespace pvol::detail
