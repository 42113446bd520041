// Views and colour spaces of OCIO configurations.
#include <gtest/gtest.h>
#include <png.h>

#include <algorithm>

#include "pvol/error.h"
#include "support/color_files.h"
#include "support/error_of.h"
#include "support/messages.h"

namespace pvol::formats {
namespace ocio_config_test {

using namespace color_files;
using test::error_of;

using OcioConfig = ColorFiles;

TEST_F(OcioConfig, OwnViewsShowWhatAcesSays) {
  const Film grey = film_of(Vec3d(0.18), ColorSpace::rec709);
  // ACES 1.0 shows 18 % as a tenth of white: 4.8 of 48 nits (S-2014-002 and its RRT and ODT).
  const int tenth = 89;
  expect_codes(codes_of(grey, {0, "ACES 1.0"}), {tenth, tenth, tenth}, 2);
  expect_codes(codes_of(film_of(Vec3d(1e6), ColorSpace::aces), {0, "ACES 1.0"}), {255, 255, 255});
  // Without a tone map, what ours of that name is.
  for (const auto& space : names(ColorSpace{})) {
    const Film film =
        film_of(conversion(ColorSpace::rec709, space.value).vector(kColor), space.value);
    expect_codes(codes_of(film, {0.5, "Un-tone-mapped"}), codes_of(film, {0.5, "srgb"}));
    expect_codes(codes_of(film, {0, "ACES 1.0"}),
                 codes_of(film_of(kColor, ColorSpace::rec709), {0, "ACES 1.0"}));
  }
  // Of P3, whose white and transfer function are those of sRGB.
  expect_codes(codes_of(film_of(kColor, ColorSpace::p3), {0, "Display P3/Un-tone-mapped"}),
               codes_of(film_of(kColor, ColorSpace::rec709), {}));
  // Of Rec.1886: 0.5^(1 / 2.4).
  expect_codes(codes_of(film_of(Vec3d(0.5), ColorSpace::rec709), {0, "Rec.1886/Un-tone-mapped"}),
               {191, 191, 191});
}

TEST_F(OcioConfig, SkiesMayBeTextures) {
  const auto sky = write_picture(file("a.exr"), Vec3f(0.5f, 0.2f, 0.02f), acescg());
  const Rgb found = read_sky(sky, {"sRGB - Texture", ColorSpace::rec709}).pixels.front();
  EXPECT_NEAR(found.x, 0.214041f, 2e-5f);  // IEC 61966-2-1
  EXPECT_NEAR(found.y, 0.033105f, 2e-5f);
  EXPECT_NEAR(found.z, 0.001548f, 2e-5f);
}

TEST_F(OcioConfig, PngOfOtherScreensDoesNotClaimToBeSrgb) {
  const auto says_srgb = [&](const char* view) {
    write_png(file("a.png"), film_of(kColor, ColorSpace::rec709), {0, view});
    return bytes_of(file("a.png")).find("sRGB") != std::string::npos;
  };
  EXPECT_TRUE(says_srgb("ACES 1.0"));
  EXPECT_FALSE(says_srgb("Display P3/ACES 1.0"));
  EXPECT_EQ(bytes_of(file("a.png")).find("gAMA"), std::string::npos) << "which P3 has not";
  png_image image{};  // what is left is a whole file
  image.version = PNG_IMAGE_VERSION;
  ASSERT_TRUE(png_image_begin_read_from_file(&image, file("a.png").c_str())) << image.message;
  std::vector<std::uint8_t> codes(PNG_IMAGE_SIZE(image));
  EXPECT_TRUE(png_image_finish_read(&image, nullptr, codes.data(), 0, nullptr)) << image.message;
}

/// A studio's: of Rec.709 alone, without roles of OCIO 2; its only view divides by two.
constexpr const char* kStudio = R"(ocio_profile_version: 1
roles: {default: lin_rec709}
displays:
  Projector: [!<View> {name: Half, colorspace: half}]
colorspaces:
  - !<ColorSpace> {name: lin_rec709}
  - !<ColorSpace>
    name: half
    from_reference: !<MatrixTransform> {matrix: [0.5, 0, 0, 0, 0, 0.5, 0, 0, 0, 0, 0.5, 0, 0, 0, 0, 1]}
)";

TEST_F(OcioConfig, TheVariableNamesAnotherConfiguration) {
  use_config(kStudio);
  const std::vector<std::string> all = tone_maps();
  EXPECT_EQ(std::ranges::count(all, "Half"), 1);
  EXPECT_EQ(std::ranges::count(all, "ACES 1.0"), 0);
  const Film film = film_of(conversion(ColorSpace::rec709, ColorSpace::acescg).vector(kColor),
                            ColorSpace::acescg);
  expect_codes(codes_of(film, {0, "Half"}), {64, 32, 16});
  // Names of spaces are those of the configuration: here a sky that was divided by two.
  const auto sky = write_picture(file("a.exr"), Vec3f(kColor), acescg());
  const Rgb doubled = read_sky(sky, {"half", ColorSpace::rec709}).pixels.front();
  for (int c = 0; c < 3; ++c) EXPECT_NEAR(double(doubled[c]), 2 * kColor[c], 1e-5);
}

/// Codes of screens are light without a tone map, as in ACES's own configurations.
TEST_F(OcioConfig, SkiesOfScreensAreNotToneMapped) {
  const auto sky = write_picture(file("a.exr"), Vec3f(0.5f, 0.2f, 0.9f), acescg());
  const Rgb screen = read_sky(sky, {"sRGB", ColorSpace::rec709}).pixels.front();
  const Rgb texture = read_sky(sky, {"sRGB - Texture", ColorSpace::rec709}).pixels.front();
  for (int c = 0; c < 3; ++c) EXPECT_NEAR(screen[c], texture[c], 1e-4f) << c;
}

/// "Raw" views show a film's own numbers; no sky has such colours.
TEST_F(OcioConfig, DataIsNotConverted) {
  use_config(R"(ocio_profile_version: 2
roles: {aces_interchange: AP0, default: AP0}
file_rules: [!<Rule> {name: Default, colorspace: default}]
displays:
  d: [!<View> {name: Raw, colorspace: raw}, !<View> {name: Plain, colorspace: AP0}]
colorspaces:
  - !<ColorSpace> {name: AP0}
  - !<ColorSpace> {name: raw, isdata: true}
)");
  const Film film = film_of(kColor, ColorSpace::acescg);
  expect_codes(codes_of(film, {0, "d/Raw"}), {128, 64, 32});
  const Vec3d ap0 = conversion(ColorSpace::acescg, ColorSpace::aces).vector(kColor) * 255;
  expect_codes(codes_of(film, {0, "Plain"}), {int(ap0.x), int(ap0.y), int(ap0.z)});
  const auto sky = write_picture(file("a.exr"), Vec3f(kColor), acescg());
  const std::string refusal = error_of([&] { (void)read_sky(sky, {"raw"}); });
  EXPECT_NE(refusal.find("expected rec709"), std::string::npos) << refusal;
}

TEST_F(OcioConfig, SkiesThatCannotBeConvertedAreNamed) {
  use_config(R"(ocio_profile_version: 1
roles: {default: lin_rec709}
displays:
  d: [!<View> {name: v, colorspace: lin_rec709}]
colorspaces:
  - !<ColorSpace> {name: lin_rec709}
  - !<ColorSpace>
    name: log
    to_reference: !<LogTransform> {base: 2, direction: inverse}
)");
  const auto sky = write_picture(file("a.exr"), Vec3f(500, 1, 1), acescg());
  EXPECT_TRUE(says(error_of([&] { (void)read_sky(sky, {"log"}); }), "color.sky_not_finite"));
}

TEST_F(OcioConfig, ConfigurationsThatCannotBeUsedAreNamed) {
  const auto refusal = [&] { return error_of([] { validate({.tone_map = "Half"}); }); };
  use_config("ocio_profile_version: [");
  EXPECT_NE(refusal().find(file("config.ocio").string()), std::string::npos) << refusal();
  setenv("OCIO", file("none.ocio").c_str(), 1);
  EXPECT_NE(refusal().find(file("none.ocio").string()), std::string::npos) << refusal();
  std::string strange = kStudio;
  for (std::size_t at; (at = strange.find("lin_rec709")) != std::string::npos;) {
    strange.replace(at, 10, "linear_x");
  }
  use_config(strange);
  EXPECT_TRUE(says(refusal(), "color.no_linear_space")) << refusal();
  EXPECT_NO_THROW(validate({.tone_map = "filmic"})) << "which needs no configuration";
}

}  // namespace ocio_config_test
}  // namespace pvol::formats
