// Frames of a sequence as the filter takes them, and how one sees another (THEORY.md, T5.23).
#pragma once

#include <functional>

#include "pvol/render/camera.h"
#include "render/denoise/colour_parts.h"
#include "render/denoise/denoise_inputs.h"

namespace pvol::detail {

/// How a frame was seen.
struct FrameView {
  std::optional<Camera> camera;  ///< that rendered it, if it is known
  double time = 0;               ///< in frames
};

/// What the filter wants of one frame: made once, for all frames that it bears upon.
struct FramePlanes {
  PatchOptions patches;
  Halves halves;
  Features features;
  Planes parts;                    ///< of the layers that are parts of the colour, three of each
  std::vector<std::string> names;  ///< of these layers
  Film window;                     ///< sizes of the film, without pixels
  FrameView view;
  std::optional<Features> velocity;  ///< of first collisions, if the film tells it
};

/// Of a film that check_film takes, with pixels. Heeds `stop`.
[[nodiscard]] FramePlanes make_frame_planes(const Film& film, const PatchOptions& patches,
                                            const FrameView& view,
                                            const std::function<bool()>& stop);

/// Another frame, in the pixels, the units and the features of the one that is filtered.
struct AlignedFrame {
  std::array<Guide, 2> colour;
  Planes parts, features;
  Plane known;  ///< 0 for pixels whose place the other frame does not show, else 1
};

/// Takes each pixel's point, at the depth of first collisions around it, to where it is at the
/// other frame's time and that frame's camera sees it, and the nearest pixel there. Throws Error
/// where the frames differ in size or in the layers of light.
[[nodiscard]] AlignedFrame align(const FramePlanes& other, const FramePlanes& own);

}  // namespace pvol::detail
