// What surrounds a scene. Each kind of sky has its name and its keys in scene files beside it.
#pragma once

#include <string>
#include <variant>

#include "pvol/math/keys.h"
#include "pvol/math/vec.h"
#include "pvol/render/clear_sky.h"
#include "pvol/render/shared_pixels.h"
#include "pvol/volume/medium_keys.h"

namespace pvol {

/// The same radiance from every direction.
struct ConstantSky {
  static constexpr const char* kName = "constant";
  Rgb radiance{0.5f};
  friend bool operator==(const ConstantSky&, const ConstantSky&) = default;
};
template <std::same_as<ConstantSky> T>
[[nodiscard]] constexpr auto keys(const T&) {
  return std::to_array<Key<T>>({
      key<&T::radiance>({.key = "radiance",
                         .metavar = "RGB",
                         .limits = number(kRadianceRange).or_three(),
                         .help = "Radiance from every direction"}),
  });
}

/// Radiance by height: from ground through horizon to zenith, mixed linearly in |cos| of the angle
/// to `up`.
struct GradientSky {
  static constexpr const char* kName = "gradient";
  Rgb zenith{0.06f, 0.16f, 0.42f};
  Rgb horizon{0.32f, 0.46f, 0.66f};
  Rgb ground{0.16f, 0.16f, 0.15f};
  Vec3d up{0, 1, 0};
  friend bool operator==(const GradientSky&, const GradientSky&) = default;
};
template <std::same_as<GradientSky> S>
[[nodiscard]] constexpr auto keys(const S&) {
  constexpr Limits kRadiance = number(kRadianceRange).or_three();
  return std::to_array<Key<S>>({
      key<&S::zenith>({.key = "zenith",
                       .metavar = "RGB",
                       .limits = kRadiance,
                       .help = "Radiance from straight above"}),
      key<&S::horizon>({.key = "horizon",
                        .metavar = "RGB",
                        .limits = kRadiance,
                        .help = "Radiance from the horizon"}),
      key<&S::ground>({.key = "ground",
                       .metavar = "RGB",
                       .limits = kRadiance,
                       .help = "Radiance from straight below"}),
      key<&S::up>({.key = "up",
                   .metavar = "XYZ",
                   .limits = direction(),
                   .help = "Direction of the zenith"}),
  });
}

/// A latitude-longitude picture around the scene. Pixel (x, y) covers azimuth 2 pi (x + [0,1]) /
/// width and angle pi (y + [0,1]) / height from +y; azimuth 0 looks along +x, pi/2 along +z.
/// Another `up` turns all of it by the shortest way from +y: with +z, azimuth pi/2 looks along -y.
/// Radiance is constant in each pixel, finite and not negative.
struct ImageSky {
  static constexpr const char* kName = "image";
  int width = 0, height = 0;
  SharedPixels pixels{};  ///< rows from the top, width * height
  Rgb scale{1.0f};        ///< factor on every pixel
  double rotation = 0;    ///< degrees, added to the azimuth of the picture about `up`
  std::string file{};     ///< that the pixels come from; empty where they come from memory
  Vec3d up{0, 1, 0};      ///< the direction of the picture's upper edge
  /// Of the file; empty: that of its primaries, which are those of Rec.709 where it names none. Its
  /// pixels are converted when they are read.
  std::string color_space{};
  friend bool operator==(const ImageSky&, const ImageSky&) = default;
};
template <std::same_as<ImageSky> S>
[[nodiscard]] constexpr auto keys(const S&) {
  return std::to_array<Key<S>>({
      key<&S::file>({.key = "file",
                     .metavar = "FILE",
                     .limits = file_name(),
                     .help = "Picture in latitude and longitude (.exr, .hdr)",
                     .required = true}),
      key<&S::scale>({.key = "scale",
                      .metavar = "RGB",
                      .limits = number(kRadianceRange).or_three(),
                      .help = "Factor on the radiance of every pixel"}),
      key<&S::rotation>({.key = "rotation",
                         .metavar = "DEGREES",
                         .limits = number(),
                         .help = "Rotation of the picture about up in degrees"}),
      key<&S::up>({.key = "up",
                   .metavar = "XYZ",
                   .limits = direction(),
                   .help = "Direction of the picture's upper edge"}),
      key<&S::color_space>({.key = "color_space",
                            .metavar = "NAME",
                            .limits = any_text(),
                            .help = "Colour space of the picture: rec709, rec2020, p3-d65, acescg, "
                                    "aces2065-1, or one of the OCIO configuration",
                            .otherwise = "by the primaries in the file, else rec709"}),
  });
}

using Environment = std::variant<ConstantSky, GradientSky, ImageSky, ClearSky>;

/// Throws Error, which says what is wrong, for values out of range and for a picture without
/// pixels.
void validate(const Environment& environment);

}  // namespace pvol
