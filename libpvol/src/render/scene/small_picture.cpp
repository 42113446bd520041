#include "render/scene/small_picture.h"

#include <algorithm>
#include <cmath>

#include "render/scene/image_part.h"

namespace pvol::detail {

RenderOptions in_small(RenderOptions o, int pixels) {
  const ImagePart part = image_part(o);
  const double shrink =
      std::max(1.0, std::sqrt(double(part.width) * part.height / std::max(1, pixels)));
  const int width = std::max(1, int(std::lround(o.width / shrink)));
  const int height = std::max(1, int(std::lround(o.height / shrink)));
  const double across = double(o.width) / width, down = double(o.height) / height;
  o.width = width, o.height = height;
  o.part_begin = o.part_end = 0;
  o.crop_x = std::min(width - 1, int(part.x / across));
  o.crop_y = std::min(height - 1, int(part.y / down));
  o.crop_width = std::min(width, int(std::ceil((part.x + part.width) / across))) - o.crop_x;
  o.crop_height = std::min(height, int(std::ceil((part.y + part.height) / down))) - o.crop_y;
  return o;
}

}  // namespace pvol::detail
