// Colour spaces of pictures: in EXR files, of skies, and views of OCIO configurations.
#include <ImfChannelList.h>
#include <ImfChromaticities.h>
#include <ImfFrameBuffer.h>
#include <ImfHeader.h>
#include <ImfInputFile.h>
#include <ImfOutputFile.h>
#include <ImfStandardAttributes.h>
#include <gtest/gtest.h>
#include <png.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <fstream>
#include <iterator>
#include <vector>

#include "pvol/error.h"
#include "pvol/formats/film_file.h"
#include "pvol/formats/image.h"
#include "support/error_of.h"
#include "support/messages.h"
#include "support/temporary_folder.h"

namespace pvol::formats {
namespace color_config_test {

using test::error_of;

constexpr Vec3d kColor(0.5, 0.25, 0.125);

/// Every pixel has the colour.
Film film_of(Vec3d color, ColorSpace space) {
  Film film{4, 2, 0, 0, 4, 2, std::vector<PixelSums>(8)};
  for (PixelSums& p : film.pixels) p = {color, {}, 1, 1, 0, 0, 0};
  film.color_space = space;
  return film;
}

/// The codes of a film's first pixel.
std::vector<int> codes_of(const Film& film, const Display& display) {
  const Picture p = to_picture(film, display);
  return {p.rgb.begin(), p.rgb.begin() + 3};
}

void expect_codes(const std::vector<int>& a, const std::vector<int>& b, int off = 1) {
  ASSERT_EQ(a.size(), b.size());
  for (std::size_t i = 0; i < a.size(); ++i) EXPECT_NEAR(a[i], b[i], off) << i;
}

/// A folder, and the variable OCIO as it was.
class ColorConfig : public testing::Test {
 protected:
  void SetUp() override {
    if (const char* value = std::getenv("OCIO")) before_ = value;
    unsetenv("OCIO");
  }
  void TearDown() override {
    before_.empty() ? unsetenv("OCIO") : setenv("OCIO", before_.c_str(), 1);
  }
  void use_config(const std::string& text) {
    std::ofstream(file("config.ocio")) << text;
    setenv("OCIO", file("config.ocio").c_str(), 1);
  }
  [[nodiscard]] std::filesystem::path file(const std::string& name) const {
    return folder_.file(name);
  }

