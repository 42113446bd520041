// Pictures cut into parts: each sample of each pixel is in one part, whatever the costs.
#include "cli/split.h"

#include <gtest/gtest.h>

#include <map>

#include "cli/cli.h"
#include "cli/shell_words.h"
#include "pvol/math/rng.h"

namespace pvol::cli {
namespace split_test {

/// Costs that differ by orders of magnitude, some of them 0.
CostMap random_map(const PixelRect& whole, std::uint64_t seed) {
  CostMap map;
  map.columns = map.rows = 20;
  map.left = whole.x, map.top = whole.y;
  map.cell_width = whole.width / 20.0, map.cell_height = whole.height / 20.0;
  Rng rng(seed, 0, 0);
  for (int i = 0; i < 400; ++i) {
    const double u = double(rng.uniform());
    map.work.push_back(u < 0.2 ? 0 : std::pow(10, 4 * double(rng.uniform())));
  }
  return map;
}

CostMap even_map(const PixelRect& whole) {
  CostMap map;
  map.columns = map.rows = 1;
  map.left = whole.x, map.top = whole.y;
  map.cell_width = whole.width, map.cell_height = whole.height;
  map.work = {1};
  return map;
}

std::vector<PicturePart> split(const PixelRect& whole, std::uint32_t samples, int count,
                               const CostMap& map) {
  return split_picture(whole, samples, count, CostSums(map, map.work));
}

/// Samples of each pixel that the parts have, where none is missing and none twice.
void expect_whole(const PixelRect& whole, std::uint32_t samples,
                  const std::vector<PicturePart>& parts) {
  std::vector<std::uint64_t> found(std::size_t(whole.width) * std::size_t(whole.height));
  std::map<std::tuple<int, int, int, int>, std::uint32_t> next;  // sample of a rectangle
  for (const PicturePart& p : parts) {
    const PixelRect& r = p.pixels;
    ASSERT_GE(r.width, 1);
    ASSERT_GE(r.height, 1);
    ASSERT_LT(p.first_sample, p.end_sample);
    std::uint32_t& first = next[{r.x, r.y, r.width, r.height}];
    ASSERT_EQ(p.first_sample, first) << "ranges of one rectangle follow each other";
    first = p.end_sample;
    for (int y = r.y; y < r.y + r.height; ++y) {
      for (int x = r.x; x < r.x + r.width; ++x) {
        const int i = x - whole.x, j = y - whole.y;
        ASSERT_TRUE(i >= 0 && j >= 0 && i < whole.width && j < whole.height);
        found[std::size_t(j) * std::size_t(whole.width) + std::size_t(i)] +=
            p.end_sample - p.first_sample;
      }
    }
  }
  for (const std::uint64_t n : found) ASSERT_EQ(n, samples);
}

TEST(SplitPicture, CoversEachSampleOnceInExactlySoManyParts) {
  Rng rng(7, 0, 0);
  const auto up_to = [&](int n) { return 1 + int(double(rng.uniform()) * n) % n; };
  for (int round = 0; round < 400; ++round) {
    const PixelRect whole{up_to(50) - 1, up_to(50) - 1, up_to(150), up_to(150)};
    const auto samples = std::uint32_t(up_to(round % 2 ? 3 : 300));
    const double most = double(whole.width) * whole.height * samples;
    const int count = up_to(int(std::min(most, round % 3 ? 50.0 : 3000.0)));
    const auto parts = split(whole, samples, count, random_map(whole, std::uint64_t(round)));
    SCOPED_TRACE(::testing::Message() << whole.width << "x" << whole.height << " samples "
                                      << samples << " parts " << count);
    ASSERT_EQ(parts.size(), std::size_t(count));
    expect_whole(whole, samples, parts);
    double sum = 0;
    for (const PicturePart& p : parts) sum += p.share;
    EXPECT_NEAR(sum, 1, 1e-9);
  }
}

TEST(SplitPicture, AtItsLimitHasAPartForEachSample) {
  const PixelRect whole{3, 4, 5, 7};
  const auto parts = split(whole, 3, 105, even_map(whole));
  ASSERT_EQ(parts.size(), 105u);
  expect_whole(whole, 3, parts);
  EXPECT_THROW((void)split(whole, 3, 106, even_map(whole)), UsageError);
}

TEST(SplitPicture, HasTilesOfSixteenPixelsWhereThereIsRoom) {
  const PixelRect whole{0, 0, 640, 480};
  for (const int count : {2, 10, 100, 1200, 5000}) {
    for (const PicturePart& p : split(whole, 64, count, random_map(whole, 5))) {
      EXPECT_GE(p.pixels.width, 16) << count;
      EXPECT_GE(p.pixels.height, 16) << count;
    }
  }
}

TEST(SplitPicture, IsEvenWhereTheCostIs) {
  const PixelRect whole{0, 0, 640, 480};
  for (const int count : {1, 2, 4, 64, 100, 1000, 4096}) {
    EXPECT_LE(imbalance(split(whole, 4096, count, even_map(whole))), 1.25) << count;
  }
  EXPECT_EQ(imbalance(split(whole, 1, 4, even_map(whole))), 1);
}

TEST(SplitPicture, IsNearlyEvenWhereTheCostIsNot) {
  const PixelRect whole{0, 0, 1280, 720};
  for (const int count : {10, 100, 1000}) {
    EXPECT_LE(imbalance(split(whole, 4096, count, random_map(whole, 11))), 1.25) << count;
  }
}

TEST(SplitPicture, IsTheSameEachTime) {
  const PixelRect whole{0, 0, 200, 100};
  const auto a = split(whole, 64, 70, random_map(whole, 3));
  const auto b = split(whole, 64, 70, random_map(whole, 3));
  ASSERT_EQ(a.size(), b.size());
  for (std::size_t i = 0; i < a.size(); ++i) {
    EXPECT_EQ(a[i].pixels, b[i].pixels);
    EXPECT_EQ(a[i].first_sample, b[i].first_sample);
  }
}

TEST(ShellWords, AreQuotedWhereTheyNeedIt) {
  EXPECT_EQ(shell_word("a/b-c_1.exr"), "a/b-c_1.exr");
  EXPECT_EQ(shell_word(""), "''");
  EXPECT_EQ(shell_word("a b"), "'a b'");
  EXPECT_EQ(shell_word("smoke.####.exr"), "'smoke.####.exr'");
  EXPECT_EQ(shell_word("it's"), R"('it'\''s')");
  EXPECT_EQ(shell_word("two\nlines'"), R"($'two\012lines\'')");
  EXPECT_EQ(shell_line({"pvol-render", "a b", "$x"}), "pvol-render 'a b' '$x'");
}

}  // namespace split_test
}  // namespace pvol::cli
