// From light to what screens show: exposure, tone maps, and views of OCIO configurations.
#pragma once

#include <functional>
#include <span>
#include <string>
#include <vector>

#include "pvol/math/color_space.h"
#include "pvol/math/names.h"
#include "pvol/math/vec.h"

namespace pvol::formats {

/// What a PNG does with light brighter than the screen's white.
enum class ToneMap {
  srgb,     ///< clips it: colours below are the scene's
  neutral,  ///< Khronos PBR Neutral: compresses what is above 0.8, and fades it to white
  filmic,   ///< Hable's curve of Uncharted 2: soft from shadows to highlights, and darker
};
[[nodiscard]] constexpr auto names(ToneMap) {
  return std::to_array<Named<ToneMap>>(
      {{ToneMap::srgb, "srgb"}, {ToneMap::neutral, "neutral"}, {ToneMap::filmic, "filmic"}});
}

/// Linear light of a screen whose white is 1, in [0, 1], for linear Rec.709; negative counts as 0.
[[nodiscard]] Vec3d to_display(Vec3d linear, ToneMap map);

/// How light becomes what a screen shows.
struct Display {
  double exposure = 0;  ///< in stops
  /// One of `tone_maps`: the name of a ToneMap, or a view of the OCIO configuration.
  std::string tone_map = "srgb";

  friend bool operator==(const Display&, const Display&) = default;
};

/// Every tone map there is: those of ours, then, where pvol was built with OpenColorIO, the views
/// of the configuration that the environment variable OCIO names, or else of a small one with the
/// views of ACES 1.0; those of other displays than its first as "display/view", by which name the
/// others are found, too. Throws Error for a configuration that cannot be read.
[[nodiscard]] std::vector<std::string> tone_maps();

/// Throws Error for an exposure beyond what double holds and a tone map that is none of those.
void validate(const Display& display);

/// Tells this configuration from others that may give colour spaces of the same names other
/// meanings. Empty where pvol was built without OpenColorIO. Throws Error as `tone_maps`.
[[nodiscard]] std::string color_config_id();

/// Ready to show colours of a space by a display. To make one may take as long as to show a
/// picture, where it is a view of a configuration. Throws Error as `validate`.
class Screen {
 public:
  Screen(const Display& display, ColorSpace space);

  /// Shows at another exposure. Throws Error as `validate`.
  void expose(double stops);
  /// On colours before they are encoded.
  [[nodiscard]] double factor() const { return factor_; }
  /// Linear colours in place to what codes stand for, in [0, 1].
  void encode(std::span<Vec3d> colors) const;
  /// Whether these codes are those of sRGB, as far as names tell.
  [[nodiscard]] bool is_srgb() const { return is_srgb_; }

 private:
  double factor_ = 1;
  std::function<void(std::span<Vec3d>)> encode_;
  bool is_srgb_ = true;
};

}  // namespace pvol::formats
