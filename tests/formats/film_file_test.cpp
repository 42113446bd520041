// Films written and read again, and EXR files of other programs.
#include <ImfChannelList.h>
#include <ImfFrameBuffer.h>
#include <ImfHeader.h>
#include <ImfOutputFile.h>
#include <gtest/gtest.h>
#include <png.h>

#include <functional>
#include <limits>
#include <map>
#include <random>
#include <vector>

#include "pvol/error.h"
#include "pvol/formats/image.h"
#include "support/messages.h"
#include "support/temporary_folder.h"

namespace pvol::formats {
namespace film_file_test {

std::string error_of(const std::function<void()>& call) {
  try {
    call();
  } catch (const Error& e) {
    return e.what();
  }
  return "no error";
}

/// A crop of an image with noise, pixels without variance and pixels of a few samples.
Film some_film() {
  std::mt19937 random(3);
  std::exponential_distribution<double> law(1);
  Film f;
  f.width = 100, f.height = 80;
  f.x = 13, f.y = 7;
  f.crop_width = 21, f.crop_height = 37;
  for (int i = 0; i < f.crop_width * f.crop_height; ++i) {
    PixelSums p;
    p.samples = std::uint32_t(1 + i % 50);
    for (std::uint32_t s = 0; s < p.samples; ++s) {
      const Vec3d v = i % 7 == 0 ? Vec3d(0.25) : Vec3d(law(random), law(random), law(random));
      p.sum += v, p.sum_squares += v * v, p.alpha += 0.5;
    }
    PixelCounts& counts = f.counts.emplace_back();
    counts[std::size_t(PixelCounter::lookups)] = std::uint64_t(i) * 1000;
    counts[std::size_t(PixelCounter::segments)] = 3 * p.samples;
    counts[std::size_t(PixelCounter::collisions)] = 7;
    f.pixels.push_back(p);
  }
  return f;
}

/// Everything that pixels have, in one part or several.
ExrOptions everything(bool multipart = false) {
  return {.aovs = AovSet::all(), .multipart = multipart};
}

class FilmFileInParts : public testing::TestWithParam<bool> {};

TEST_P(FilmFileInParts, IsReadAsItWasWritten) {
  const TemporaryFolder folder;
  const Film film = some_film();
  write_exr(folder.file("a.exr"), film, {{"pvol:seed", "17"}, {"pvol:biased", "no"}},
            everything(GetParam()));
  const StoredFilm s = read_film(folder.file("a.exr"));
  EXPECT_TRUE(s.has_variances);
  EXPECT_EQ(s.attributes.at("pvol:seed"), "17");
  EXPECT_EQ(s.film.width, 100);
  EXPECT_EQ(s.film.height, 80);
  EXPECT_EQ(s.film.x, 13);
  EXPECT_EQ(s.film.y, 7);
  ASSERT_EQ(s.film.crop_width, 21);
  ASSERT_EQ(s.film.crop_height, 37);
  ASSERT_EQ(s.film.pixels.size(), film.pixels.size());
  for (std::size_t i = 0; i < film.pixels.size(); ++i) {
    const PixelSums &a = film.pixels[i], &b = s.film.pixels[i];
    EXPECT_EQ(a.samples, b.samples);
    for (int c = 0; c < 3; ++c) {
      EXPECT_NEAR(mean(a)[c], mean(b)[c], 1e-7 * mean(a)[c]);
      const double va = variance_of_mean(a)[c], vb = variance_of_mean(b)[c];
      EXPECT_NEAR(va, vb, 1e-6 * va);
      EXPECT_EQ(va == 0, vb == 0) << i;
    }
    EXPECT_NEAR(a.alpha, b.alpha, 1e-5);
    for (const PixelCounter c : {PixelCounter::segments, PixelCounter::collisions}) {
      EXPECT_EQ(film.count(i, c), s.film.count(i, c));
    }
    const auto lookups = double(film.count(i, PixelCounter::lookups));
    EXPECT_NEAR(lookups, double(s.film.count(i, PixelCounter::lookups)), 1e-6 * lookups);
  }
}

INSTANTIATE_TEST_SUITE_P(OneAndSeveral, FilmFileInParts, testing::Bool());

TEST(FilmFile, WritingItAgainGivesTheSameChannels) {
  const TemporaryFolder folder;
  write_exr(folder.file("a.exr"), some_film(), {}, everything());
  const Film once = read_film(folder.file("a.exr")).film;
  write_exr(folder.file("b.exr"), once, {}, everything());
  const Film twice = read_film(folder.file("b.exr")).film;
  for (std::size_t i = 0; i < once.pixels.size(); ++i) {
    EXPECT_EQ(float(mean(once.pixels[i]).x), float(mean(twice.pixels[i]).x));
    EXPECT_EQ(float(variance_of_mean(once.pixels[i]).y),
              float(variance_of_mean(twice.pixels[i]).y));
  }
}

/// Layers are named parts of the radiance, beside the film's own channels.
TEST_P(FilmFileInParts, LayersComeBackWithTheirNames) {
  const TemporaryFolder folder;
  Film film = some_film();
  film.layers = {{"depth", {}, "Z"}, {"emission", {}}, {"position", {}, "XYZ"}, {"sun.1", {}}};
  for (const PixelSums& p : film.pixels) {
    film.layers[0].sums.emplace_back(p.sum.x, 0, 0);
    film.layers[1].sums.push_back(p.sum * 0.25);
    film.layers[2].sums.push_back(p.sum * 3.0);
    film.layers[3].sums.push_back(p.sum * -0.75);  // guided paths may have negative parts
  }
  write_exr(folder.file("a.exr"), film, {}, everything(GetParam()));
  const Film back = read_film(folder.file("a.exr")).film;
  ASSERT_EQ(back.layers.size(), 4u);
  for (std::size_t k = 0; k < 4; ++k) {
    EXPECT_EQ(back.layers[k].name, film.layers[k].name);
    EXPECT_EQ(back.layers[k].components, film.layers[k].components);
    ASSERT_EQ(back.layers[k].sums.size(), film.pixels.size());
    for (std::size_t i = 0; i < film.pixels.size(); ++i) {
      const Vec3d a = film.layers[k].sums[i], b = back.layers[k].sums[i];
      EXPECT_LE(length(a - b), 1e-6 * length(a)) << i;
    }
  }
  film.layers[3].sums[5].y = std::nan("");
  write_exr(folder.file("b.exr"), film, {}, everything(GetParam()));
  EXPECT_TRUE(
      says(error_of([&] { (void)read_film(folder.file("b.exr")); }), "film.pixel_layer_sun"));
}

/// An EXR of 4 x 2 pixels with these channels, of one value each.
void write_channels(const std::filesystem::path& file, const std::map<std::string, float>& values) {
  Imf::Header header(4, 2);
  Imf::FrameBuffer buffer;
  std::map<std::string, std::vector<float>> pixels;
  for (const auto& [name, value] : values) {
    header.channels().insert(name, Imf::Channel(Imf::FLOAT));
    pixels[name].assign(8, value);
    buffer.insert(name, Imf::Slice::Make(Imf::FLOAT, pixels[name].data(), header.dataWindow()));
  }
  Imf::OutputFile out(file.c_str(), header);
  out.setFrameBuffer(buffer);
  out.writePixels(2);
}

/// Channels as versions before AOVs named them.
TEST(FilmFile, OldNamesAreRead) {
  const TemporaryFolder folder;
  write_channels(folder.file("a.exr"), {{"R", 1},
                                        {"G", 2},
                                        {"B", 3},
                                        {"A", 0.25f},
                                        {"variance.R", 0.5f},
                                        {"variance.G", 0.5f},
                                        {"variance.B", 0.5f},
                                        {"samples", 4},
                                        {"count.lookups", 7},
                                        {"count.segments", 8},
                                        {"count.collisions", 9},
                                        {"sky.R", 0.125f},
                                        {"sky.G", 0.25f},
                                        {"sky.B", 0.5f}});
  const StoredFilm s = read_film(folder.file("a.exr"));
  EXPECT_TRUE(s.has_variances);
  const PixelSums& p = s.film.pixels.front();
  EXPECT_EQ(p.samples, 4u);
  EXPECT_EQ(mean(p), Vec3d(1, 2, 3));
  EXPECT_NEAR(variance_of_mean(p).z, 0.5, 1e-7);
  EXPECT_EQ(p.alpha, 1);
  EXPECT_EQ(s.film.count(0, PixelCounter::lookups), 28u);
  EXPECT_EQ(s.film.count(0, PixelCounter::segments), 32u);
  EXPECT_EQ(s.film.count(0, PixelCounter::collisions), 36u);
  ASSERT_EQ(s.film.layers.size(), 1u);
  EXPECT_EQ(s.film.layers[0].name, "sky");
  EXPECT_EQ(s.film.layers[0].sums[0], Vec3d(0.5, 1, 2));
}

/// Alpha is 1 where a background is seen; what the film had of it is in the transmittance.
TEST(FilmFile, AlphaComesBackFromTheTransmittance) {
  const TemporaryFolder folder;
  const Film film = some_film();
  ExrOptions o{.opaque = true};
  write_exr(folder.file("a.exr"), film, {}, o);
  for (const PixelSums& p : read_film(folder.file("a.exr")).film.pixels) EXPECT_EQ(p.alpha, 1);
  o.aovs = {Aov::transmittance, Aov::samples, Aov::variance};
  write_exr(folder.file("b.exr"), film, {}, o);
  const Film back = read_film(folder.file("b.exr")).film;
  for (std::size_t i = 0; i < film.pixels.size(); ++i) {
    EXPECT_NEAR(back.pixels[i].alpha, film.pixels[i].alpha, 1e-5);
  }
}

TEST(FilmFile, OtherProgramsPicturesHaveNoVariance) {
  const TemporaryFolder folder;
  write_channels(folder.file("a.exr"), {{"R", 0.5f}, {"G", -0.25f}, {"B", 2}, {"Z", 7}});
  const StoredFilm s = read_film(folder.file("a.exr"));
  EXPECT_FALSE(s.has_variances);
  ASSERT_EQ(s.film.pixels.size(), 8u);
  for (const PixelSums& p : s.film.pixels) {
    EXPECT_EQ(p.samples, 1u);
    EXPECT_EQ(mean(p), Vec3d(0.5, -0.25, 2));
  }
}

TEST(FilmFile, WhatMakesNoSenseIsRefused) {
  const TemporaryFolder folder;
  const std::map<std::string, float> good{{"R", 1},          {"G", 1},          {"B", 1},
                                          {"variance.R", 1}, {"variance.G", 1}, {"variance.B", 1},
                                          {"samples.Y", 4}};
  const auto refused = [&](const std::string& channel, float value) {
    std::map<std::string, float> bad = good;
    bad[channel] = value;
    write_channels(folder.file("a.exr"), bad);
    return error_of([&] { (void)read_film(folder.file("a.exr")); });
  };
  EXPECT_EQ(refused("R", 3), "no error");
  EXPECT_TRUE(says(refused("variance.G", -1), "film.pixel_holds_samples"));
  EXPECT_NE(refused("samples.Y", 2.5f).find("samples.Y 2.5"), std::string::npos);
  EXPECT_NE(refused("samples.Y", 1e20f).find("samples"), std::string::npos);
  EXPECT_NE(refused("R", std::numeric_limits<float>::infinity()).find("finite"), std::string::npos);
  write_channels(folder.file("b.exr"), {{"R", 1}, {"Y", 1}});
  EXPECT_TRUE(says(error_of([&] { (void)read_film(folder.file("b.exr")); }), "film.no_channel_g"));
  EXPECT_THROW((void)read_film(folder.file("absent.exr")), Error);
}

TEST(FilmFile, EveryTruncationIsRefused) {
  const TemporaryFolder folder;
  write_channels(folder.file("a.exr"), {{"R", 1}, {"G", 2}, {"B", 3}});
  const std::string whole = read_bytes(folder.file("a.exr"));
  for (std::size_t size = 0; size < whole.size(); ++size) {
    std::ofstream(folder.file("cut.exr"), std::ios::binary) << whole.substr(0, size);
    EXPECT_THROW((void)read_film(folder.file("cut.exr")), Error) << size;
  }
}

TEST(PictureFile, BytesAreThoseOfTheFilmsPng) {
  const TemporaryFolder folder;
  const Film film = some_film();
  write_png(folder.file("film.png"), film, {.exposure = 0.5});
  const Picture picture = to_picture(film, {.exposure = 0.5});
  write_png(folder.file("picture.png"), picture);
  EXPECT_EQ(read_bytes(folder.file("film.png")), read_bytes(folder.file("picture.png")));
  const std::vector<std::byte> encoded = encode_png(picture);
  png_image image{};
  image.version = PNG_IMAGE_VERSION;
  ASSERT_TRUE(png_image_begin_read_from_memory(&image, encoded.data(), encoded.size()));
  image.format = PNG_FORMAT_RGB;
  std::vector<std::uint8_t> rgb(PNG_IMAGE_SIZE(image));
  ASSERT_TRUE(png_image_finish_read(&image, nullptr, rgb.data(), 0, nullptr));
  EXPECT_EQ(rgb, picture.rgb);
}

}  // namespace film_file_test
}  // namespace pvol::formats
