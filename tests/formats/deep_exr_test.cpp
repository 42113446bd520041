// Deep EXR files as other programs find them: OpenEXR's own reader for every sample, and oiiotool
// (Debian: openimageio-tools), where it is installed, for pictures flattened and merged in depth.
#include <ImfChannelList.h>
#include <ImfDeepFrameBuffer.h>
#include <ImfDeepScanLineInputFile.h>
#include <ImfHeader.h>
#include <ImfPartType.h>
#include <ImfStandardAttributes.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <iterator>
#include <limits>

#include "pvol/error.h"
#include "pvol/formats/image.h"
#include "pvol/math/rng.h"
#include "support/effort.h"
#include "support/error_of.h"
#include "support/messages.h"
#include "support/temporary_folder.h"

namespace pvol::formats {
namespace deep_exr_test {

using test::error_of;

constexpr double kError = 0.01;

/// 40 x 36 pixels of a larger image, between these depths. Some see nothing, some nothing behind.
Film make_film(double front, double back, std::uint64_t seed) {
  Film f{
      .width = 64, .height = 48, .x = 5, .y = 3, .crop_width = 40, .crop_height = 36, .pixels = {}};
  f.deep = {front, back, 20, std::vector<std::vector<DeepBin>>(40 * 36)};
  for (std::size_t i = 0; i < f.deep.pixels.size(); ++i) {
    Rng rng(seed, i, 0);
    PixelSums p;
    p.samples = 100;
    const double collide = std::clamp(1.4 * double(rng.uniform()) - 0.2, 0.0, 1.0);
    for (std::uint32_t k = 0; k < p.samples; ++k) {
      if (!(double(rng.uniform()) < collide)) continue;
      const Vec3d light(double(rng.uniform()), 0.5 * double(rng.uniform()), 3);
      f.deep.add(i, front + (back - front) * double(rng.uniform()), light);
      p.sum += light, p.alpha += 1;
    }
    f.pixels.push_back(p);
  }
  return f;
}

constexpr std::array kNames = {"R", "G", "B", "A", "Z", "ZBack"};
using Sample = std::array<float, kNames.size()>;

struct Picture {
  std::vector<std::vector<Sample>> pixels;

