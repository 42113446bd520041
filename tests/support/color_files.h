// Pictures of one colour in files and on screens, for tests of colour spaces.
#pragma once

#include <ImfChannelList.h>
#include <ImfChromaticities.h>
#include <ImfFrameBuffer.h>
#include <ImfHeader.h>
#include <ImfOutputFile.h>
#include <ImfStandardAttributes.h>
#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>
#include <vector>

#include "pvol/formats/image.h"
#include "support/temporary_folder.h"

namespace pvol::formats::color_files {

inline constexpr Vec3d kColor(0.5, 0.25, 0.125);

/// Every pixel has the colour.
inline Film film_of(Vec3d color, ColorSpace space) {
  Film film{4, 2, 0, 0, 4, 2, std::vector<PixelSums>(8)};
  for (PixelSums& p : film.pixels) p = {color, {}, 1, 1};
  film.color_space = space;
  return film;
}

/// The codes of a film's first pixel.
inline std::vector<int> codes_of(const Film& film, const Display& display) {
  const Picture p = to_picture(film, display);
  return {p.rgb.begin(), p.rgb.begin() + 3};
}

inline void expect_codes(const std::vector<int>& a, const std::vector<int>& b, int off = 1) {
  ASSERT_EQ(a.size(), b.size());
  for (std::size_t i = 0; i < a.size(); ++i) EXPECT_NEAR(a[i], b[i], off) << i;
}

/// A folder, and the variable OCIO as it was.
class ColorFiles : public testing::Test {
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

inline std::string bytes_of(const std::filesystem::path& file) {
  std::ifstream in(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

/// A picture of one colour with these primaries.
inline std::filesystem::path write_picture(const std::filesystem::path& file, Vec3f color,
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

inline Imf::Chromaticities acescg() {
  return {{0.713f, 0.293f}, {0.165f, 0.83f}, {0.128f, 0.044f}, {0.32168f, 0.33767f}};
}

}  // namespace pvol::formats::color_files
