// From linear colours to a screen's codes.
#pragma once

#include <span>

#include "image/color_config.h"
#include "pvol/formats/image.h"

namespace pvol::formats::detail {

/// How colours of a space are shown. Throws Error for an exposure out of range and a tone map that
/// is unknown.
class Screen {
 public:
  Screen(const Display& display, ColorSpace space);

  /// On colours before they are encoded.
  [[nodiscard]] double factor() const { return factor_; }
  /// Linear colours in place to what codes stand for, in [0, 1].
  void encode(std::span<Vec3d> colors) const;
  [[nodiscard]] bool is_srgb() const { return view_.is_srgb; }

 private:
  double factor_;
  ScreenView view_;
};

}  // namespace pvol::formats::detail
