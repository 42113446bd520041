// Whether pieces make a whole, against counting every sample.
#include "cli/coverage.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <random>
#include <tuple>

#include "support/effort.h"
#include "support/messages.h"

namespace pvol::cli {
namespace coverage_test {

using formats::FilmPiece;

FilmPiece piece(int x, int y, int width, int height, std::uint32_t begin, std::uint32_t end,
                std::uint64_t seed = 1) {
  return {.seed = seed,
          .x = x,
          .y = y,
          .width = width,
          .height = height,
          .begin = begin,
          .end = end,
          .complete = true};
}

/// How often each sample is there, one by one.
std::map<std::tuple<std::uint64_t, int, int, std::uint32_t>, int> count(
    const std::vector<FilmPiece>& pieces) {
  std::map<std::tuple<std::uint64_t, int, int, std::uint32_t>, int> counts;
  for (const FilmPiece& p : pieces) {
    for (int y = p.y; y < p.y + p.height; ++y) {
      for (int x = p.x; x < p.x + p.width; ++x) {
        for (std::uint32_t s = p.begin; s < std::max(p.end, p.begin + 1); ++s) {
          ++counts[{p.seed, x, y, s}];
        }
      }
    }
  }
  return counts;
}

/// Cuts a piece in two somewhere, along pixels or samples; nothing where it cannot be cut so.
std::optional<FilmPiece> cut(FilmPiece& p, std::mt19937& random) {
  FilmPiece rest = p;
  switch (random() % 3) {
    case 0: {
      if (p.width < 2) return std::nullopt;
      const int at = 1 + int(random() % unsigned(p.width - 1));
      rest.x += at, rest.width -= at, p.width = at;
      return rest;
    }
    case 1: {
      if (p.height < 2) return std::nullopt;
      const int at = 1 + int(random() % unsigned(p.height - 1));
      rest.y += at, rest.height -= at, p.height = at;
      return rest;
    }
    default: {
      if (p.end - p.begin < 2) return std::nullopt;
      const auto at = std::uint32_t(1 + random() % (p.end - p.begin - 1));
      rest.begin += at, p.end = p.begin + at;
      return rest;
    }
  }
}

TEST(Coverage, OfRandomCutsIsWhole) {
  std::mt19937 random(1);
  const FilmPiece whole = piece(40, 250, 30, 12, 5, 17);
  for (int trial = 0; trial < proof::samples(300); ++trial) {
    std::vector<FilmPiece> pieces{whole};
    for (int k = 0; k < trial % 20; ++k) {
      if (const auto rest = cut(pieces[random() % pieces.size()], random)) pieces.push_back(*rest);
    }
    std::ranges::shuffle(pieces, random);
    EXPECT_FALSE(find_doubled(pieces));
    EXPECT_FALSE(find_missing(pieces, whole));

    // Without one of them, its samples are missing and nothing else.
    const FilmPiece lost = pieces.back();
    std::vector<FilmPiece> less(pieces.begin(), pieces.end() - 1);
    const auto missing = find_missing(less, whole);
    ASSERT_TRUE(missing);
    EXPECT_EQ(missing->pixels, std::size_t(lost.width * lost.height));
    EXPECT_EQ(missing->first.x, lost.x);
    EXPECT_EQ(missing->first.y, lost.y);
    EXPECT_EQ(missing->first.begin, lost.begin);
    EXPECT_EQ(missing->first.end, lost.end);

    // With one of them twice, or one more somewhere, samples are doubled.
    std::vector<FilmPiece> more = pieces;
    FilmPiece extra = pieces[random() % pieces.size()];
    if (const auto part = cut(extra, random)) extra = *part;
    more.push_back(extra);
    const auto doubled = find_doubled(more);
    ASSERT_TRUE(doubled);
    EXPECT_NE(doubled->a, doubled->b);
    const auto counts = count(more);
    for (const auto& [sample, n] : count({doubled->both})) EXPECT_EQ(counts.at(sample), 2);
  }
}

TEST(Coverage, KnowsPiecesThatOverlapAsCountingDoes) {
  std::mt19937 random(2);
  const auto below = [&](unsigned n) { return int(random() % n); };
  int clean = 0, dirty = 0;
  for (int trial = 0; trial < 3000; ++trial) {
    std::vector<FilmPiece> pieces;
    for (int k = 0; k < 3; ++k) {
      const auto begin = std::uint32_t(below(6));
      pieces.push_back(piece(240 + below(20), 250 + below(10), 1 + below(12), 1 + below(8), begin,
                             begin + 1 + std::uint32_t(below(4)), std::uint64_t(below(2))));
    }
    int most = 0;
    for (const auto& [sample, n] : count(pieces)) most = std::max(most, n);
    EXPECT_EQ(find_doubled(pieces).has_value(), most > 1);
    ++(most > 1 ? dirty : clean);
  }
  EXPECT_GT(clean, 300);
  EXPECT_GT(dirty, 300);
}

TEST(Coverage, OfOtherSeedsDoesNotCount) {
  const FilmPiece whole = piece(0, 0, 4, 4, 0, 8);
  const std::vector<FilmPiece> pieces{piece(0, 0, 4, 4, 0, 8, 2), piece(0, 0, 4, 4, 0, 4, 1)};
  EXPECT_FALSE(find_doubled(pieces));
  const auto missing = find_missing(pieces, whole);
  ASSERT_TRUE(missing);
  EXPECT_EQ(missing->pixels, 16u);
  EXPECT_EQ(missing->first.begin, 4u);
}

TEST(Coverage, AdaptiveIsByPixels) {
  const FilmPiece whole = piece(0, 0, 4, 4, 0, 0);
  EXPECT_FALSE(find_missing({piece(0, 0, 4, 3, 0, 0), piece(0, 3, 4, 1, 0, 0)}, whole));
  const auto missing = find_missing({piece(0, 0, 4, 3, 0, 0)}, whole);
  ASSERT_TRUE(missing);
  EXPECT_EQ(missing->pixels, 4u);
  EXPECT_TRUE(says(describe(missing->first), "parts.adaptive_samples_pixel"));
  EXPECT_EQ(find_missing({piece(0, 0, 4, 4, 0, 16)}, whole)->pixels, 16u) << "a pilot";
  EXPECT_TRUE(find_doubled({piece(0, 0, 4, 3, 0, 0), piece(0, 2, 4, 2, 0, 0)}));
  EXPECT_TRUE(find_doubled({piece(0, 0, 4, 3, 0, 0), piece(0, 0, 4, 3, 0, 16)})) << "a pilot";
}

/// Ten thousand parts of one rectangle, and as many rectangles, in no time.
TEST(Coverage, OfManyPiecesIsFoundFast) {
  std::vector<FilmPiece> pieces;
  for (std::uint32_t i = 0; i < 100'000; ++i) pieces.push_back(piece(0, 0, 640, 480, i, i + 1));
  EXPECT_FALSE(find_doubled(pieces));
  EXPECT_FALSE(find_missing(pieces, piece(0, 0, 640, 480, 0, 100'000)));
  EXPECT_EQ(find_missing(pieces, piece(0, 0, 640, 480, 0, 100'001))->pixels, 640u * 480u);
  pieces.clear();
  for (int i = 0; i < 100'000; ++i) {
    pieces.push_back(piece(i % 400 * 16, i / 400 * 16, 16, 16, 0, 4));
  }
  EXPECT_FALSE(find_doubled(pieces));
  EXPECT_FALSE(find_missing(pieces, piece(0, 0, 6400, 4000, 0, 4)));
}

TEST(Coverage, IsSaidInWords) {
  EXPECT_TRUE(says(describe(piece(2, 3, 4, 5, 16, 32, 9)), "parts.samples_pixels_seed"));
}

}  // namespace coverage_test
}  // namespace pvol::cli
