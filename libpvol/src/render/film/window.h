// Which part of an image a film has.
#pragma once

#include "pvol/render/film.h"

namespace pvol::detail {

/// Whether both are the same rectangle of images of the same size.
[[nodiscard]] inline bool have_same_window(const Film& a, const Film& b) {
  return a.width == b.width && a.height == b.height && a.x == b.x && a.y == b.y &&
         a.crop_width == b.crop_width && a.crop_height == b.crop_height;
}

}  // namespace pvol::detail
