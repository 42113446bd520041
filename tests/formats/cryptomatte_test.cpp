// Layers of objects as compositing programs read them, by a reader of the specification alone
// (read_cryptomatte.py).
#include "image/cryptomatte.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <map>
#include <memory>
#include <sstream>
#include <string>
#include <vector>

#include "pvol/formats/image.h"
#include "support/temporary_folder.h"

namespace pvol::formats {
namespace cryptomatte_test {

const std::vector<std::string>& names() {
  static const std::vector<std::string> all{"volume_1", "volume_2.1", "volume_2.2", "plane_1",
                                            "mesh_1",   "mesh_2",     "ball_1",     "solid_1"};
  return all;
}

/// Of the object at a pixel: all differ, and most pixels have some that are not there.
double coverage(std::size_t object, std::size_t pixel) {
  const std::size_t turn = (object * 5 + pixel) % 11;
  return turn > 7 ? 0 : 0.01 * double(turn) + 0.001 * double(object);
}

Film make_film() {
  Film f;
  f.width = f.crop_width = 20, f.height = f.crop_height = 18;
  f.pixels.resize(20 * 18);
  for (PixelSums& p : f.pixels) p.samples = 4;
  for (std::size_t k = 0; k < names().size(); ++k) {
    Layer& layer = f.layers.emplace_back();
    layer.name = kObjectLayer + names()[k];
    layer.components = "Y";
    for (std::size_t i = 0; i < f.pixels.size(); ++i) {
      layer.sums.emplace_back(4 * coverage(k, i), 0, 0);
    }
  }
  return f;
}

/// What the other reader prints.
std::string read_by_python(const std::filesystem::path& file, int x, int y) {
  const std::string command = std::string(PVOL_PYTHON) + " -B '" + PVOL_READ_CRYPTOMATTE + "' '" +
                              file.string() + "' " + std::to_string(x) + ' ' + std::to_string(y);
  const std::unique_ptr<std::FILE, int (*)(std::FILE*)> pipe(popen(command.c_str(), "r"), pclose);
  std::string text;
  char part[256];
  while (std::fgets(part, sizeof part, pipe.get())) text += part;
  return text;
}

TEST(Cryptomatte, HashesAreThoseOfThePublishedFunction) {
  EXPECT_EQ(detail::hash_name(""), 0u);
  EXPECT_EQ(detail::hash_name("hello"), 0x248bfa47u);
  EXPECT_EQ(detail::hash_name("The quick brown fox jumps over the lazy dog"), 0x2e4ff723u);
}

TEST(Cryptomatte, IdsAreNormalFloats) {
  for (int i = 0; i < 20'000; ++i) {
    ASSERT_TRUE(std::isnormal(detail::object_id("object " + std::to_string(i))));
  }
}

TEST(Cryptomatte, IsReadByOthersRankByRank) {
  const TemporaryFolder folder;
  const Film film = make_film();
  for (const bool multipart : {false, true}) {
    const auto file = folder.file(multipart ? "parts.exr" : "one.exr");
    (void)write_exr(file, film, {}, {.multipart = multipart, .pixels = PixelType::half});
    for (const int x : {0, 7, 19}) {
      SCOPED_TRACE(x);
      const int y = 3;
      const std::size_t pixel = film.index(x, y);
      std::istringstream lines(read_by_python(file, x, y));
      std::string name;
      double share = 0, last = 1;
      std::size_t found = 0;
      while (lines >> name >> share) {
        const auto object = std::size_t(std::ranges::find(names(), name) - names().begin());
        ASSERT_LT(object, names().size()) << name;
        EXPECT_NEAR(share, coverage(object, pixel), 1e-7);
        EXPECT_LE(share, last) << "from most to least";
        last = share;
        ++found;
      }
      std::size_t there = 0;
      for (std::size_t k = 0; k < names().size(); ++k) there += coverage(k, pixel) > 0 ? 1 : 0;
      EXPECT_EQ(found, std::min<std::size_t>(there, 6));
    }
  }
}

/// Keyers that look at one part alone find the names there; others look at the first.
TEST(Cryptomatte, ItsPartHasTheNamesAsWell) {
  const TemporaryFolder folder;
  for (const bool multipart : {false, true}) {
    const auto file = folder.file("a.exr");
    (void)write_exr(file, make_film(), {}, {.multipart = multipart});
    const std::string bytes = read_bytes(file);
    int found = 0;
    for (std::size_t at = 0; (at = bytes.find("/manifest", at)) != std::string::npos; ++at) ++found;
    EXPECT_EQ(found, multipart ? 2 : 1);
  }
}

TEST(Cryptomatte, IsMadeAgainOfAPictureThatWasRead) {
  const TemporaryFolder folder;
  const Film film = make_film();
  (void)write_exr(folder.file("a.exr"), film, {}, {.aovs = {Aov::samples}});
  const StoredFilm stored = read_film(folder.file("a.exr"));
  ASSERT_EQ(stored.film.layers.size(), names().size()) << "and no layers of the mattes";
  (void)write_exr(folder.file("b.exr"), stored.film, stored.attributes, {.aovs = {Aov::samples}});
  EXPECT_EQ(read_by_python(folder.file("a.exr"), 7, 3), read_by_python(folder.file("b.exr"), 7, 3));
  EXPECT_NE(read_by_python(folder.file("b.exr"), 7, 3), "");
}

TEST(Cryptomatte, PicturesWithoutObjectsHaveNone) {
  const TemporaryFolder folder;
  Film film = make_film();
  film.layers.clear();
  (void)write_exr(folder.file("a.exr"), film, {});
  EXPECT_EQ(read_bytes(folder.file("a.exr")).find("cryptomatte"), std::string::npos);
}

}  // namespace cryptomatte_test
}  // namespace pvol::formats
