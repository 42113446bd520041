#include "pvol/formats/image.h"
#include "pvol/render/film_channels.h"

#include <ImfArray.h>
#include <ImfChannelList.h>
#include <ImfChromaticitiesAttribute.h>
#include <ImfFrameBuffer.h>
#include <ImfHeader.h>
#include <ImfInputFile.h>
#include <ImfOutputFile.h>
#include <ImfStandardAttributes.h>
#include <ImfStringAttribute.h>
#include <ImfTiledOutputFile.h>
#include <gtest/gtest.h>
#include <png.h>

#include <fstream>
#include <functional>
#include <limits>
#include <random>

#include "pvol/error.h"
#include "support/effort.h"
#include "support/messages.h"
#include "support/temporary_folder.h"

namespace pvol::formats {
namespace image_test {

namespace fs = std::filesystem;

class Image : public testing::Test {
 protected:
  [[nodiscard]] fs::path file(const std::string& name) const { return folder_ / name; }

  const TemporaryFolder own_;
  const fs::path folder_ = own_.path();
};

std::string error_of(const std::function<void()>& call) {
  try {
    call();
  } catch (const Error& e) {
    return e.what();
  }
  return "no error";
}

Film random_film(int width, int height, int x, int y, int crop_width, int crop_height) {
  Film film{width, height, x, y, crop_width, crop_height, {}};
  std::mt19937 random(7);
  std::uniform_real_distribution<double> uniform(0, 2);
  for (int i = 0; i < crop_width * crop_height; ++i) {
    PixelSums p;
    p.samples = std::uint32_t(1 + random() % 5);
    for (std::uint32_t s = 0; s < p.samples; ++s) {
      const Vec3d value{uniform(random), uniform(random), uniform(random)};
      p.sum += value;
      p.sum_squares += value * value;
      p.alpha += uniform(random) / 2;
    }
    for (std::uint64_t& n : film.counts.emplace_back()) n = std::uint32_t(random() % 100);
    film.pixels.push_back(p);
  }
  return film;
}

/// One pixel with these means.
Film one_pixel(Vec3d colour, double alpha) {
  Film film{1, 1, 0, 0, 1, 1, {}};
  film.pixels.push_back({colour * 4.0, {}, alpha * 4, 4});
  return film;
}

std::vector<float> read_channel(const fs::path& file, const char* name) {
  Imf::InputFile in(file.c_str());
  const Imath::Box2i box = in.header().dataWindow();
  const int width = box.max.x - box.min.x + 1, height = box.max.y - box.min.y + 1;
  std::vector<float> values(std::size_t(width) * std::size_t(height));
  Imf::FrameBuffer buffer;
  buffer.insert(name, Imf::Slice::Make(Imf::FLOAT, values.data(), box));
  in.setFrameBuffer(buffer);
  in.readPixels(box.min.y, box.max.y);
  return values;
}

std::vector<std::string> channel_names(const fs::path& file) {
  Imf::InputFile in(file.c_str());
  std::vector<std::string> names;
  const Imf::ChannelList& channels = in.header().channels();
  for (auto c = channels.begin(); c != channels.end(); ++c) names.push_back(c.name());
  return names;
}

TEST_F(Image, ExrHoldsEveryValueOfTheFilm) {
  const Film film = random_film(40, 60, 7, 9, 5, 37);  // taller than two zip blocks, not a multiple
  write_exr(file("a.exr"), film, {}, {.aovs = AovSet::all()});
  const auto of = [&](std::size_t i) -> const PixelSums& { return film.pixels[i]; };
  const auto counted = [&](PixelCounter c) {
    return [&, c](std::size_t i) { return double(film.count(i, c)) / of(i).samples; };
  };
  const std::pair<const char*, std::function<double(std::size_t)>> channels[] = {
      {"R", [&](std::size_t i) { return mean(of(i)).x; }},
      {"G", [&](std::size_t i) { return mean(of(i)).y; }},
      {"B", [&](std::size_t i) { return mean(of(i)).z; }},
      {"A", [&](std::size_t i) { return of(i).alpha / of(i).samples; }},
      {"variance.R", [&](std::size_t i) { return variance_of_mean(of(i)).x; }},
      {"variance.G", [&](std::size_t i) { return variance_of_mean(of(i)).y; }},
      {"variance.B", [&](std::size_t i) { return variance_of_mean(of(i)).z; }},
      {"samples.Y", [&](std::size_t i) { return double(of(i).samples); }},
      {"transmittance.Y",
       [&](std::size_t i) { return (of(i).samples - of(i).alpha) / of(i).samples; }},
      {"lookups.Y", counted(PixelCounter::lookups)},
      {"bounds_tests.Y", counted(PixelCounter::bounds_tests)},
      {"segments.Y", counted(PixelCounter::segments)},
      {"collisions.Y", counted(PixelCounter::collisions)}};
  EXPECT_EQ(channel_names(file("a.exr")).size(), std::size(channels));
  for (const auto& [name, value] : channels) {
    const std::vector<float> read = read_channel(file("a.exr"), name);
    ASSERT_EQ(read.size(), film.pixels.size());
    for (std::size_t i = 0; i < read.size(); ++i) {
      EXPECT_EQ(read[i], float(value(i))) << name << " of pixel " << i;
    }
  }
}

TEST_F(Image, ExrHeaderTellsWindowsColoursAndAttributes) {
  write_exr(file("a.exr"), random_film(40, 30, 7, 9, 5, 6),
            {{"pvol.scene", "[volume]\nfile = \"a.pvol\"\n"}, {"pvol.version", "0.1.0"}});
  Imf::InputFile in(file("a.exr").c_str());
  const Imf::Header& header = in.header();
  EXPECT_EQ(header.displayWindow(), Imath::Box2i({0, 0}, {39, 29}));
  EXPECT_EQ(header.dataWindow(), Imath::Box2i({7, 9}, {11, 14}));
  EXPECT_EQ(header.compression(), Imf::ZIP_COMPRESSION);
  ASSERT_TRUE(Imf::hasChromaticities(header));
  EXPECT_EQ(Imf::chromaticities(header).red, Imath::V2f(0.64f, 0.33f));
  EXPECT_EQ(Imf::chromaticities(header).white, Imath::V2f(0.3127f, 0.329f));
  EXPECT_EQ(header.typedAttribute<Imf::StringAttribute>("pvol.version").value(), "0.1.0");
  EXPECT_EQ(header.typedAttribute<Imf::StringAttribute>("pvol.scene").value(),
            "[volume]\nfile = \"a.pvol\"\n");
}

/// Compositing programs take files with any other channel for files of layers.
TEST_F(Image, ExrHasColourAndAlphaAloneUnlessMoreIsAskedFor) {
  const Film film = random_film(4, 4, 0, 0, 4, 4);
  write_exr(file("a.exr"), film, {});
  const std::vector<std::string> plain{"A", "B", "G", "R"};
  EXPECT_EQ(channel_names(file("a.exr")), plain);
  for (const AovRow& row : kAovs) {
    const auto of_pixels = [&](const FilmChannel& c) { return c.aov == row.aov; };
    if (std::ranges::none_of(kFilmChannels, of_pixels)) continue;  // the film's own layers
    write_exr(file("a.exr"), film, {}, {.aovs = {row.aov}});
    std::vector<std::string> more = plain;
    for (const char c : std::string_view(row.channels)) {
      more.push_back(std::string(row.name) + '.' + c);
    }
    std::ranges::sort(more);
    EXPECT_EQ(channel_names(file("a.exr")), more);
  }
}

TEST_F(Image, ExrIsOpaqueWhereABackgroundIsSeen) {
  write_exr(file("a.exr"), one_pixel({1, 2, 3}, 0.25), {}, {.opaque = true});
  EXPECT_EQ(read_channel(file("a.exr"), "A"), std::vector<float>{1});
  EXPECT_EQ(read_channel(file("a.exr"), "B"), std::vector<float>{3});
  write_exr(file("a.exr"), one_pixel({1, 2, 3}, 0.25), {}, {});
  EXPECT_EQ(read_channel(file("a.exr"), "A"), std::vector<float>{0.25f});
}

TEST_F(Image, ExrOfASmallCropOfAHugeImageIsSmall) {
  write_exr(file("a.exr"), random_film(16384, 16384, 16380, 16382, 4, 2), {});
  EXPECT_LT(fs::file_size(file("a.exr")), 4096u);
  EXPECT_EQ(read_channel(file("a.exr"), "R").size(), 8u);
}

TEST_F(Image, ExrOfPixelsWithoutSamplesIsZero) {
  Film film{2, 1, 0, 0, 2, 1, std::vector<PixelSums>(2)};
  write_exr(file("a.exr"), film, {}, {.aovs = AovSet::all()});
  for (const char* name : {"R", "A", "variance.G", "samples.Y", "transmittance.Y"}) {
    EXPECT_EQ(read_channel(file("a.exr"), name), std::vector<float>(2, 0.0f)) << name;
  }
}

TEST_F(Image, ExrBytesDependOnTheFilmAlone) {
  const Film film = random_film(40, 30, 0, 0, 40, 30);
  write_exr(file("a.exr"), film, {{"seed", "1"}});
  write_exr(file("b.exr"), film, {{"seed", "1"}});
  EXPECT_EQ(read_bytes(file("a.exr")), read_bytes(file("b.exr")));
}

void expect_near(Vec3d found, Vec3d expected) {
  for (int c = 0; c < 3; ++c) EXPECT_NEAR(found[c], expected[c], 1e-6);
}

/// By hand from the published formulas.
TEST(ToneMaps, HaveTheirPublishedValues) {
  expect_near(to_display({0.5, 2, -1}, ToneMap::srgb), {0.5, 1, 0});
  // Below 0.8 only the toe: x - (x - x^2 / 0.16), then x - 0.04.
  expect_near(to_display(Vec3d(0.04), ToneMap::neutral), Vec3d(0.01));
  expect_near(to_display({0.5, 0.25, 0.125}, ToneMap::neutral), {0.46, 0.21, 0.085});
  // (3.96, 0.96, 0.46): peak 1 - 0.24^2 / 3.44, white 1 - 1 / (0.15 * 2.9767442 + 1).
  expect_near(to_display({4, 1, 0.5}, ToneMap::neutral), {0.9832558, 0.4682992, 0.3824731});
  expect_near(to_display(Vec3d(1e30), ToneMap::neutral), Vec3d(1));
  // (0.704 / 1.66 - 1 / 15) / (19.38 / 24.476 - 1 / 15).
  expect_near(to_display({1, 0, 5.6}, ToneMap::filmic), {0.4929185, 0, 1});
  for (const auto& [map, name] : names(ToneMap{})) {
    double last = 0;
    for (double v = 0; v < 100; v = 1.1 * v + 0.001) {
      const double shown = to_display(Vec3d(v), map).y;
      EXPECT_GE(shown, last) << name << " at " << v;
      EXPECT_LE(shown, 1) << name << " at " << v;
      last = shown;
    }
  }
}

TEST_F(Image, FailedWriteKeepsTheOldFileAndLeavesNothingBeside) {
  write_bytes(file("a.exr"), "old");
  const Film film = random_film(4, 4, 0, 0, 4, 4);
  EXPECT_TRUE(says(error_of([&] {
                     write_exr(file("a.exr"), film, {{"channels", "x"}});
                   }),
                   "deep.attribute_channels_reserved"));
  EXPECT_EQ(read_bytes(file("a.exr")), "old");
  EXPECT_EQ(std::distance(fs::directory_iterator(folder_), fs::directory_iterator{}), 1);
  EXPECT_THROW(write_exr(file("none/a.exr"), film, {}), Error);
  EXPECT_THROW(write_png(file("none/a.png"), film), Error);
}

TEST_F(Image, EmptyFilmIsRefused) {
  EXPECT_THROW(write_exr(file("a.exr"), Film{}, {}), Error);
  EXPECT_THROW(write_png(file("a.png"), Film{}), Error);
  EXPECT_TRUE(fs::is_empty(folder_));
}

/// The samples of a PNG in its own layout.
std::vector<int> read_png(const fs::path& file, png_uint_32 format, int width, int height) {
  png_image image{};
  image.version = PNG_IMAGE_VERSION;
  EXPECT_TRUE(png_image_begin_read_from_file(&image, file.c_str())) << image.message;
  EXPECT_EQ(image.format, format);
  EXPECT_EQ(image.width, png_uint_32(width));
  EXPECT_EQ(image.height, png_uint_32(height));
  std::vector<std::uint8_t> bytes(PNG_IMAGE_SIZE(image));
  EXPECT_TRUE(png_image_finish_read(&image, nullptr, bytes.data(), 0, nullptr)) << image.message;
  return {bytes.begin(), bytes.end()};
}

TEST_F(Image, PngIsToneMappedAfterItsExposure) {
  write_png(file("a.png"), one_pixel(Vec3d(0.25), 1), {1, "neutral"});
  // 0.5 becomes 0.46, whose code is 255 * (1.055 * 0.46^(1 / 2.4) - 0.055).
  EXPECT_EQ(read_png(file("a.png"), PNG_FORMAT_RGB, 1, 1), std::vector<int>(3, 181));
  write_png(file("a.png"), one_pixel(Vec3d(0.25), 0.5), {0, "neutral"}, true);
  EXPECT_EQ(read_png(file("a.png"), PNG_FORMAT_RGBA, 1, 1), (std::vector<int>{181, 181, 181, 128}));
}

TEST_F(Image, PngHasTheCodesOfTheSrgbStandard) {
  // Computed from IEC 61966-2-1 by hand; 0.0031308 is the join of its two pieces.
  const std::pair<double, int> known[] = {{0, 0},      {0.001, 3}, {0.002, 7}, {0.0031308, 10},
                                          {0.18, 118}, {0.2, 124}, {0.5, 188}, {0.999, 255},
                                          {1.0, 255},  {7.5, 255}, {-0.25, 0}};
  for (const auto& [linear, code] : known) {
    write_png(file("a.png"), one_pixel(Vec3d(linear), 1));
    EXPECT_EQ(read_png(file("a.png"), PNG_FORMAT_RGB, 1, 1), std::vector<int>(3, code)) << linear;
  }
}

/// Values between two codes are both, in as many pixels as the mean wants, and finely mixed; what
/// is a code stays one; a crop has the codes of the whole.
TEST_F(Image, PngIsDithered) {
  constexpr int kEdge = 64;
  const auto codes_of = [&](double code, int x, int y, int edge) {
    const double v = (code / 255 + 0.055) / 1.055;
    Film film = random_film(kEdge, kEdge, x, y, edge, edge);
    for (PixelSums& p : film.pixels) {
      p.samples = 4, p.sum = Vec3d(4 * std::pow(v, 2.4)), p.alpha = 4;
    }
    write_png(file("a.png"), film);
    return read_png(file("a.png"), PNG_FORMAT_RGB, edge, edge);
  };
  for (const double code : {100.0, 100.1, 100.5, 100.8, 101.0}) {
    const std::vector<int> codes = codes_of(code, 0, 0, kEdge);
    double sum = 0;
    for (const int c : codes) sum += c;
    EXPECT_NEAR(sum / double(codes.size()), code, code == std::round(code) ? 1e-9 : 0.02);
    for (const int c : codes) ASSERT_TRUE(c == 100 || c == 101) << c;
    // Of blocks of 4 x 4 none is of one code where half of them are to be of each.
    for (int block = 0; code == 100.5 && block < kEdge * kEdge / 16; ++block) {
      int high = 0;
      for (int i = 0; i < 16; ++i) {
        const int x = block % 16 * 4 + i % 4, y = block / 16 * 4 + i / 4;
        high += codes[std::size_t(3 * (y * kEdge + x))] - 100;
      }
      EXPECT_TRUE(high > 2 && high < 14) << high;
    }
    const std::vector<int> crop = codes_of(code, 5, 9, 8);
    for (int y = 0; y < 8; ++y) {
      for (int x = 0; x < 8; ++x) {
        EXPECT_EQ(crop[std::size_t(3 * (8 * y + x))],
                  codes[std::size_t(3 * ((y + 9) * kEdge + x + 5))]);
      }
    }
  }
}

TEST_F(Image, PngScalesByPowersOfTwo) {
  write_png(file("a.png"), one_pixel({0.25, 0.125, 4}, 1), {1});
  EXPECT_EQ(read_png(file("a.png"), PNG_FORMAT_RGB, 1, 1), (std::vector<int>{188, 137, 255}));
  write_png(file("a.png"), one_pixel({1, 0.5, 0.4}, 1), {-1});
  EXPECT_EQ(read_png(file("a.png"), PNG_FORMAT_RGB, 1, 1), (std::vector<int>{188, 137, 124}));
}

TEST_F(Image, PngAlphaIsUnpremultiplied) {
  write_png(file("a.png"), one_pixel({0.25, 0.1, 0}, 0.5), {}, true);
  EXPECT_EQ(read_png(file("a.png"), PNG_FORMAT_RGBA, 1, 1), (std::vector<int>{188, 124, 0, 128}));
  write_png(file("a.png"), one_pixel({0.25, 0.1, 0}, 0), {}, true);
  EXPECT_EQ(read_png(file("a.png"), PNG_FORMAT_RGBA, 1, 1), (std::vector<int>{0, 0, 0, 0}));
}

TEST_F(Image, PngKeepsRowsInOrderAndSaysItIsSrgb) {
  Film film{9, 9, 3, 3, 2, 3, std::vector<PixelSums>(6)};
  for (int i = 0; i < 6; ++i) {
    film.pixels[std::size_t(i)] = {{i == 1 ? 1.0 : 0.0, i == 4 ? 1.0 : 0.0, 0}, {}, 1, 1};
  }
  write_png(file("a.png"), film);
  EXPECT_EQ(read_png(file("a.png"), PNG_FORMAT_RGB, 2, 3),
            (std::vector<int>{0, 0, 0, 255, 0, 0, 0, 0, 0, 0, 0, 0, 0, 255, 0, 0, 0, 0}));
  EXPECT_NE(read_bytes(file("a.png")).find("sRGB"), std::string::npos);
}

TEST_F(Image, PngRefusesAndNamesAPixelThatIsNotFinite) {
  Film film = random_film(20, 20, 10, 5, 3, 3);
  film.pixels[5].sum.y = std::numeric_limits<double>::quiet_NaN();
  EXPECT_NE(error_of([&] { write_png(file("a.png"), film); }).find("pixel (12, 6)"),
            std::string::npos);
  EXPECT_TRUE(fs::is_empty(folder_));
  film.pixels[5].sum.y = 1;
  EXPECT_THROW(write_png(file("a.png"), film, {std::nan("")}), Error);
  EXPECT_THROW(write_png(file("a.png"), film, {1e6}), Error);
}

/// Writes R, G, B in the order of `pixels`, with a data window that does not begin at 0.
template <class Pixel>
void write_sky(const fs::path& file, Imf::PixelType type, int width, int height, bool tiled,
               const std::vector<Pixel>& rgb, const char* first_channel = "R") {
  const Imath::Box2i data({-3, 11}, {width - 4, height + 10});
  Imf::Header header(data, data);
  Imf::FrameBuffer buffer;
  const char* names[] = {first_channel, "G", "B"};
  for (std::size_t c = 0; c < 3; ++c) {
    header.channels().insert(names[c], Imf::Channel(type));
    buffer.insert(names[c], Imf::Slice::Make(type, &rgb[c], data, 3 * sizeof(Pixel),
                                             3 * sizeof(Pixel) * std::size_t(width)));
  }
  if (tiled) {
    header.setTileDescription(Imf::TileDescription(8, 8, Imf::MIPMAP_LEVELS));
    Imf::TiledOutputFile out(file.c_str(), header);
    out.setFrameBuffer(buffer);
    out.writeTiles(0, out.numXTiles() - 1, 0, out.numYTiles() - 1);
    for (int level = 1; level < out.numLevels(); ++level) {  // any values: only level 0 is read
      out.writeTiles(0, out.numXTiles(level) - 1, 0, out.numYTiles(level) - 1, level);
    }
  } else {
    Imf::OutputFile out(file.c_str(), header);
    out.setFrameBuffer(buffer);
    out.writePixels(height);
  }
}

std::vector<float> ramp(int pixels) {
  std::vector<float> values;
  for (int i = 0; i < 3 * pixels; ++i) values.push_back(float(i) / 64);  // exact in half
  return values;
}

void expect_ramp(const ImageSky& sky, int width, int height) {
  ASSERT_EQ(sky.width, width);
  ASSERT_EQ(sky.height, height);
  ASSERT_EQ(sky.pixels.size(), std::size_t(width) * std::size_t(height));
  for (std::size_t i = 0; i < sky.pixels.size(); ++i) {
    const auto n = float(3 * i);
    ASSERT_EQ(sky.pixels[i], Rgb(n / 64, (n + 1) / 64, (n + 2) / 64)) << i;
  }
  EXPECT_EQ(sky.scale, Rgb(1.0f));
  EXPECT_EQ(sky.rotation, 0);
}

TEST_F(Image, SkyComesBackFromEveryLayout) {
  const std::vector<float> values = ramp(20 * 19);
  const std::vector<half> halves(values.begin(), values.end());
  for (const bool tiled : {false, true}) {
    write_sky(file("float.exr"), Imf::FLOAT, 20, 19, tiled, values);
    expect_ramp(read_sky(file("float.exr")), 20, 19);
    write_sky(file("half.exr"), Imf::HALF, 20, 19, tiled, halves);
    expect_ramp(read_sky(file("half.exr")), 20, 19);
  }
}

TEST_F(Image, SkyReadsWhatTheRendererWrote) {
  const Film film = random_film(40, 130, 0, 0, 40, 130);
  write_exr(file("a.exr"), film, {});
  for (const int threads : {1, 3}) {
    use_exr_threads(threads);
    const ImageSky sky = read_sky(file("a.exr"));
    ASSERT_EQ(sky.pixels.size(), film.pixels.size());
    for (std::size_t i = 0; i < sky.pixels.size(); ++i) {
      EXPECT_EQ(sky.pixels[i], Rgb(mean(film.pixels[i]))) << threads << " threads";
    }
  }
  use_exr_threads(1);
}

/// As wide as a render takes them.
TEST_F(Image, VeryWidePicturesAreReadAgain) {
  const Film film = random_film(70'000, 3, 0, 0, 70'000, 3);
  write_exr(file("a.exr"), film, {});
  const ImageSky sky = read_sky(file("a.exr"));
  EXPECT_EQ(sky.width, 70'000);
  EXPECT_EQ(sky.pixels[209'999], Rgb(mean(film.pixels[209'999])));
}

TEST_F(Image, SkyThatIsAPartOfAPictureIsRefused) {
  write_exr(file("a.exr"), random_film(40, 30, 7, 9, 5, 20), {});
  EXPECT_TRUE(says(error_of([&] { (void)read_sky(file("a.exr")); }), "exr.sky_is_a_part"));
}

TEST_F(Image, SkyWithoutRedSaysWhatIsThere) {
  write_sky(file("a.exr"), Imf::FLOAT, 4, 4, false, ramp(16), "Y");
  const std::string message = error_of([&] { (void)read_sky(file("a.exr")); });
  EXPECT_TRUE(says(message, "exr.no_channel_r"));
}

TEST_F(Image, SkyNamesABadPixel) {
  const float bad[] = {-1, std::numeric_limits<float>::infinity(),
                       std::numeric_limits<float>::quiet_NaN()};
  for (const float value : bad) {
    std::vector<float> values = ramp(10 * 40);
    values[3 * (23 * 10 + 7) + 1] = value;
    write_sky(file("a.exr"), Imf::FLOAT, 10, 40, false, values);
    const std::string message = error_of([&] { (void)read_sky(file("a.exr")); });
    EXPECT_TRUE(says(message, "exr.pixel_expected_finite"));
  }
}

TEST_F(Image, SkyThatIsTooLargeIsRefusedBeforeItIsRead) {
  Imf::Header header(1 << 15, 1 << 14);
  for (const char* name : {"R", "G", "B"}) header.channels().insert(name, Imf::Channel(Imf::HALF));
  { Imf::OutputFile out(file("a.exr").c_str(), header); }
  EXPECT_NE(error_of([&] { (void)read_sky(file("a.exr")); }).find("32768 x 16384 pixels"),
            std::string::npos);
}

/// Whether to try a file's damage at this byte: on a commit every third, and every one at the ends.
bool is_cut(std::size_t at, std::size_t size) {
  constexpr std::size_t kEnd = 64;
  return proof::has_turn(at, 3) || at < kEnd || at + kEnd > size;
}

TEST_F(Image, EveryTruncationOfASkyIsRefused) {
  write_sky(file("a.exr"), Imf::FLOAT, 5, 18, false, ramp(5 * 18));
  const std::string whole = read_bytes(file("a.exr"));
  for (std::size_t size = 0; size < whole.size(); ++size) {
    if (!is_cut(size, whole.size())) continue;
    write_bytes(file("cut.exr"), whole.substr(0, size));
    EXPECT_THROW((void)read_sky(file("cut.exr")), Error) << size << " of " << whole.size();
  }
}

TEST_F(Image, TruncatedTilesAreRefusedUnlessOnlyCoarseLevelsAreCut) {
  write_sky(file("a.exr"), Imf::FLOAT, 9, 10, true, ramp(9 * 10));
  const std::string whole = read_bytes(file("a.exr"));
  std::size_t refused = 0, cuts = 0;
  for (std::size_t size = 0; size < whole.size(); ++size) {
    if (!is_cut(size, whole.size())) continue;
    ++cuts;
    write_bytes(file("cut.exr"), whole.substr(0, size));
    try {
      expect_ramp(read_sky(file("cut.exr")), 9, 10);
    } catch (const Error&) {
      ++refused;
    }
  }
  EXPECT_GT(refused, cuts / 2);
}

TEST_F(Image, FlippedBytesOfASkyAreReadOrRefused) {
  write_sky(file("a.exr"), Imf::FLOAT, 5, 18, false, ramp(5 * 18));
  const std::string whole = read_bytes(file("a.exr"));
  for (std::size_t at = 0; at < whole.size(); ++at) {
    if (!is_cut(at, whole.size())) continue;
    std::string flipped = whole;
    flipped[at] = char(flipped[at] ^ (1 << (at % 8)));
    write_bytes(file("flipped.exr"), flipped);
    try {
      const ImageSky sky = read_sky(file("flipped.exr"));
      for (const Rgb& c : sky.pixels) ASSERT_TRUE(is_finite(c) && min_component(c) >= 0);
    } catch (const Error& e) {
      EXPECT_NE(std::string(e.what()).find("flipped.exr: "), std::string::npos);
    }
  }
}

TEST_F(Image, SkyOfAFileThatIsNotOneIsRefused) {
  write_bytes(file("text.exr"), "This is not a picture, it is a text.");
  EXPECT_THROW((void)read_sky(file("text.exr")), Error);
  EXPECT_THROW((void)read_sky(file("absent.exr")), Error);
  EXPECT_THROW((void)read_sky(folder_), Error);
}

}  // namespace image_test
}  // namespace pvol::formats