  /// By OpenEXR alone.
  explicit Picture(const std::string& file) {
    Imf::DeepScanLineInputFile in(file.c_str());
    const Imath::Box2i box = in.header().dataWindow();
    const std::int64_t width = box.max.x - box.min.x + 1, height = box.max.y - box.min.y + 1;
    std::vector<std::uint32_t> counts(std::size_t(width * height));
    std::array<std::vector<float*>, kNames.size()> places;
    const auto origin = [&](auto& first) {
      return reinterpret_cast<char*>(&first) -
             (box.min.x + width * box.min.y) * std::int64_t(sizeof first);
    };
    Imf::DeepFrameBuffer buffer;
    buffer.insertSampleCountSlice(
        Imf::Slice(Imf::UINT, origin(counts[0]), 4, 4 * std::size_t(width)));
    for (std::size_t c = 0; c < kNames.size(); ++c) {
      places[c].resize(counts.size());
      buffer.insert(kNames[c], Imf::DeepSlice(Imf::FLOAT, origin(places[c][0]), sizeof(float*),
                                              sizeof(float*) * std::size_t(width), sizeof(Sample)));
    }
    in.setFrameBuffer(buffer);
    in.readPixelSampleCounts(box.min.y, box.max.y);
    for (std::size_t i = 0; i < counts.size(); ++i) {
      pixels.emplace_back(counts[i]);
      for (std::size_t c = 0; c < kNames.size() && counts[i] > 0; ++c) {
        places[c][i] = &pixels[i][0][c];
      }
    }
    in.readPixels(box.min.y, box.max.y);
  }
};

TEST(DeepExr, HasTheSamplesOfTheFilmInTheOrderOfDepth) {
  const TemporaryFolder folder;
  const std::string file = folder.file("a.exr").string();
  const Film film = make_film(3, 7, 1);
  const Camera camera{.position = {1, 2, 3}, .target = {4, 4, 4}};
  for (const ExrCompression compression : {ExrCompression::zips, ExrCompression::none}) {
    const DeepExrWritten done =
        write_deep_exr(file, film, {{"pvol:seed", "1"}},
                       {.error = kError, .compression = compression, .camera = camera});
    EXPECT_EQ(done.clamped, 0u);
    const Picture picture(file);
    ASSERT_EQ(picture.pixels.size(), film.pixels.size());
    std::size_t count = 0, empty = 0, opaque = 0;
    for (std::size_t i = 0; i < picture.pixels.size(); ++i) {
      const std::vector<DeepSample> expected = deep_samples(film.deep, i, 100, kError);
      ASSERT_EQ(picture.pixels[i].size(), expected.size());
      float end = 0;
      for (std::size_t k = 0; k < expected.size(); ++k) {
        const DeepSample& e = expected[k];
        const Sample& s = picture.pixels[i][k];
        const Sample wanted{float(e.colour.x), float(e.colour.y), float(e.colour.z),
                            float(e.alpha),    float(e.z),        float(e.z_back)};
        ASSERT_EQ(s, wanted);
        ASSERT_TRUE(s[4] >= end && s[5] >= s[4] && s[3] > 0 && s[3] <= 1) << "not tidy";
        end = s[5];
        opaque += s[3] == 1 ? 1 : 0;
      }
      count += expected.size();
      empty += expected.empty() ? 1 : 0;
    }
    EXPECT_EQ(count, done.samples);
    EXPECT_GT(empty, 0u);
    EXPECT_GT(opaque, 0u);
  }
}

TEST(DeepExr, HeaderSaysWhatTheFlatOneDoesAndThatPixelsAreTidy) {
  const TemporaryFolder folder;
  const Film film = make_film(3, 7, 1);
  const Camera camera{.position = {1, 2, 3}, .target = {4, 4, 4}};
  write_deep_exr(folder.file("a.exr"), film, {{"pvol:seed", "1"}}, {.camera = camera});
  write_exr(folder.file("b.exr"), film, {{"pvol:seed", "1"}}, {.camera = camera});
  const Imf::DeepScanLineInputFile deep(folder.file("a.exr").c_str());
  const Imf::Header& header = deep.header();
  EXPECT_EQ(header.type(), Imf::DEEPSCANLINE);
  EXPECT_EQ(header.compression(), Imf::ZIPS_COMPRESSION);
  EXPECT_EQ(Imf::deepImageState(header), Imf::DIS_TIDY);
  EXPECT_EQ(header.dataWindow(), Imath::Box2i({5, 3}, {44, 38}));
  EXPECT_EQ(header.displayWindow(), Imath::Box2i({0, 0}, {63, 47}));
  EXPECT_TRUE(Imf::hasChromaticities(header) && Imf::hasWorldToCamera(header) &&
              Imf::hasWorldToNDC(header) && header.find("pvol:seed") != header.end());
}

TEST(DeepExr, HalfIsForColourAlone) {
  const TemporaryFolder folder;
  const std::string file = folder.file("a.exr").string();
  Film film = make_film(3, 7, 1);
  film.deep.pixels[77].clear();
  film.deep.add(77, 4, Vec3d(1e6, 1, -1e6) * 100);
  const DeepExrWritten done = write_deep_exr(file, film, {}, {.pixels = PixelType::half});
  EXPECT_EQ(done.clamped, 2u);
  const Imf::DeepScanLineInputFile in(file.c_str());
  const Imf::ChannelList& channels = in.header().channels();
  for (const char* name : kNames) {
    const bool colour = std::string("RGB").find(name) != std::string::npos;
    EXPECT_EQ(channels[name].type, colour ? Imf::HALF : Imf::FLOAT) << name;
  }
  const Picture picture(file);
  ASSERT_EQ(picture.pixels[77].size(), 1u);
  EXPECT_EQ(picture.pixels[77][0], (Sample{65504, 1, -65504, 0.01f, 4, float(3 + 0.2 * 6)}));
}

std::string bytes_of(const std::filesystem::path& file) {
  std::ifstream in(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

TEST(DeepExr, TheSameFilmGivesTheSameBytes) {
  const TemporaryFolder folder;
  write_deep_exr(folder.file("a.exr"), make_film(3, 7, 1), {}, {});
  write_deep_exr(folder.file("b.exr"), make_film(3, 7, 1), {}, {});
  EXPECT_FALSE(bytes_of(folder.file("a.exr")).empty());
  EXPECT_EQ(bytes_of(folder.file("a.exr")), bytes_of(folder.file("b.exr")));
}

TEST(DeepExr, RefusesAFilmWithoutDepthsAndNamesOfExrsOwn) {
  const TemporaryFolder folder;
  const std::filesystem::path file = folder.file("a.exr");
  Film film = make_film(3, 7, 1);
  EXPECT_TRUE(says(error_of([&] {
                     write_deep_exr(file, film, {{"channels", "x"}}, {});
                   }),
                   "deep.attribute_channels_reserved"));
  film.deep = {};
  EXPECT_TRUE(says(error_of([&] { write_deep_exr(file, film, {}, {}); }), "deep.film_no_depths"));
  film = {};
  EXPECT_TRUE(
      says(error_of([&] { write_deep_exr(file, film, {}, {}); }), "deep.picture_no_pixels"));
  EXPECT_FALSE(exists(file));
}

TEST(DeepExr, ReadersOfFlatPicturesSayWhatToDo) {
  const TemporaryFolder folder;
  write_deep_exr(folder.file("a.exr"), make_film(3, 7, 1), {}, {});
  for (const std::string& message : {error_of([&] { (void)read_film(folder.file("a.exr")); }),
                                     error_of([&] { (void)read_sky(folder.file("a.exr")); })}) {
    EXPECT_TRUE(says(message, "deep.deep_pixels_several"));
    EXPECT_TRUE(says(message, "deep.deep_pixels_several"));
  }
}

TEST(FlattenExr, GivesThePictureBack) {
  const TemporaryFolder folder;
  const Film film = make_film(3, 7, 1);
  for (const double error : {0.0, kError, 1.0}) {
    for (const ExrCompression compression : {ExrCompression::zips, ExrCompression::none}) {
      for (const PixelType type : {PixelType::single, PixelType::half}) {
        write_deep_exr(folder.file("a.exr"), film, {{"pvol:seed", "1"}},
                       {.error = error, .pixels = type, .compression = compression});
        const StoredFilm stored = flatten_exr(folder.file("a.exr"));
        EXPECT_FALSE(stored.has_variances);
        EXPECT_EQ(stored.attributes.at("pvol:seed"), "1");
        const Film& flat = stored.film;
        EXPECT_TRUE(flat.width == 64 && flat.height == 48 && flat.x == 5 && flat.y == 3);
        ASSERT_EQ(flat.pixels.size(), film.pixels.size());
        for (std::size_t i = 0; i < flat.pixels.size(); ++i) {
          const PixelSums &a = film.pixels[i], &b = flat.pixels[i];
          ASSERT_LE(length(mean(a) - mean(b)), type == PixelType::half ? 2e-3 : 1e-5);
          ASSERT_NEAR(a.alpha / a.samples, b.alpha, 1e-6);
        }
      }
    }
  }
}

/// A pixel of another program's file, with these samples; `names` of kNames, all of float.
std::string flatten_error(std::vector<Sample> samples, std::size_t names = kNames.size(),
                          Imf::Compression compression = Imf::ZIPS_COMPRESSION) {
  const TemporaryFolder folder;
  const std::string file = folder.file("a.exr").string();
  {
    Imf::Header header(1, 1);
    header.setType(Imf::DEEPSCANLINE);
    header.compression() = compression;
    auto count = std::uint32_t(samples.size());
    std::array<float*, kNames.size()> places{};
    Imf::DeepFrameBuffer buffer;
    buffer.insertSampleCountSlice(Imf::Slice(Imf::UINT, reinterpret_cast<char*>(&count), 4, 4));
    for (std::size_t c = 0; c < names; ++c) {
      header.channels().insert(kNames[c], Imf::Channel(Imf::FLOAT));
      places[c] = &samples[0][c];
      buffer.insert(kNames[c], Imf::DeepSlice(Imf::FLOAT, reinterpret_cast<char*>(&places[c]),
                                              sizeof(float*), sizeof(float*), sizeof(Sample)));
    }
    Imf::DeepScanLineOutputFile out(file.c_str(), header);
    out.setFrameBuffer(buffer);
    out.writePixels(1);
  }
  return error_of([&] { (void)flatten_exr(file); });
}

TEST(FlattenExr, TakesWhatIsInOrderAlone) {
  const Sample a{1, 1, 1, 0.5f, 2, 3}, b{1, 1, 1, 1, 3, 4};
  EXPECT_EQ(flatten_error({a, b}), "");
  EXPECT_EQ(flatten_error({a, b}, 5), "") << "without ZBack samples are thin";
  const std::string overlap = "pixel (0, 0) has samples that overlap or are not in order of depth";
  EXPECT_NE(flatten_error({b, a}).find(overlap), std::string::npos);
  EXPECT_NE(flatten_error({a, a}).find(overlap), std::string::npos);
  EXPECT_NE(flatten_error({{1, 1, 1, 0.5f, 3, 2}}).find(overlap), std::string::npos);
  const float inf = std::numeric_limits<float>::infinity();
  for (const Sample& odd : {Sample{1, inf, 1, 0.5f, 2, 3}, Sample{1, 1, 1, 1.5f, 2, 3},
                            Sample{1, 1, 1, -0.5f, 2, 3}, Sample{1, 1, 1, 0.5f, 2, inf}}) {
    EXPECT_TRUE(says(flatten_error({odd}), "deep.pixel_sample_not_finite"));
  }
  EXPECT_TRUE(says(flatten_error({a}, 4), "deep.no_channel_z"));
  EXPECT_TRUE(says(flatten_error({a}, 2), "deep.no_channel_b"));
  EXPECT_TRUE(says(flatten_error({a}, 6, Imf::RLE_COMPRESSION), "deep.unsupported_compression"));
  const TemporaryFolder folder;
  write_exr(folder.file("a.exr"), make_film(3, 7, 1), {});
  EXPECT_TRUE(
      says(error_of([&] { (void)flatten_exr(folder.file("a.exr")); }), "deep.flat_picture"));
}

/// The first row's block, of what has 36: right behind the table of blocks, whose first entry says
/// where it is.
std::size_t first_block(const std::string& bytes) {
  for (std::size_t at = 0; at + 8 <= bytes.size(); ++at) {
    std::uint64_t entry = 0;
    std::memcpy(&entry, &bytes[at], sizeof entry);
    if (entry == at + 8 * 36) return entry;
  }
  return 0;
}

TEST(FlattenExr, CountsOfSamplesMustMakeSense) {
  const TemporaryFolder folder;
  const std::filesystem::path file = folder.file("a.exr");
  write_deep_exr(file, make_film(3, 7, 1), {}, {.compression = ExrCompression::none});
  std::string bytes = bytes_of(file);
  const std::size_t block = first_block(bytes);
  ASSERT_GT(block, 0u);
  // Up to the first pixel there are more samples than up to the second; behind the row's number and
  // three sizes.
  const std::uint32_t many = 0x7fffffff;
  std::memcpy(&bytes[block + 28], &many, sizeof many);
  std::ofstream(file, std::ios::binary) << bytes;
  const std::string error = error_of([&] { (void)flatten_exr(file); });
  EXPECT_TRUE(says(error, "deep.byte_counts_samples"));
}

TEST(FlattenExr, DamagedFilesAreRefusedAndNamed) {
  const TemporaryFolder folder;
  const std::filesystem::path file = folder.file("a.exr"), damaged = folder.file("b.exr");
  for (const ExrCompression compression : {ExrCompression::zips, ExrCompression::none}) {
    write_deep_exr(file, make_film(3, 7, 1), {}, {.error = 0.3, .compression = compression});
    const std::string whole = bytes_of(file);
    const auto read = [&](const std::string& bytes) {
      std::ofstream(damaged, std::ios::binary) << bytes;
      return error_of([&] { (void)flatten_exr(damaged); });
    };
    EXPECT_EQ(read(whole), "");
    for (std::size_t size = 0; size < whole.size(); size += 1 + whole.size() / 150) {
      EXPECT_NE(read(whole.substr(0, size)).find("b.exr: "), std::string::npos) << size;
    }
    Rng rng(5, 0, 0);
    std::size_t refused = 0;
    for (int k = 0; k < proof::samples(400, 2); ++k) {
      std::string bytes = whole;
      // Most of what can go wrong is told in the first bytes, and in those of each row.
      const double place = double(rng.uniform()), range = k % 2 ? 2000 : double(bytes.size());
      bytes[std::size_t(place * std::min(range, double(bytes.size())))] =
          static_cast<char>(256 * rng.uniform());
      const std::string error = read(bytes);
      refused += error.empty() ? 0 : 1;
      EXPECT_TRUE(error.empty() || error.find("b.exr: ") == 0u ||
                  error.find("/b.exr: ") != error.npos)
          << error;
    }
    EXPECT_GT(refused, proof::samples(30u, 2u));
  }
}

class DeepInOpenImageIo : public testing::Test {
 protected:
  void SetUp() override {
    if (std::system("oiiotool --version >/dev/null 2>&1") != 0) {
      GTEST_SKIP() << "needs oiiotool; install openimageio-tools";
    }
  }
  /// R, G, B and A of what oiiotool makes of files.
  Film flattened(const std::string& files_and_verbs) {
    const std::string out = folder_.file("flat.exr").string();
    const std::string command =
        "oiiotool " + files_and_verbs + " --flatten --ch R,G,B,A -d float -o " + out;
    EXPECT_EQ(std::system(command.c_str()), 0) << command;
    return read_film(out).film;
  }
  [[nodiscard]] std::string file(const char* name) const { return folder_.file(name).string(); }
  TemporaryFolder folder_;
};

TEST_F(DeepInOpenImageIo, FlattenedItIsThePicture) {
  const Film film = make_film(3, 7, 1);
  for (const double error : {0.0, kError, 1.0}) {
    write_deep_exr(file("a.exr"), film, {}, {.error = error});
    const Film flat = flattened(file("a.exr"));
    ASSERT_EQ(flat.pixels.size(), film.pixels.size());
    for (std::size_t i = 0; i < flat.pixels.size(); ++i) {
      const PixelSums &a = film.pixels[i], &b = flat.pixels[i];
      ASSERT_LE(length(mean(a) - mean(b)), 1e-5);
      ASSERT_NEAR(a.alpha / a.samples, b.alpha / b.samples, 1e-6);
    }
  }
}

/// One in front of the other, and one through the other, where both are split at all ends.
TEST_F(DeepInOpenImageIo, MergedTheyAreOneSceneInDepth) {
  for (const double apart : {4.0, 2.0}) {
    const Film a = make_film(3, 7, 1), b = make_film(3 + apart, 7 + apart, 2);
    write_deep_exr(file("a.exr"), a, {}, {});
    write_deep_exr(file("b.exr"), b, {}, {});
    const Film flat = flattened(file("b.exr") + " " + file("a.exr") + " --deepmerge");
    for (std::size_t i = 0; i < flat.pixels.size(); ++i) {
      const auto before = deep_samples(a.deep, i, 100, 0), behind = deep_samples(b.deep, i, 100, 0);
      // Each bin of one through what the other has before it; both have edges at the same depths.
      Vec3d colour;
      double open = 1;
      for (std::uint32_t k = 0; k < 40; ++k) {
        const double z = 3 + 0.2 * k, end = z + 0.2;
        const auto part = [&](const std::vector<DeepSample>& s) {
          const DeepValue from = seen_before(s, z + 1e-9), to = seen_before(s, end + 1e-9);
          const double through = 1 - from.alpha;
          return DeepValue{through > 0 ? (to.colour - from.colour) / through : Vec3d{},
                           through > 0 ? (to.alpha - from.alpha) / through : 0};
        };
        const DeepValue p = part(before), q = part(behind);
        // Two even media that share their place take turns (OpenEXR's theory of deep samples).
        const double u = -std::log1p(-p.alpha), v = -std::log1p(-q.alpha);
        const auto share = [&](double own, double alpha) {
          if (own == 0) return 0.0;
          return std::isinf(own) ? 1.0 : own / (u + v) * -std::expm1(-(u + v)) / alpha;
        };
        const bool thin = std::isinf(u) || std::isinf(v);
        if (thin && u > 0 && v > 0) {
          open = -1;  // which comes first hangs on the middle of the bin: not compared
          break;
        }
        colour += (p.colour * share(u, p.alpha) + q.colour * share(v, q.alpha)) * open;
        open *= (1 - p.alpha) * (1 - q.alpha);
      }
      if (open < 0) continue;
      const PixelSums& found = flat.pixels[i];
      ASSERT_LE(length(mean(found) - colour), 1e-4) << apart << ", pixel " << i;
      ASSERT_NEAR(found.alpha / found.samples, 1 - open, 1e-5);
    }
  }
}

}  // namespace deep_exr_test
}  // namespace pvol::formats
