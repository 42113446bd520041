// Colour spaces of pictures: in EXR files, of skies, and on screens.
#include <ImfInputFile.h>
#include <gtest/gtest.h>

#include "pvol/error.h"
#include "pvol/formats/film_file.h"
#include "support/color_files.h"
#include "support/error_of.h"
#include "support/messages.h"

namespace pvol::formats {
namespace color_config_test {

using namespace color_files;
using test::error_of;

using ColorConfig = ColorFiles;

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
  keep_exact_sums(film);
  ExrOptions options;
  options.sums = {&film, {.key = "key", .pieces = {{0, 0, 0, 4, 2, 0, 1}}}};
  write_exr(file("a.exr"), film, {}, options);
  EXPECT_EQ(read_film_file(file("a.exr")).film.color_space, ColorSpace::acescg);
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

}  // namespace color_config_test
}  // namespace pvol::formats