  TemporaryFolder folder_;
  std::string before_;
};

std::string bytes_of(const std::filesystem::path& file) {
  std::ifstream in(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

bool has_ocio() { return tone_maps().size() > all_names<ToneMap>().size(); }

TEST_F(ColorConfig, ExrHasThePrimariesOfItsFilm) {
  for (const auto& space : names(ColorSpace{})) {
    const Film film = film_of(kColor, space.value);
    write_exr(file("a.exr"), film, {});
    const Primaries p = primaries_of(space.value);
    {
      Imf::InputFile in(file("a.exr").c_str());
      const Imf::Chromaticities found = Imf::chromaticities(in.header());
      EXPECT_EQ(found.red, Imath::V2f(float(p.red.x), float(p.red.y))) << space.name;
      EXPECT_EQ(found.green, Imath::V2f(float(p.green.x), float(p.green.y))) << space.name;
      EXPECT_EQ(found.blue, Imath::V2f(float(p.blue.x), float(p.blue.y))) << space.name;
      EXPECT_EQ(found.white, Imath::V2f(float(p.white.x), float(p.white.y))) << space.name;
    }
    EXPECT_EQ(read_film(file("a.exr")).film.color_space, space.value) << space.name;
    EXPECT_EQ(read_picture_header(file("a.exr")).window.color_space, space.value) << space.name;
  }
}

TEST_F(ColorConfig, SumsKeepTheSpace) {
  Film film = film_of(kColor, ColorSpace::acescg);
  for (PixelSums& p : film.pixels) p = {};
  start_sums(film);
  ExrOptions options;
  options.sums = {&film, {.key = "key", .pieces = {{0, 0, 0, 4, 2, 0, 1}}}};
  write_exr(file("a.exr"), film, {}, options);
  EXPECT_EQ(read_film_file(file("a.exr")).film.color_space, ColorSpace::acescg);
}

/// A picture of one colour with these primaries.
std::filesystem::path write_picture(const std::filesystem::path& file, Vec3f color,
                                    const Imf::Chromaticities& primaries) {
  Imf::Header header(4, 2);
  Imf::addChromaticities(header, primaries);
  const std::vector<Vec3f> pixels(8, color);
  Imf::FrameBuffer buffer;
  const char* const channels[] = {"R", "G", "B"};
  for (std::size_t c = 0; c < 3; ++c) {
    header.channels().insert(channels[c], Imf::Channel(Imf::FLOAT));
    buffer.insert(channels[c], Imf::Slice::Make(Imf::FLOAT, &pixels[0].x + c, header.dataWindow(),
                                                sizeof(Vec3f), 4 * sizeof(Vec3f)));
  }
  Imf::OutputFile out(file.c_str(), header);
  out.setFrameBuffer(buffer);
  out.writePixels(2);
  return file;
}

Imf::Chromaticities acescg() {
  return {{0.713f, 0.293f}, {0.165f, 0.83f}, {0.128f, 0.044f}, {0.32168f, 0.33767f}};
}

TEST_F(ColorConfig, SkiesAreConvertedFromTheirPrimaries) {
  const auto sky = write_picture(file("a.exr"), Vec3f(kColor), acescg());
  const auto expect = [&](const SkyColors& colors, Vec3d wanted) {
    const ImageSky found = read_sky(sky, colors);
    for (const Rgb& pixel : found.pixels) {
      for (int c = 0; c < 3; ++c) EXPECT_NEAR(double(pixel[c]), wanted[c], 2e-6) << c;
    }
  };
  expect({"", ColorSpace::acescg}, kColor);
  // By the inverse of the published matrix (OpenColorIO-Config-ACES).
  expect({}, {1.705051 * .5 - 0.621792 * .25 - 0.083259 * .125,
              -0.130256 * .5 + 1.140804 * .25 - 0.010548 * .125,
              -0.024003 * .5 - 0.128969 * .25 + 1.152972 * .125});
  expect({"rec709", ColorSpace::rec709}, kColor);  // whatever the file has
  // Between spaces that are told.
  expect({"rec709", ColorSpace::acescg}, {0.613097 * .5 + 0.339523 * .25 + 0.047379 * .125,
                                          0.070194 * .5 + 0.916354 * .25 + 0.013452 * .125,
                                          0.020616 * .5 + 0.109570 * .25 + 0.869815 * .125});
}

TEST_F(ColorConfig, SkiesStayWithinTheGamut) {
  const auto sky = write_picture(file("a.exr"), Vec3f(0, 1, 0), acescg());
  const Rgb found = read_sky(sky).pixels.front();
  EXPECT_EQ(min_component(found), 0);
  EXPECT_NEAR(luminance(found), 0.67408f, 2e-3f);  // up to the adaptation
}

TEST_F(ColorConfig, SkiesOfNoColoursAreRefused) {
  Imf::Chromaticities line = acescg();
  line.blue = (line.red + line.green) * 0.5f;
  const auto sky = write_picture(file("a.exr"), Vec3f(kColor), line);
  EXPECT_TRUE(says(error_of([&] { (void)read_sky(sky); }), "color.primaries_span_no_colours"));
}

TEST_F(ColorConfig, FilmsOfUnknownPrimariesAreRefused) {
  Imf::Chromaticities other = acescg();
  other.blue = {0.2f, 0.1f};
  const auto film = write_picture(file("a.exr"), Vec3f(kColor), other);
  EXPECT_TRUE(says(error_of([&] { (void)read_film(film); }), "exr.primaries_no_space"));
  EXPECT_NO_THROW((void)read_sky(film));
}

TEST_F(ColorConfig, UnknownSpacesOfSkiesAreRefused) {
  const auto sky = write_picture(file("a.exr"), Vec3f(kColor), acescg());
  const std::string message = error_of([&] { (void)read_sky(sky, {.from = "none such"}); });
  EXPECT_TRUE(says(message, has_ocio() ? "color.no_colour_space" : "color.no_space_without"));
}

TEST_F(ColorConfig, PngShowsTheSameColourFromEverySpace) {
  const std::vector<int> wanted = codes_of(film_of(kColor, ColorSpace::rec709), {});
  for (const auto& space : names(ColorSpace{})) {
    const Vec3d there = conversion(ColorSpace::rec709, space.value).vector(kColor);
    expect_codes(codes_of(film_of(there, space.value), {}), wanted);
  }
}

TEST_F(ColorConfig, UnknownToneMapsAreRefusedWithWhatThereIs) {
  const std::string message = error_of([&] { validate({.tone_map = "none such"}); });
  EXPECT_TRUE(says(message, has_ocio() ? "color.no_tone_map" : "color.no_tone_map_without"));
}

TEST_F(ColorConfig, OwnViewsShowWhatAcesSays) {
  if (!has_ocio()) GTEST_SKIP() << "built without OpenColorIO";
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

TEST_F(ColorConfig, SkiesMayBeTextures) {
  if (!has_ocio()) GTEST_SKIP() << "built without OpenColorIO";
  const auto sky = write_picture(file("a.exr"), Vec3f(0.5f, 0.2f, 0.02f), acescg());
  const Rgb found = read_sky(sky, {"sRGB - Texture", ColorSpace::rec709}).pixels.front();
  EXPECT_NEAR(found.x, 0.214041f, 2e-5f);  // IEC 61966-2-1
  EXPECT_NEAR(found.y, 0.033105f, 2e-5f);
  EXPECT_NEAR(found.z, 0.001548f, 2e-5f);
}

TEST_F(ColorConfig, PngOfOtherScreensDoesNotClaimToBeSrgb) {
  if (!has_ocio()) GTEST_SKIP() << "built without OpenColorIO";
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

TEST_F(ColorConfig, TheVariableNamesAnotherConfiguration) {
  if (!has_ocio()) GTEST_SKIP() << "built without OpenColorIO";
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
TEST_F(ColorConfig, SkiesOfScreensAreNotToneMapped) {
  if (!has_ocio()) GTEST_SKIP() << "built without OpenColorIO";
  const auto sky = write_picture(file("a.exr"), Vec3f(0.5f, 0.2f, 0.9f), acescg());
  const Rgb screen = read_sky(sky, {"sRGB", ColorSpace::rec709}).pixels.front();
  const Rgb texture = read_sky(sky, {"sRGB - Texture", ColorSpace::rec709}).pixels.front();
  for (int c = 0; c < 3; ++c) EXPECT_NEAR(screen[c], texture[c], 1e-4f) << c;
}

/// "Raw" views show a film's own numbers; no sky has such colours.
TEST_F(ColorConfig, DataIsNotConverted) {
  if (!has_ocio()) GTEST_SKIP() << "built without OpenColorIO";
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

TEST_F(ColorConfig, SkiesThatCannotBeConvertedAreNamed) {
  if (!has_ocio()) GTEST_SKIP() << "built without OpenColorIO";
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

TEST_F(ColorConfig, ConfigurationsThatCannotBeUsedAreNamed) {
  if (!has_ocio()) GTEST_SKIP() << "built without OpenColorIO";
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

}  // namespace color_config_test
}  // namespace pvol::formats
