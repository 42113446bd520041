// Radiance pictures as skies: every code and order, and damage of every kind.
#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <functional>
#include <random>
#include <string>

#include "pvol/error.h"
#include "pvol/formats/image.h"
#include "support/error_of.h"
#include "support/messages.h"
#include "support/temporary_folder.h"

namespace pvol::formats {
namespace hdr_test {

using test::error_of;

constexpr int kWidth = 12, kHeight = 5;
const std::string kHead = "#?RADIANCE\n# by hand\nFORMAT=32-bit_rle_rgbe\n\n";

class HdrTest : public testing::Test {
 protected:
  std::filesystem::path write(const std::string& bytes, const char* name = "a.hdr") {
    write_bytes(folder_.file(name), bytes);
    return folder_.file(name);
  }
  ImageSky read(const std::string& bytes) { return read_sky(write(bytes)); }
  std::string refusal(const std::string& bytes) {
    return error_of([&] { (void)read(bytes); });
  }

 private:
  TemporaryFolder folder_;
};

/// Four bytes of a pixel. Rows have runs, and some pixels are black.
std::string pixel(int x, int y) {
  if (x == 3) return std::string("\0\0\0\0", 4);
  const int r = x < 7 ? 200 : x * 10 + y, e = y == 2 ? 140 : 128;
  return {char(r), char(17 + y), char(x == 9 ? 0 : 130), char(e)};
}
Rgb value(int x, int y) {
  const std::string p = pixel(x, y);
  const auto v = [&](std::size_t i) { return float(std::uint8_t(p[i])); };
  return v(3) == 0 ? Rgb(0.0f) : Rgb(v(0), v(1), v(2)) * std::ldexp(1.0f, int(v(3)) - 136);
}

using Pixels = std::vector<std::string>;  // of a line
using Encode = std::function<std::string(const Pixels&)>;

std::string plain(const Pixels& line) {
  std::string s;
  for (const std::string& p : line) s += p;
  return s;
}
/// Repeats of one pixel, in digits of base 256.
std::string old_runs(const Pixels& line) {
  std::string s;
  for (std::size_t i = 0; i < line.size();) {
    std::size_t n = 1;
    while (i + n < line.size() && line[i + n] == line[i]) ++n;
    s += line[i];
    for (std::size_t rest = n - 1; rest > 0; rest >>= 8) {
      s += std::string("\1\1\1", 3) + char(rest & 255);
    }
    i += n;
  }
  return s;
}
std::string new_runs(const Pixels& line) {
  std::string s{2, 2, char(line.size() >> 8), char(line.size() & 255)};
  for (std::size_t c = 0; c < 4; ++c) {
    for (std::size_t i = 0; i < line.size();) {
      std::size_t n = 1;
      while (n < 127 && i + n < line.size() && line[i + n][c] == line[i][c]) ++n;
      if (n > 2) {
        s += {char(128 + n), line[i][c]};
      } else {
        s += char(n);
        for (std::size_t k = 0; k < n; ++k) s += line[i + k][c];
      }
      i += n;
    }
  }
  return s;
}

/// The picture in one of eight orders.
std::string picture(const std::string& size, const Encode& encode) {
  const bool columns = size[1] == 'X';
  const std::size_t second = size.find(columns ? 'Y' : 'X', 2) - 1;
  const char x_sign = columns ? size[0] : size[second], y_sign = columns ? size[second] : size[0];
  std::string s = kHead + size + "\n";
  for (int k = 0; k < (columns ? kWidth : kHeight); ++k) {
    Pixels line;
    for (int i = 0; i < (columns ? kHeight : kWidth); ++i) {
      const int x = columns ? k : i, y = columns ? i : k;
      line.push_back(
          pixel(x_sign == '-' ? kWidth - 1 - x : x, y_sign == '+' ? kHeight - 1 - y : y));
    }
    s += encode(line);
  }
  return s;
}

void expect_picture(const ImageSky& sky, float factor = 1) {
  ASSERT_EQ(sky.width, kWidth);
  ASSERT_EQ(sky.height, kHeight);
  for (int y = 0; y < kHeight; ++y) {
    for (int x = 0; x < kWidth; ++x) {
      EXPECT_EQ(sky.pixels[std::size_t(y * kWidth + x)], value(x, y) * factor) << x << ' ' << y;
    }
  }
  EXPECT_EQ(sky.scale, Rgb(1.0f));
}

const std::string kUsual = "-Y 5 +X 12";

TEST_F(HdrTest, EveryCodeAndOrderIsRead) {
  for (const char* size : {"-Y 5 +X 12", "+Y 5 +X 12", "-Y 5 -X 12", "+Y 5 -X 12", "+X 12 -Y 5",
                           "-X 12 -Y 5", "+X 12 +Y 5", "-X 12 +Y 5"}) {
    SCOPED_TRACE(size);
    expect_picture(read(picture(size, plain)));
    expect_picture(read(picture(size, old_runs)));
    if (size[1] == 'Y') expect_picture(read(picture(size, new_runs)));
  }
}

TEST_F(HdrTest, IsKnownByItsEndingOrItsFirstBytes) {
  expect_picture(read_sky(write(picture(kUsual, new_runs), "a.HDR")));
  expect_picture(read_sky(write(picture(kUsual, new_runs), "a.pic")));
  EXPECT_NE(error_of([&] { (void)read_sky(write("v/1", "b.hdr")); }).find("#?RADIANCE"),
            std::string::npos);
}

TEST_F(HdrTest, LongRunsOfPixelsAreRead) {
  // 40 000 pixels: longer than channels of runs may be, 39 999 = 63 + 256 * 156.
  const std::string p = pixel(1, 1);
  const std::string line =
      p + std::string("\1\1\1", 3) + char(63) + std::string("\1\1\1", 3) + char(156);
  const ImageSky sky = read(kHead + "-Y 1 +X 40000\n" + line);
  ASSERT_EQ(sky.pixels.size(), 40'000u);
  EXPECT_EQ(sky.pixels.front(), value(1, 1));
  EXPECT_EQ(sky.pixels.back(), value(1, 1));
}

TEST_F(HdrTest, OneCodeHoldsUpTo128ValuesAndARunOf127) {
  // The code 128 counts values of their own; a run of none would be no code.
  std::string line{2, 2, 0, char(255)};
  for (std::size_t c = 0; c < 4; ++c) {
    line += char(128);
    for (int x = 0; x < 128; ++x) line += c == 3 ? char(136) : char(x);
    line += {char(128 + 127), c == 3 ? char(136) : char(200)};
  }
  const ImageSky sky = read(kHead + "-Y 1 +X 255\n" + line);
  ASSERT_EQ(sky.pixels.size(), 255u);
  for (int x = 0; x < 255; ++x) {
    EXPECT_EQ(sky.pixels[std::size_t(x)], Rgb(x < 128 ? float(x) : 200.0f)) << x;
  }
}

TEST_F(HdrTest, ExposureAndCorrectionAreUndone) {
  const std::string body = picture(kUsual, new_runs).substr(kHead.size());
  expect_picture(read("#?RGBE\r\nEXPOSURE=0.5\nEXPOSURE=  4 \nFORMAT=32-bit_rle_rgbe\n\n" + body),
                 0.5f);
  const ImageSky sky = read("#?RADIANCE\nCOLORCORR= 2 1 0.5\n\n" + body);
  EXPECT_EQ(sky.pixels[0], value(0, 0) * Rgb(0.5f, 1, 2));
  expect_picture(read("#?RADIANCE\nPRIMARIES=0.64 0.33 0.29 0.6 0.15 0.06 0.333 0.333\n\n" + body));
}

TEST_F(HdrTest, OtherPrimariesAreConverted) {
  const std::string body = picture(kUsual, new_runs).substr(kHead.size());
  const ImageSky sky =
      read("#?RADIANCE\nPRIMARIES=0.713 0.293 0.165 0.83 0.128 0.044 0.32168 0.33767\n\n" + body);
  const Rgb from = value(7, 0);  // within Rec.709
  const double red = 1.705051 * double(from.x) - 0.621792 * double(from.y) -
                     0.083259 * double(from.z);  // ACEScg to Rec.709, as published
  EXPECT_NEAR(double(sky.pixels[7].x), red, 1e-5 * red);
}

TEST_F(HdrTest, WhatIsNotOneIsRefusedWithItsPlace) {
  const std::string body = picture(kUsual, new_runs).substr(kHead.size());
  const auto refuses = [&](const std::string& bytes, const std::string& key) {
    const std::string message = refusal(bytes);
    EXPECT_TRUE(says(message, key));
    EXPECT_NE(message.find("a.hdr"), std::string::npos) << message;
  };
  refuses("", "hdr.not_radiance_picture");
  refuses("P6 12 5", "hdr.not_radiance_picture");
  refuses("#?RADIANCE\nFORMAT=32-bit_rle_xyze\n\n" + body, "hdr.format_bit_rle_xyze");
  refuses("#?RADIANCE\nEXPOSURE=0\n\n" + body, "hdr.byte_exposure");
  refuses("#?RADIANCE\nEXPOSURE=nan\n\n" + body, "hdr.byte_exposure_nan");
  refuses("#?RADIANCE\nCOLORCORR=1 2\n\n" + body, "hdr.byte_colorcorr");
  refuses("#?RADIANCE\nPRIMARIES=0.7 0.3 0.2\n\n" + body, "hdr.primaries_eight_numbers");
  refuses(kHead + "-Y 5 +Z 12\n", "hdr.byte_header_ends");
  refuses(kHead + "-Y 5 +Y 12\n", "hdr.byte_header_ends");
  refuses(kHead + "-Y 5 +X\n", "hdr.byte_header_ends");
  refuses(kHead + "-Y 0 +X 12\n", "hdr.picture_x_pixels");
  refuses(kHead + "-Y 5 +X -12\n", "hdr.picture_minus_x");
  refuses(kHead + "-Y 5x +X 12\n", "hdr.picture_x_5x");
  refuses(kHead + "-Y 65537 +X 1\n", "hdr.too_many_rows");
  refuses(kHead + "-Y 65536 +X 65536\n", "hdr.picture_65536_x");
  refuses(kHead + "-Y 99999999999999999999 +X 1\n", "hdr.rows_overflow");
  refuses(kHead + "-Y 60000 +X 4000\n" + body, "hdr.byte_bytes_left");
  refuses("#?RADIANCE\n" + std::string(5000, 'x') + "\n", "hdr.byte_header_too_long");
  std::string endless = "#?RADIANCE\n";
  for (int i = 0; i < 300'000; ++i) endless += "A=1\n";
  refuses(endless, "hdr.byte_header_too_long");
  // Lines of pixels.
  const std::string one_line = kHead + "-Y 1 +X 12\n";
  refuses(one_line + std::string("\2\2\0\x0b", 4) + std::string(60, '\1'), "hdr.line_pixels");
  refuses(one_line + std::string("\2\2\0\x0c\0", 5) + std::string(60, '\1'), "hdr.run_values");
  refuses(one_line + std::string("\2\2\0\x0c\x8d\7", 6) + std::string(60, '\1'),
          "hdr.run_13_values");
  refuses(one_line + std::string("\1\1\1\1", 4) + std::string(60, '\5'), "hdr.byte_repeated_pixel");
  refuses(one_line + pixel(0, 0) + std::string("\1\1\1\x0c", 4) + std::string(60, '\5'),
          "hdr.byte_repeated_pixel");
  EXPECT_NE(refusal(one_line + pixel(0, 0) + pixel(0, 0) + std::string("\1\1\1\x0c", 4) +
                    std::string(60, '\5'))
                .find("exceeds the 10 that are left of the line, or follows none (2 so far)"),
            std::string::npos);
  const std::string zero("\1\1\1\0", 4);
  refuses(one_line + pixel(0, 0) + zero + zero + zero + zero + zero + std::string(60, '\5'),
          "hdr.byte_repeated_pixel");
  refuses("#?RADIANCE\nEXPOSURE=1e-10\n\n-Y 1 +X 1\n\xff\xff\xff\xff", "hdr.pixel_line_brighter");
}

TEST_F(HdrTest, EveryTruncationIsRefused) {
  for (const Encode& encode : {Encode(plain), Encode(old_runs), Encode(new_runs)}) {
    const std::string whole = picture(kUsual, encode);
    for (std::size_t size = 0; size < whole.size(); ++size) {
      EXPECT_NE(refusal(whole.substr(0, size)), "") << size << " of " << whole.size();
    }
  }
}

TEST_F(HdrTest, FlippedBitsAreReadOrRefused) {
  std::mt19937 bits(3);
  for (const Encode& encode : {Encode(plain), Encode(old_runs), Encode(new_runs)}) {
    const std::string whole = picture(kUsual, encode);
    int refused = 0;
    for (int i = 0; i < 1500; ++i) {
      std::string bytes = whole;
      for (auto n = 1 + bits() % 3; n > 0; --n) {
        bytes[bits() % bytes.size()] ^= char(1u << (bits() % 8));
      }
      try {
        const ImageSky sky = read_sky(write(bytes, "flipped.hdr"));
        EXPECT_EQ(sky.pixels.size(), std::size_t(sky.width) * std::size_t(sky.height));
        for (const Rgb& c : sky.pixels) EXPECT_TRUE(is_finite(c) && min_component(c) >= 0);
      } catch (const Error&) {
        ++refused;
      }
    }
    EXPECT_GT(refused, 100);
  }
}

}  // namespace hdr_test
}  // namespace pvol::formats
