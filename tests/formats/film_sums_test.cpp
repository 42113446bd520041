// Films with their exact sums, written and read again to the bit; and damaged ones.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <functional>
#include <iterator>
#include <limits>
#include <random>

#include "image/sum_planes.h"
#include "pvol/error.h"
#include "pvol/formats/film_file.h"
#include "pvol/formats/image.h"
#include "support/effort.h"
#include "support/messages.h"
#include "support/temporary_folder.h"

namespace pvol::formats {
namespace film_sums_test {

/// A crop with everything that a film can have, in numbers of all sizes.
Film some_film(bool adaptive) {
  std::mt19937 random(5);
  std::uniform_real_distribution<double> unit(-1, 1);
  const auto number = [&] { return std::ldexp(unit(random), int(60 * unit(random))); };
  const auto vector = [&] { return Vec3d{number(), number(), number()}; };
  Film f;
  f.width = 50, f.height = 60, f.x = 3, f.y = 11;
  f.crop_width = 19, f.crop_height = 37;
  f.first_sample = 1000;
  f.pixels.resize(std::size_t(f.crop_width * f.crop_height));
  f.layers = {
      {"sun_1", std::vector<Vec3d>(f.pixels.size())},
      {"half_1", std::vector<Vec3d>(f.pixels.size()), "RGB", std::vector<double>(f.pixels.size())},
      {"depth", std::vector<Vec3d>(f.pixels.size()), "Z", std::vector<double>(f.pixels.size())},
      {"nearest", std::vector<Vec3d>(f.pixels.size(), Vec3d(kNothingMet)), "Z", {}, true}};
  keep_exact_sums(f);
  f.counts.resize(f.pixels.size());
  ExactSums sums;
  for (std::size_t i = 0; i < f.pixels.size(); ++i) {
    PixelSums& p = f.pixels[i];
    p.samples = std::uint32_t(i % 40), p.group_samples = p.samples / 3;
    load_sums(f, i, sums);
    for (std::uint32_t s = 0; s < p.samples; ++s) {
      add(sums.light, vector());
      add(sums.squares, vector());
      add(sums.alpha, number()), add(sums.group, number());
      add(sums.layers[0].sum, vector());
      add(sums.layers[1].sum, vector());
      add(sums.layers[1].weight, 1);
      const double depth = number();
      add(sums.layers[2].sum, Vec3d(depth));
      add(sums.layers[2].weight, 0.5);
      f.layers[3].sums[i] = min(f.layers[3].sums[i], Vec3d(std::abs(depth)));
    }
    for (std::size_t c = 0; c < kPixelCounts.size(); ++c) {
      f.counts[i][c] = (std::uint64_t(random()) << (i % 32)) * (c != 2);
    }
    store_sums(sums, i, f);
  }
  if (adaptive) {
    f.needs = AdaptiveSamples{{}, {12.25, 1.0 / 3}};
    for (std::size_t i = 0; i < f.pixels.size(); ++i) {
      f.needs->share.push_back(float(std::abs(number())));
    }
  }
  return f;
}

FilmRecord some_record() {
  return {"0123abc",
          {{.seed = ~0ull,
            .x = 3,
            .y = 11,
            .width = 19,
            .height = 37,
            .begin = 1000,
            .end = 1040,
            .complete = true},
           {.seed = 2, .x = 3, .y = 11, .width = 1, .height = 1}}};
}

/// The first components of layers of one number are those that count.
void expect_same(const Film& a, const Film& b) {
  EXPECT_EQ(a.width, b.width);
  EXPECT_EQ(a.height, b.height);
  EXPECT_EQ(a.x, b.x);
  EXPECT_EQ(a.y, b.y);
  EXPECT_EQ(a.crop_width, b.crop_width);
  EXPECT_EQ(a.crop_height, b.crop_height);
  EXPECT_EQ(a.first_sample, b.first_sample);
  ASSERT_EQ(a.pixels.size(), b.pixels.size());
  EXPECT_EQ(a.remainders.pixels, b.remainders.pixels);
  EXPECT_EQ(a.counts, b.counts);
  for (std::size_t i = 0; i < a.pixels.size(); ++i) {
    EXPECT_EQ(a.pixels[i].sum, b.pixels[i].sum);
    EXPECT_EQ(a.pixels[i].sum_squares, b.pixels[i].sum_squares);
    EXPECT_EQ(a.pixels[i].alpha, b.pixels[i].alpha);
    EXPECT_EQ(a.pixels[i].group, b.pixels[i].group);
    EXPECT_EQ(a.pixels[i].samples, b.pixels[i].samples);
    EXPECT_EQ(a.pixels[i].group_samples, b.pixels[i].group_samples);
  }
  ASSERT_EQ(a.layers.size(), b.layers.size());
  ASSERT_EQ(a.remainders.layers.size(), b.remainders.layers.size());
  for (std::size_t k = 0; k < a.layers.size(); ++k) {
    EXPECT_EQ(a.layers[k].name, b.layers[k].name);
    EXPECT_EQ(a.layers[k].components, b.layers[k].components);
    EXPECT_EQ(a.layers[k].least, b.layers[k].least);
    EXPECT_EQ(a.layers[k].weights, b.layers[k].weights);
    const bool exact = k < a.remainders.layers.size();  // else read without its sums
    if (exact) {
      EXPECT_EQ(a.remainders.layers[k].weights, b.remainders.layers[k].weights);
    }
    const bool one = a.layers[k].components.size() == 1;
    for (std::size_t i = 0; i < a.pixels.size(); ++i) {
      EXPECT_EQ(a.layers[k].sums[i].x, b.layers[k].sums[i].x);
      if (exact && !one) {
        EXPECT_EQ(a.remainders.layers[k].sums[i], b.remainders.layers[k].sums[i]);
      }
    }
  }
  ASSERT_EQ(a.needs.has_value(), b.needs.has_value());
  if (a.needs) {
    EXPECT_EQ(a.needs->share, b.needs->share);
    EXPECT_EQ(a.needs->samples, b.needs->samples);
  }
}

void write(const std::filesystem::path& file, const Film& film, bool multipart = false) {
  write_exr(file, film, {{"pvol:seed", "17"}},
            {.multipart = multipart, .sums = KeptSums{&film, some_record()}});
}

TEST(FilmSums, AreReadToTheBit) {
  const TemporaryFolder folder;
  for (const bool adaptive : {false, true}) {
    for (const bool multipart : {false, true}) {
      const Film film = some_film(adaptive);
      write(folder.file("a.exr"), film, multipart);
      const FilmFile back = read_film_file(folder.file("a.exr"));
      expect_same(film, back.film);
      EXPECT_EQ(back.record, some_record());
      EXPECT_EQ(back.attributes.at("pvol:seed"), "17");
      const PictureHeader h = read_picture_header(folder.file("a.exr"));
      EXPECT_TRUE(h.has_sums);
      EXPECT_EQ(h.multipart, multipart);
      EXPECT_EQ(h.window.crop_height, 37);
    }
  }
}

/// Threads share the blocks of a call, and there are more for more of them.
TEST(FilmSums, BytesDoNotDependOnThreads) {
  const TemporaryFolder folder;
  const Film film = some_film(true);
  for (const ExrCompression compression :
       {ExrCompression::none, ExrCompression::zips, ExrCompression::zip, ExrCompression::piz,
        ExrCompression::dwaa}) {
    for (const bool multipart : {false, true}) {
      std::string by_one;
      Film picture;
      for (const int threads : {1, 2, 16}) {
        use_exr_threads(threads);
        write_exr(folder.file("a.exr"), film, {},
                  {.multipart = multipart,
                   .compression = compression,
                   .sums = KeptSums{&film, some_record()}});
        const std::string bytes = read_bytes(folder.file("a.exr"));
        if (threads == 1) by_one = bytes;
        EXPECT_TRUE(bytes == by_one) << threads << " threads, " << int(compression);
        expect_same(film, read_film_file(folder.file("a.exr")).film);
        if (compression == ExrCompression::dwaa) continue;  // whose halves do not hold this picture
        const Film read = read_film(folder.file("a.exr")).film;
        if (threads == 1) picture = read;
        expect_same(picture, read);
      }
    }
  }
  use_exr_threads(1);
}

TEST(FilmSums, NamesOfAttributesMayBeLong) {
  const TemporaryFolder folder;
  const std::string longest(255, 'n');  // that OpenEXR takes
  write_exr(folder.file("a.exr"), some_film(false), {{longest, "1"}});
  EXPECT_EQ(read_picture_header(folder.file("a.exr")).window.crop_height, 37);
}

TEST(FilmSums, LeaveThePictureAsItIs) {
  const TemporaryFolder folder;
  const Film film = some_film(false);
  for (const bool multipart : {false, true}) {
    write(folder.file("sums.exr"), film, multipart);
    write_exr(folder.file("plain.exr"), film, {}, {.multipart = multipart});
    EXPECT_FALSE(read_picture_header(folder.file("plain.exr")).has_sums);
    EXPECT_THROW((void)read_film_file(folder.file("plain.exr")), Error);
    const StoredFilm a = read_film(folder.file("sums.exr")),
                     b = read_film(folder.file("plain.exr"));
    ASSERT_EQ(a.film.layers.size(), b.film.layers.size()) << "planes are no layers";
    for (std::size_t i = 0; i < a.film.pixels.size(); ++i) {
      EXPECT_EQ(a.film.pixels[i].sum, b.film.pixels[i].sum);
    }
  }
}

TEST(FilmSums, AreThoseOfAnotherFilmThanThePicture) {
  const TemporaryFolder folder;
  const Film film = some_film(false);
  Film filtered = crop_of(film, film.x, film.y, film.crop_width, film.crop_height);
  for (PixelSums& p : filtered.pixels) p.sum = Vec3d(7.0 * p.samples);
  write_exr(folder.file("a.exr"), filtered, {}, {.sums = KeptSums{&film, some_record()}});
  expect_same(film, read_film_file(folder.file("a.exr")).film);
  EXPECT_EQ(mean(read_film(folder.file("a.exr")).film.pixels[1]), Vec3d(7.0));
}

TEST(FilmSums, AreReadRowByRow) {
  const TemporaryFolder folder;
  const Film film = some_film(true);
  write(folder.file("a.exr"), film);
  for (const int step : {1, 5, 16, 36}) {
    FilmReader reader(folder.file("a.exr"));
    for (int y = 0; y < film.crop_height; y += step) {
      const int rows = std::min(step, film.crop_height - y);
      const Film some = reader.rows(y, rows);
      const Film expected = crop_of(film, film.x, film.y + y, film.crop_width, rows);
      EXPECT_EQ(some.remainders.pixels, expected.remainders.pixels);
      EXPECT_EQ(some.y, film.y + y);
      EXPECT_EQ(some.needs->share.size(), some.pixels.size());
    }
  }
}

/// As many bits flipped as there are bytes: an error, or a film that has what its sizes say.
TEST(FilmSums, DamagedOnesAreRefused) {
  const TemporaryFolder folder;
  write(folder.file("a.exr"), some_film(true));
  std::ifstream in(folder.file("a.exr"), std::ios::binary);
  const std::vector<char> whole{std::istreambuf_iterator<char>(in), {}};
  std::mt19937 random(1);
  int refused = 0;
  const auto try_to_read = [&](const std::vector<char>& bytes) {
    std::ofstream(folder.file("b.exr"), std::ios::binary)
        .write(bytes.data(), std::streamsize(bytes.size()));
    try {
      const FilmFile f = read_film_file(folder.file("b.exr"));
      EXPECT_EQ(f.film.pixels.size(), f.film.remainders.pixels.size());
    } catch (const Error& e) {
      EXPECT_NE(std::string(e.what()).find("b.exr: "), std::string::npos) << e.what();
      ++refused;
    }
  };
  for (int trial = 0; trial < proof::samples(400, 2); ++trial) {
    std::vector<char> bytes = whole;
    // Half of them in the header, where the record is.
    const std::size_t reach = trial % 2 ? bytes.size() : std::min<std::size_t>(bytes.size(), 12000);
    bytes[random() % reach] = char(random());
    try_to_read(bytes);
  }
  for (int trial = 0; trial < 40; ++trial) {
    try_to_read({whole.begin(), whole.begin() + std::ptrdiff_t(random() % whole.size())});
  }
  EXPECT_GT(refused, proof::samples(60, 2));
}

/// Files of earlier versions have digits that were not carried.
TEST(FilmSums, WithDigitsThatNoTermsHaveAreRefused) {
  Film film = some_film(true);
  detail::PixelRecord record = detail::empty_record(film.layers);
  const auto refuses = [&](std::size_t pixel, const auto& change) {
    detail::load(film, pixel, record);
    detail::store(record, pixel, film);
    change(record.sums);
    EXPECT_THROW(detail::store(record, pixel, film), Error);
  };
  refuses(7, [](ExactSums& s) { s.light.digits[1][2] = 1ll << 40; });
  refuses(7,
          [](ExactSums& s) { s.squares.digits[0][0] = std::numeric_limits<std::int64_t>::min(); });
  refuses(0, [](ExactSums& s) { s.alpha.digits[2][0] = 1; });
  refuses(0, [](ExactSums& s) { s.group.digits[2][0] = 1; });
  refuses(9, [](ExactSums& s) { s.layers[1].weight.digits[0][0] = -(1ll << 50); });
  refuses(9, [](ExactSums& s) { s.squares.level = 32, s.squares.digits[0][1] = 1ll << 33; });
  detail::load(film, 7, record);
  record.sums.light.digits[1][2] += 1, record.sums.light.digits[2][2] -= 1ll << 32;
  const ExactSums same = record.sums;
  EXPECT_NO_THROW(detail::store(record, 7, film));
  detail::load(film, 7, record);
  EXPECT_EQ(record.sums, same);
}

TEST(FilmSums, ThatNoTermsHaveAreRefused) {
  const TemporaryFolder folder;
  const auto refuses = [&](const std::function<void(Film&)>& change) {
    Film film = some_film(true);
    change(film);
    write(folder.file("a.exr"), film);
    EXPECT_THROW((void)read_film_file(folder.file("a.exr")), Error);
  };
  refuses([](Film& f) { f.pixels[7].sum.z = -0x1p80; });
  refuses([](Film& f) { f.remainders.pixels[0].alpha.rest[0][0] = 1; });
  refuses([](Film& f) { f.remainders.pixels[7].alpha.level = 33; });
  refuses([](Film& f) { f.pixels[7].group_samples = 8; });
  refuses([](Film& f) { f.layers[1].weights[9] = -0x1p50; });
  refuses([](Film& f) { f.layers[3].sums[2].x = std::nan(""); });
  refuses([](Film& f) { f.needs->share[5] = -1; });
}

/// A record that takes for ever to check, or beyond the numbers that it is checked with.
TEST(FilmSums, OfPiecesThatAreNotInThemAreRefused) {
  const TemporaryFolder folder;
  const Film film = some_film(false);
  const FilmPiece good = some_record().pieces[0];
  const auto refuses = [&](const std::function<void(FilmPiece&)>& change) {
    FilmPiece piece = good;
    change(piece);
    write_exr(folder.file("a.exr"), film, {}, {.sums = KeptSums{&film, {"key", {piece}}}});
    EXPECT_THROW((void)read_film_file(folder.file("a.exr")), Error);
  };
  constexpr int kMost = std::numeric_limits<int>::max();
  refuses([](FilmPiece& p) { p.width = kMost, p.height = kMost; });
  refuses([](FilmPiece& p) { p.x = kMost; });
  refuses([](FilmPiece& p) { p.x = -1; });
  refuses([](FilmPiece& p) { p.x = 2; });
  refuses([](FilmPiece& p) { p.y = std::numeric_limits<int>::min(); });
  refuses([](FilmPiece& p) { p.height = 0; });
  refuses([](FilmPiece& p) { p.width = 20; });
  refuses([](FilmPiece& p) { p.begin = p.end; });
  refuses([](FilmPiece& p) { p.end = 0; });
}

TEST(FilmSums, OfOtherVersionsAreRefused) {
  const TemporaryFolder folder;
  write(folder.file("a.exr"), some_film(false));
  std::ifstream in(folder.file("a.exr"), std::ios::binary);
  std::string bytes{std::istreambuf_iterator<char>(in), {}};
  const std::string version = "\"version\":2";
  const std::size_t at = bytes.find(version);
  ASSERT_NE(at, std::string::npos);
  for (const char other : {'1', '3'}) {
    bytes[at + version.size() - 1] = other;
    std::ofstream(folder.file("b.exr"), std::ios::binary) << bytes;
    try {
      (void)read_film_file(folder.file("b.exr"));
      FAIL();
    } catch (const Error& e) {
      EXPECT_TRUE(says(e.what(), "film.stores_sums_version")) << e.what();
    }
  }
}

}  // namespace film_sums_test
}  // namespace pvol::formats
