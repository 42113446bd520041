// How EXR files are laid out, as other programs find it: OpenEXR's own reader for parts and types,
// read_exr.py for what the format's own document says, and oiiotool (Debian: openimageio-tools),
// where it is installed, for what compositors see.
#include <ImfChannelList.h>
#include <ImfFrameBuffer.h>
#include <ImfHeader.h>
#include <ImfInputPart.h>
#include <ImfMultiPartInputFile.h>
#include <ImfStandardAttributes.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cstdio>
#include <cstdlib>
#include <map>
#include <memory>
#include <sstream>

#include "pvol/error.h"
#include "pvol/formats/image.h"
#include "support/error_of.h"
#include "support/messages.h"
#include "support/temporary_folder.h"

namespace pvol::formats {
namespace exr_layout_test {

using test::error_of;

/// 40 x 36 pixels: of samples that differ, with two layers.
Film make_film() {
  Film f{
      .width = 64, .height = 48, .x = 5, .y = 3, .crop_width = 40, .crop_height = 36, .pixels = {}};
  f.layers = {{"sky", {}}, {"depth", {}, "Z"}};
  for (int i = 0; i < f.crop_width * f.crop_height; ++i) {
    PixelSums p;
    p.samples = std::uint32_t(3 + i % 4);
    p.sum = Vec3d(i % 17, 0.5 * (i % 5), 2 + i % 3) * p.samples;
    p.sum_squares = p.sum * p.sum;
    p.alpha = 0.25 * p.samples;
    f.counts.push_back({std::uint64_t(i) * p.samples, 3 * p.samples, 2 * p.samples, p.samples});
    f.pixels.push_back(p);
    f.layers[0].sums.push_back(p.sum * 0.5);
    f.layers[1].sums.emplace_back(double(i) * p.samples, 0, 0);
  }
  return f;
}

double depth_of(const Film& f, std::size_t pixel) {
  const auto at = std::ranges::find(f.layers, "depth", &Layer::name);
  return at == f.layers.end() ? -1 : at->sums[pixel].x / f.pixels[pixel].samples;
}

ExrOptions all_of(ExrCompression compression, bool multipart = false) {
  return {.aovs = AovSet::all(), .multipart = multipart, .compression = compression};
}

std::vector<float> read(Imf::MultiPartInputFile& in, int part, const char* name) {
  const Imath::Box2i box = in.header(part).dataWindow();
  std::vector<float> values(std::size_t(box.max.x - box.min.x + 1) *
                            std::size_t(box.max.y - box.min.y + 1));
  Imf::FrameBuffer buffer;
  buffer.insert(name, Imf::Slice::Make(Imf::FLOAT, values.data(), box));
  Imf::InputPart input(in, part);
  input.setFrameBuffer(buffer);
  input.readPixels(box.min.y, box.max.y);
  return values;
}

TEST(ExrLayout, HalfIsForColourAlone) {
  const TemporaryFolder folder;
  ExrOptions o = all_of(ExrCompression::zip);
  o.pixels = PixelType::half;
  EXPECT_EQ(write_exr(folder.file("a.exr"), make_film(), {}, o), 0u);
  const Imf::MultiPartInputFile in(folder.file("a.exr").c_str());
  const Imf::ChannelList& channels = in.header(0).channels();
  for (auto c = channels.begin(); c != channels.end(); ++c) {
    const std::string name = c.name();
    const bool colour = name.size() == 1 || name.starts_with("sky.");
    EXPECT_EQ(c.channel().type, colour ? Imf::HALF : Imf::FLOAT) << name;
  }
}

TEST(ExrLayout, WhatHalfDoesNotHoldIsClampedAndCounted) {
  const TemporaryFolder folder;
  Film film{1, 1, 0, 0, 1, 1, {}};
  film.pixels.push_back({Vec3d(1e6, -1e6, 65504), {}, 0, 1});
  EXPECT_EQ(write_exr(folder.file("a.exr"), film, {}, {.pixels = PixelType::half}), 2u);
  const Film back = read_film(folder.file("a.exr")).film;
  EXPECT_EQ(mean(back.pixels[0]), Vec3d(65504, -65504, 65504));
  EXPECT_EQ(write_exr(folder.file("a.exr"), film, {}, {}), 0u);
  EXPECT_EQ(mean(read_film(folder.file("a.exr")).film.pixels[0]), Vec3d(1e6, -1e6, 65504));
}

/// The same values whatever the packing, but for the colours of dwaa.
TEST(ExrLayout, EveryCompressionKeepsNumbers) {
  const TemporaryFolder folder;
  const Film film = make_film();
  for (const auto& [compression, name] : names(ExrCompression{})) {
    for (const bool multipart : {false, true}) {
      const bool rounds = compression == ExrCompression::dwaa;
      if (rounds && !multipart) continue;
      write_exr(folder.file("a.exr"), film, {}, all_of(compression, multipart));
      const Film back = read_film(folder.file("a.exr")).film;
      for (std::size_t i = 0; i < film.pixels.size(); ++i) {
        const PixelSums &a = film.pixels[i], &b = back.pixels[i];
        ASSERT_EQ(a.samples, b.samples) << name;
        ASSERT_EQ(film.counts[i], back.counts[i]) << name;
        ASSERT_EQ(float(depth_of(film, i)), float(depth_of(back, i))) << name;
        const double error = length(mean(a) - mean(b));
        ASSERT_LE(error, rounds ? 0.1 * length(mean(a)) : 0) << name;
      }
    }
  }
}

/// It would round numbers whose channels have the names of colours.
TEST(ExrLayout, NumbersAreNotRoundedByDwaa) {
  const TemporaryFolder folder;
  const ExrOptions o = all_of(ExrCompression::dwaa);
  const std::string message =
      error_of([&] { write_exr(folder.file("a.exr"), make_film(), {}, o); });
  EXPECT_TRUE(says(message, "exr.compression_dwaa_rounds"));
  EXPECT_FALSE(std::filesystem::exists(folder.file("a.exr")));
  EXPECT_NO_THROW(validate({.aovs = {Aov::lights}, .compression = ExrCompression::dwaa}));
}

TEST(ExrLayout, PartsHaveTheNamesOfLayers) {
  const TemporaryFolder folder;
  write_exr(folder.file("a.exr"), make_film(), {{"pvol:seed", "3"}},
            all_of(ExrCompression::dwaa, true));
  Imf::MultiPartInputFile in(folder.file("a.exr").c_str());
  const char* const parts[] = {"rgba",         "samples",  "transmittance", "variance", "lookups",
                               "bounds_tests", "segments", "collisions",    "sky",      "depth"};
  ASSERT_EQ(in.parts(), int(std::size(parts)));
  for (int i = 0; i < in.parts(); ++i) {
    EXPECT_EQ(in.header(i).name(), parts[i]);
    const bool colour = i == 0 || in.header(i).name() == "sky";
    EXPECT_EQ(in.header(i).compression(), colour ? Imf::DWAA_COMPRESSION : Imf::ZIP_COMPRESSION);
  }
  EXPECT_NE(in.header(0).find("pvol:seed"), in.header(0).end());
  EXPECT_EQ(read(in, 1, "samples.Y")[5], 4);
}

/// In RenderMan's convention: points before the camera have positive z, and the image's edges
/// are 1.
TEST(ExrLayout, MatricesTakeTheWorldToTheImage) {
  const TemporaryFolder folder;
  Film film = make_film();
  const Camera camera{{1, 2, 3}, {1, 2, -7}, {0, 1, 0}, 90};
  write_exr(folder.file("a.exr"), film, {}, {.camera = camera});
  const Imf::MultiPartInputFile in(folder.file("a.exr").c_str());
  const Imath::M44f& to_camera = Imf::worldToCamera(in.header(0));
  const Imath::M44f& to_ndc = Imf::worldToNDC(in.header(0));
  const Imath::V3f ahead(1, 2, -7), right(11, 2, -7), above(1, 12, -7);
  EXPECT_EQ(ahead * to_camera, Imath::V3f(0, 0, 10));
  EXPECT_EQ(right * to_camera, Imath::V3f(10, 0, 10));
  EXPECT_EQ(above * to_camera, Imath::V3f(0, 10, 10));
  EXPECT_NEAR((above * to_ndc).y, 1, 1e-6);  // the field of view is vertical
  EXPECT_NEAR((right * to_ndc).x, 48.0 / 64, 1e-6);
  EXPECT_NEAR((ahead * to_ndc).z, 0.9, 1e-6);
  EXPECT_NO_THROW((void)to_ndc.inverse(true));
}

/// Of shifted cameras and parallel ones the edges are 1 as well, as their rays have it.
TEST(ExrLayout, MatricesAreThoseOfTheCamerasRays) {
  const TemporaryFolder folder;
  Film film = make_film();
  for (const CameraKind kind :
       {CameraKind::perspective, CameraKind::orthographic, CameraKind::latlong}) {
    Camera camera{{1, 2, 3}, {1, 2, -7}, {0, 1, 0}, 90};
    camera.kind = kind, camera.ortho_scale = 4;
    if (kind != CameraKind::latlong) camera.shift = {0.25, -0.5};
    write_exr(folder.file("a.exr"), film, {}, {.camera = camera});
    const Imf::MultiPartInputFile in(folder.file("a.exr").c_str());
    EXPECT_EQ(Imf::hasWorldToNDC(in.header(0)), kind != CameraKind::latlong);
    if (kind == CameraKind::latlong) continue;
    // The picture is 64 by 48 and so its longer side 64; perspective: 8/3 at distance 1.
    const bool parallel = kind == CameraKind::orthographic;
    const double side = parallel ? 4 : 2.0 * 64 / 48, depth = parallel ? 1 : 10;
    const Vec3d middle = Vec3d(0.25, -0.5, 0) * side * depth + Vec3d(1, 2, -7);
    const Vec3d corner = middle + Vec3d(side / 2, side / 2 * 48 / 64, 0) * depth;
    const Imath::M44f& to_ndc = Imf::worldToNDC(in.header(0));
    const auto at = [&](Vec3d p) {
      return Imath::V3f(float(p.x), float(p.y), float(p.z)) * to_ndc;
    };
    EXPECT_NEAR(at(middle).x, 0, 1e-5);
    EXPECT_NEAR(at(middle).y, 0, 1e-5);
    EXPECT_NEAR(at(corner).x, 1, 1e-5);
    EXPECT_NEAR(at(corner).y, 1, 1e-5);
  }
}

// --- other readers -------------------------------------------------------------------------------

/// What a command prints.
std::string printed(const std::string& command) {
  const std::unique_ptr<FILE, int (*)(FILE*)> pipe(popen((command + " 2>&1").c_str(), "r"), pclose);
  std::string text;
  std::array<char, 4096> part{};
  while (pipe && std::fgets(part.data(), int(part.size()), pipe.get())) text += part.data();
  return text;
}

using PixelValues = std::map<std::string, double>;

/// The second pixel of make_film() with all that it has.
void expect_all(const PixelValues& found) {
  const PixelValues expected{{"R", 1},          {"G", 0.5},
                             {"B", 3},          {"A", 0.25},
                             {"samples.Y", 4},  {"transmittance.Y", 0.75},
                             {"lookups.Y", 1},  {"bounds_tests.Y", 3},
                             {"segments.Y", 2}, {"collisions.Y", 1},
                             {"sky.R", 0.5},    {"sky.G", 0.25},
                             {"sky.B", 1.5},    {"depth.Z", 1}};
  EXPECT_EQ(found.size(), expected.size() + 3) << "and variances";
  for (const auto& [name, value] : expected) {
    EXPECT_TRUE(found.contains(name) && found.at(name) == value) << name;
  }
}

TEST(ExrInPython, HasEveryValueInEveryLayout) {
  const TemporaryFolder folder;
  const std::string file = folder.file("a.exr").string();
  for (const ExrCompression packing :
       {ExrCompression::none, ExrCompression::zips, ExrCompression::zip}) {
    for (const bool multipart : {false, true}) {
      for (const PixelType type : {PixelType::half, PixelType::single}) {
        ExrOptions o = all_of(packing, multipart);
        o.pixels = type;
        write_exr(file, make_film(), {}, o);
        std::istringstream lines(printed(PVOL_PYTHON " '" PVOL_READ_EXR "' '" + file + "' 6 3"));
        PixelValues values;
        std::string part, name, kind;
        for (double v = 0; lines >> part >> name >> kind >> v;) {
          values[name] = v;
          const bool colour = name.size() == 1 || name.starts_with("sky.");
          EXPECT_EQ(kind, colour ? pvol::name(type) : std::string("float")) << name;
        }
        expect_all(values);
      }
    }
  }
}

bool has_oiiotool() { return std::system("oiiotool --version >/dev/null 2>&1") == 0; }
std::string oiiotool(const std::string& arguments) { return printed("oiiotool " + arguments); }

class ExrInOpenImageIo : public testing::Test {
 protected:
  void SetUp() override {
    if (!has_oiiotool()) GTEST_SKIP() << "needs oiiotool; install openimageio-tools";
  }
  /// The channels of the film's second pixel, by name, of all parts.
  PixelValues pixel() {
    PixelValues values;
    std::istringstream heads(oiiotool("--info -v -a " + file_));
    std::istringstream pixels(oiiotool("-a --dumpdata " + file_));
    const std::string list = "channel list: ", place = "Pixel (6, 3): ";
    for (std::string head, line; std::getline(heads, head);) {
      if (head.find(list) == head.npos) continue;
      do std::getline(pixels, line);
      while (pixels && line.find(place) == line.npos);
      std::ranges::replace(head, ',', ' ');
      std::istringstream names(head.substr(head.find(list) + list.size()));
      std::istringstream numbers(
          line.substr(std::min(line.size(), line.find(place) + place.size())));
      for (std::string name; names >> name;) numbers >> values[name];
    }
    return values;
  }
  TemporaryFolder folder_;
  std::string file_ = folder_.file("a.exr").string();
};

TEST_F(ExrInOpenImageIo, ColourAloneIsAPlainPicture) {
  Film plain = make_film();
  plain.layers.clear();
  write_exr(file_, plain, {}, {.opaque = true, .pixels = PixelType::half});
  const std::string told = oiiotool("--info -v " + file_);
  EXPECT_NE(told.find("40 x   36, 4 channel, half openexr"), std::string::npos) << told;
  EXPECT_NE(told.find("channel list: R, G, B, A\n"), std::string::npos) << told;
  EXPECT_NE(told.find("full/display size: 64 x 48"), std::string::npos) << told;
  const PixelValues expected{{"R", 1}, {"G", 0.5}, {"B", 3}, {"A", 1}};
  EXPECT_EQ(pixel(), expected);
}

TEST_F(ExrInOpenImageIo, LayersAreChannelsWithTheirNames) {
  write_exr(file_, make_film(), {}, all_of(ExrCompression::zip));
  const std::string told = oiiotool("--info -v " + file_);
  for (const char* names : {"R, G, B, A, ", "variance.R, variance.G, variance.B", "samples.Y",
                            "sky.R, sky.G, sky.B", "depth.Z"}) {
    EXPECT_NE(told.find(names), std::string::npos) << names << "\n" << told;
  }
  expect_all(pixel());
}

TEST_F(ExrInOpenImageIo, PartsAreSubimages) {
  write_exr(file_, make_film(), {}, all_of(ExrCompression::zips, true));
  const std::string told = oiiotool("--info -v -a " + file_);
  EXPECT_NE(told.find("10 subimages"), std::string::npos) << told;
  EXPECT_NE(told.find("oiio:subimagename: \"samples\""), std::string::npos) << told;
  expect_all(pixel());
}

}  // namespace exr_layout_test
}  // namespace pvol::formats
