#include "cli/coverage.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstdint>
#include <map>
#include <tuple>

namespace pvol::cli {
namespace {

using formats::FilmPiece;

/// Numbers of samples; of adaptive ones, one stands for all.
std::pair<std::uint64_t, std::uint64_t> range_of(const FilmPiece& p) {
  return p.end > 0 ? std::pair<std::uint64_t, std::uint64_t>{p.begin, p.end}
                   : std::pair<std::uint64_t, std::uint64_t>{0, 1};
}

std::optional<FilmPiece> common(const FilmPiece& a, const FilmPiece& b) {
  if (a.seed != b.seed) return std::nullopt;
  FilmPiece both = a;
  both.x = std::max(a.x, b.x), both.y = std::max(a.y, b.y);
  both.width = std::min(a.x + a.width, b.x + b.width) - both.x;
  both.height = std::min(a.y + a.height, b.y + b.height) - both.y;
  const auto [a_begin, a_end] = range_of(a);
  const auto [b_begin, b_end] = range_of(b);
  if (both.width <= 0 || both.height <= 0 || a_begin >= b_end || b_begin >= a_end) {
    return std::nullopt;
  }
  if (a.end > 0 && b.end > 0) {
    both.begin = std::max(a.begin, b.begin), both.end = std::min(a.end, b.end);
  }
  return both;
}

/// Samples that each pixel of a whole has, by the sums of what begins and ends at corners of
/// pieces.
std::vector<std::uint64_t> samples_by_pixel(const std::vector<FilmPiece>& pieces,
                                            const FilmPiece& whole) {
  const auto width = std::size_t(whole.width), stride = width + 1;
  std::vector<std::uint64_t> sums(stride * (std::size_t(whole.height) + 1));
  for (const FilmPiece& p : pieces) {
    const std::optional<FilmPiece> part = common(p, whole);
    const bool pilot = p.end > 0 && whole.end == 0;
    if (!part || pilot) continue;
    const auto [begin, end] = range_of(*part);
    const auto x = std::size_t(part->x - whole.x), y = std::size_t(part->y - whole.y);
    const auto right = x + std::size_t(part->width), below = y + std::size_t(part->height);
    // Differences wrap around, and their sums back.
    sums[y * stride + x] += end - begin, sums[y * stride + right] -= end - begin;
    sums[below * stride + x] -= end - begin, sums[below * stride + right] += end - begin;
  }
  for (std::size_t y = 0; y < std::size_t(whole.height); ++y) {
    for (std::size_t x = 1; x < stride; ++x) sums[y * stride + x] += sums[y * stride + x - 1];
    for (std::size_t x = 0; x < stride && y > 0; ++x) {
      sums[y * stride + x] += sums[(y - 1) * stride + x];
    }
  }
  return sums;
}

/// The first samples that a pixel lacks.
FilmPiece find_gap(const std::vector<FilmPiece>& pieces, FilmPiece pixel) {
  std::vector<std::pair<std::uint64_t, std::uint64_t>> ranges;
  for (const FilmPiece& p : pieces) {
    if (const auto part = common(p, pixel)) ranges.push_back(range_of(*part));
  }
  std::ranges::sort(ranges);
  if (pixel.end == 0) return pixel;
  for (const auto& [begin, end] : ranges) {
    if (begin > pixel.begin) {
      pixel.end = std::uint32_t(begin);
      break;
    }
    pixel.begin = std::uint32_t(end);
  }
  return pixel;
}

}  // namespace

std::optional<Doubled> find_doubled(const std::vector<FilmPiece>& pieces) {
  // Pieces of one square of the image, in the order of their samples: each needs to be compared
  // with those after it that begin before its end.
  constexpr int kSquare = 256;
  std::map<std::tuple<std::uint64_t, int, int>, std::vector<std::size_t>> squares;
  for (std::size_t i = 0; i < pieces.size(); ++i) {
    const FilmPiece& p = pieces[i];
    for (int y = p.y / kSquare; y <= (p.y + p.height - 1) / kSquare; ++y) {
      for (int x = p.x / kSquare; x <= (p.x + p.width - 1) / kSquare; ++x) {
        squares[{p.seed, x, y}].push_back(i);
      }
    }
  }
  for (auto& [square, here] : squares) {
    std::ranges::stable_sort(here, {}, [&](std::size_t i) { return range_of(pieces[i]).first; });
    for (std::size_t i = 0; i < here.size(); ++i) {
      const std::uint64_t end = range_of(pieces[here[i]]).second;
      for (std::size_t j = i + 1; j < here.size(); ++j) {
        if (range_of(pieces[here[j]]).first >= end) break;
        if (const auto both = common(pieces[here[i]], pieces[here[j]])) {
          return Doubled{here[i], here[j], *both};
        }
      }
    }
  }
  return std::nullopt;
}

std::optional<Missing> find_missing(const std::vector<FilmPiece>& pieces, const FilmPiece& whole) {
  const std::vector<std::uint64_t> counts = samples_by_pixel(pieces, whole);
  const auto [begin, end] = range_of(whole);
  const auto stride = std::size_t(whole.width) + 1;
  std::optional<Missing> missing;
  for (int y = 0; y < whole.height; ++y) {
    for (int x = 0; x < whole.width; ++x) {
      if (counts[std::size_t(y) * stride + std::size_t(x)] >= end - begin) continue;
      if (!missing) {
        FilmPiece pixel = whole;
        pixel.x = whole.x + x, pixel.y = whole.y + y, pixel.width = pixel.height = 1;
        missing = Missing{0, find_gap(pieces, pixel)};
      }
      ++missing->pixels;
    }
  }
  return missing;
}

std::string describe(const FilmPiece& p) {
  const std::string samples =
      p.end > 0 ? fmt::format("samples {}:{}", p.begin, p.end) : "adaptive samples";
  const std::string pixels =
      p.width == 1 && p.height == 1
          ? fmt::format("pixel {},{}", p.x, p.y)
          : fmt::format("pixels {},{} to {},{}", p.x, p.y, p.x + p.width - 1, p.y + p.height - 1);
  return fmt::format("{} of {} of seed {}", samples, pixels, p.seed);
}

}  // namespace pvol::cli
