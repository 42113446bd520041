#include "image/sum_planes.h"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cmath>

#include "pvol/error.h"

namespace pvol::formats::detail {
namespace {

/// A 64-bit number as two planes. Halves are signed, so that the upper one of a small number is 0.
template <class At>
void add_halves(std::vector<Plane>& planes, const std::string& name, const At& at) {
  const auto low = [](std::int64_t v) { return std::int32_t(std::uint32_t(std::uint64_t(v))); };
  planes.push_back(
      {name + "l", [=](const PixelRecord& p) { return std::uint32_t(low(at(p))); },
       [=](PixelRecord& p, std::uint32_t bits) { at(p) = std::int64_t(std::int32_t(bits)); }});
  planes.push_back({name + "h",
                    [=](const PixelRecord& p) {
                      const std::int64_t v = at(p);
                      const auto rest = std::uint64_t(v) - std::uint64_t(std::int64_t(low(v)));
                      return std::uint32_t(rest >> 32);
                    },
                    [=](PixelRecord& p, std::uint32_t bits) {
                      std::int64_t& v = at(p);
                      v = std::int64_t(std::uint64_t(v) + (std::uint64_t(bits) << 32));
                    }});
}

/// The first `channels` of a sum.
template <class At>
void add_sum(std::vector<Plane>& planes, const std::string& name, int channels, const At& at) {
  using Sum = std::remove_cvref_t<decltype(at(std::declval<PixelRecord&>()))>;
  for (int c = 0; c < channels; ++c) {
    for (int d = 0; d < Sum::kDigits; ++d) {
      add_halves(
          planes, fmt::format("{}_{}{}", name, c, d), [=](auto& p) -> auto& {
            return at(p).digits[std::size_t(d)][std::size_t(c)];
          });
    }
  }
  planes.push_back({name + "_level",
                    [=](const PixelRecord& p) { return std::uint32_t(at(p).level - Sum::kLowest); },
                    [=](PixelRecord& p, std::uint32_t bits) {
                      if (bits > std::uint32_t(Sum::kHighest - Sum::kLowest)) {
                        throw Error(name +
                                    "_level holds an impossible number; the file is damaged");
                      }
                      at(p).level = std::int8_t(int(bits) + Sum::kLowest);
                    }});
}

/// A double to the bit.
template <class At>
void add_double(std::vector<Plane>& planes, const std::string& name, const At& at) {
  const auto bits_of = [](double v) { return std::bit_cast<std::uint64_t>(v); };
  planes.push_back({name + "l", [=](const PixelRecord& p) { return std::uint32_t(bits_of(at(p))); },
                    [=](PixelRecord& p, std::uint32_t bits) {
                      at(p) = std::bit_cast<double>(std::uint64_t(bits));
                    }});
  planes.push_back({name + "h",
                    [=](const PixelRecord& p) { return std::uint32_t(bits_of(at(p)) >> 32); },
                    [=](PixelRecord& p, std::uint32_t bits) {
                      double& v = at(p);
                      v = std::bit_cast<double>(bits_of(v) + (std::uint64_t(bits) << 32));
                    }});
}

void add_layer(std::vector<Plane>& planes, std::size_t k, const Layer& layer) {
  const std::string name = fmt::format("layer{}", k);
  const auto channels = int(layer.components.size());
  if (layer.least) {
    for (int c = 0; c < channels; ++c) {
      add_double(planes, fmt::format("{}_{}", name, c),
                 [=](auto& p) -> decltype(auto) { return p.least[k][c]; });
    }
    return;
  }
  add_sum(
      planes, name, channels, [=](auto& p) -> auto& { return p.sums.layers[k].sum; });
  if (layer.weights.empty()) return;
  add_sum(
      planes, name + "_weight", 1, [=](auto& p) -> auto& { return p.sums.layers[k].weight; });
}

void add_counts(std::vector<Plane>& planes) {
  for (std::size_t c = 0; c < kPixelCounts.size(); ++c) {
    const std::string name = fmt::format("count{}_", c);
    for (const int shift : {0, 32}) {
      planes.push_back({name + (shift == 0 ? "l" : "h"),
                        [=](const PixelRecord& p) { return std::uint32_t(p.counts[c] >> shift); },
                        [=](PixelRecord& p, std::uint32_t bits) {
                          const std::uint64_t low = shift == 0 ? 0 : p.counts[c];
                          p.counts[c] = low | std::uint64_t(bits) << shift;
                        }});
    }
  }
}

void add_share(std::vector<Plane>& planes) {
  planes.push_back({"share",
                    [](const PixelRecord& p) { return std::bit_cast<std::uint32_t>(p.share); },
                    [](PixelRecord& p, std::uint32_t bits) {
                      p.share = std::bit_cast<float>(bits);
                      if (!std::isfinite(p.share) || p.share < 0) {
                        throw Error("share holds an impossible number; the file is damaged");
                      }
                    }});
}

/// Whether so many terms can have this sum.
template <int kSize>
bool is_possible(const ReproducibleSum<kSize>& sum, std::uint32_t terms) {
  const double most = std::min(0x1p31 * terms, 0x1p62);  // so that digits can be carried
  for (const auto& digit : sum.digits) {
    for (const std::int64_t d : digit) {
      if (std::abs(double(d)) > most) return false;
    }
  }
  for (int c = 0; c < kSize; ++c) {
    if (!std::isfinite(sum.value(c))) return false;
  }
  return true;
}

bool is_possible(const PixelRecord& p) {
  const auto sums_ok = [&](const auto&... sums) { return (is_possible(sums, p.samples) && ...); };
  return p.group_samples <= p.samples &&
         sums_ok(p.sums.light, p.sums.squares, p.sums.alpha, p.sums.group) &&
         std::ranges::all_of(p.sums.layers,
                             [&](const auto& l) { return sums_ok(l.sum, l.weight); }) &&
         std::ranges::all_of(p.least, [](Vec3d v) { return is_finite(v); });
}

}  // namespace

std::vector<Plane> planes_of(const std::vector<Layer>& layers, PlaneChoice choice) {
  std::vector<Plane> planes;
  planes.push_back({"samples", [](const PixelRecord& p) { return p.samples; },
                    [](PixelRecord& p, std::uint32_t n) { p.samples = n; }});
  planes.push_back({"group_samples", [](const PixelRecord& p) { return p.group_samples; },
                    [](PixelRecord& p, std::uint32_t n) { p.group_samples = n; }});
  add_sum(
      planes, "light", 3, [](auto& p) -> auto& { return p.sums.light; });
  add_sum(
      planes, "squares", 3, [](auto& p) -> auto& { return p.sums.squares; });
  add_sum(
      planes, "alpha", 1, [](auto& p) -> auto& { return p.sums.alpha; });
  add_sum(
      planes, "group", 1, [](auto& p) -> auto& { return p.sums.group; });
  for (std::size_t k = 0; k < layers.size(); ++k) add_layer(planes, k, layers[k]);
  if (choice.counts) add_counts(planes);
  if (choice.needs) add_share(planes);
  return planes;
}

PixelRecord empty_record(const std::vector<Layer>& layers) {
  PixelRecord p;
  p.sums.layers.resize(layers.size()), p.least.resize(layers.size());
  return p;
}

void load(const Film& film, std::size_t pixel, PixelRecord& to) {
  to.samples = film.pixels[pixel].samples, to.group_samples = film.pixels[pixel].group_samples;
  load_sums(film, pixel, to.sums);
  to.least.resize(film.layers.size());
  for (std::size_t k = 0; k < film.layers.size(); ++k) {
    if (film.layers[k].least) to.least[k] = film.layers[k].sums[pixel];
  }
  if (!film.counts.empty()) to.counts = film.counts[pixel];
  if (film.needs) to.share = film.needs->share[pixel];
}

void store(const PixelRecord& from, std::size_t pixel, Film& film) {
  if (!is_possible(from)) {
    throw Error(fmt::format("pixel {} has sums that {} samples cannot have; the file is damaged",
                            pixel, from.samples));
  }
  film.pixels[pixel].samples = from.samples, film.pixels[pixel].group_samples = from.group_samples;
  make_room(from.samples, film);
  store_sums(from.sums, pixel, film);
  for (std::size_t k = 0; k < film.layers.size(); ++k) {
    if (film.layers[k].least) film.layers[k].sums[pixel] = from.least[k];
  }
  if (!film.counts.empty()) film.counts[pixel] = from.counts;
  if (film.needs) film.needs->share[pixel] = from.share;
}

}  // namespace pvol::formats::detail
