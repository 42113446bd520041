#include "image/sum_planes.h"

#include <fmt/format.h>

#include <bit>
#include <cmath>

#include "pvol/error.h"

namespace pvol::formats::detail {
namespace {

/// A 64-bit number as two planes. Halves are signed, so that the upper one of a small number is 0.
template <class At>
void add_halves(std::vector<Plane>& planes, const std::string& name, const At& at) {
  const auto low = [](std::int64_t v) { return std::int32_t(std::uint32_t(std::uint64_t(v))); };
  planes.push_back({name + "l",
                    [=](const Film& f, std::size_t i) { return std::uint32_t(low(at(f, i))); },
                    [=](Film& f, std::size_t i, std::uint32_t bits) {
                      at(f, i) = std::int64_t(std::int32_t(bits));
                    }});
  planes.push_back({name + "h",
                    [=](const Film& f, std::size_t i) {
                      const std::int64_t v = at(f, i);
                      const auto rest = std::uint64_t(v) - std::uint64_t(std::int64_t(low(v)));
                      return std::uint32_t(rest >> 32);
                    },
                    [=](Film& f, std::size_t i, std::uint32_t bits) {
                      std::int64_t& v = at(f, i);
                      v = std::int64_t(std::uint64_t(v) + (std::uint64_t(bits) << 32));
                    }});
}

/// The first `channels` of a sum.
template <class At>
void add_sum(std::vector<Plane>& planes, const std::string& name, int channels, const At& at) {
  using Sum = std::remove_cvref_t<decltype(at(std::declval<Film&>(), 0))>;
  for (int c = 0; c < channels; ++c) {
    for (int d = 0; d < Sum::kDigits; ++d) {
      add_halves(
          planes, fmt::format("{}_{}{}", name, c, d), [=](auto& f, std::size_t i) -> auto& {
            return at(f, i).digits[std::size_t(d)][std::size_t(c)];
          });
    }
  }
  planes.push_back(
      {name + "_level",
       [=](const Film& f, std::size_t i) { return std::uint32_t(at(f, i).level - Sum::kLowest); },
       [=](Film& f, std::size_t i, std::uint32_t bits) {
         if (bits > std::uint32_t(Sum::kHighest - Sum::kLowest)) {
           throw Error(name + "_level holds an impossible number; the file is damaged");
         }
         at(f, i).level = std::int8_t(int(bits) + Sum::kLowest);
       }});
}

/// A double to the bit.
template <class At>
void add_double(std::vector<Plane>& planes, const std::string& name, const At& at) {
  const auto bits_of = [](double v) { return std::bit_cast<std::uint64_t>(v); };
  planes.push_back({name + "l",
                    [=](const Film& f, std::size_t i) { return std::uint32_t(bits_of(at(f, i))); },
                    [=](Film& f, std::size_t i, std::uint32_t bits) {
                      at(f, i) = std::bit_cast<double>(std::uint64_t(bits));
                    }});
  planes.push_back(
      {name + "h",
       [=](const Film& f, std::size_t i) { return std::uint32_t(bits_of(at(f, i)) >> 32); },
       [=](Film& f, std::size_t i, std::uint32_t bits) {
         double& v = at(f, i);
         v = std::bit_cast<double>(bits_of(v) + (std::uint64_t(bits) << 32));
       }});
}

void add_layer(std::vector<Plane>& planes, std::size_t k, const Layer& layer) {
  const std::string name = fmt::format("layer{}", k);
  const auto channels = int(layer.components.size());
  if (layer.least) {
    for (int c = 0; c < channels; ++c) {
      add_double(planes, fmt::format("{}_{}", name, c),
                 [=](auto& f, std::size_t i) -> decltype(auto) { return f.layers[k].sums[i][c]; });
    }
    return;
  }
  add_sum(
      planes, name,
      channels, [=](auto& f, std::size_t i) -> auto& { return f.sums.layers[k].sums[i]; });
  if (layer.weights.empty()) return;
  add_sum(
      planes, name + "_weight",
      1, [=](auto& f, std::size_t i) -> auto& { return f.sums.layers[k].weights[i]; });
}

/// Whether so many terms can have this sum.
template <int kSize>
bool is_possible(const ReproducibleSum<kSize>& sum, std::uint32_t terms) {
  const double most = 0x1p31 * terms;
  for (const auto& digit : sum.digits) {
    for (const std::int64_t d : digit) {
      if (std::abs(double(d)) > most) return false;
    }
  }
  return true;
}

}  // namespace

std::vector<Plane> planes_of(const std::vector<Layer>& layers, PlaneChoice choice) {
  std::vector<Plane> planes;
  planes.push_back({"samples", [](const Film& f, std::size_t i) { return f.pixels[i].samples; },
                    [](Film& f, std::size_t i, std::uint32_t n) { f.pixels[i].samples = n; }});
  add_sum(
      planes, "light", 3, [](auto& f, std::size_t i) -> auto& { return f.sums.pixels[i].light; });
  add_sum(
      planes, "squares", 3,
      [](auto& f, std::size_t i) -> auto& { return f.sums.pixels[i].squares; });
  add_sum(
      planes, "alpha", 1, [](auto& f, std::size_t i) -> auto& { return f.sums.pixels[i].alpha; });
  for (std::size_t k = 0; k < layers.size(); ++k) add_layer(planes, k, layers[k]);
  for (std::size_t c = 0; c < kPixelCounts.size() && choice.counts; ++c) {
    const std::string name = fmt::format("count{}_", c);
    for (const int shift : {0, 32}) {
      planes.push_back({name + (shift == 0 ? "l" : "h"),
                        [=](const Film& f, std::size_t i) {
                          return std::uint32_t(f.pixels[i].counts[c] >> shift);
                        },
                        [=](Film& f, std::size_t i, std::uint32_t bits) {
                          f.pixels[i].counts[c] |= std::uint64_t(bits) << shift;
                        }});
    }
  }
  if (choice.needs) {
    planes.push_back({"share",
                      [](const Film& f, std::size_t i) {
                        return std::bit_cast<std::uint32_t>(f.needs->share[i]);
                      },
                      [](Film& f, std::size_t i, std::uint32_t bits) {
                        const auto share = std::bit_cast<float>(bits);
                        if (!std::isfinite(share) || share < 0) {
                          throw Error("share holds an impossible number; the file is damaged");
                        }
                        f.needs->share[i] = share;
                      }});
  }
  return planes;
}

void check_sums(const Film& film, std::size_t pixel) {
  const std::uint32_t n = film.pixels[pixel].samples;
  const ExactPixel& p = film.sums.pixels[pixel];
  bool ok = is_possible(p.light, n) && is_possible(p.squares, n) && is_possible(p.alpha, n);
  for (const ExactLayer& layer : film.sums.layers) {
    if (!layer.sums.empty()) ok = ok && is_possible(layer.sums[pixel], n);
    if (!layer.weights.empty()) ok = ok && is_possible(layer.weights[pixel], n);
  }
  for (const Layer& layer : film.layers) {
    if (layer.least) ok = ok && is_finite(layer.sums[pixel]);
  }
  if (ok) return;
  throw Error(
      fmt::format("pixel {} has sums that {} samples cannot have; the file is damaged", pixel, n));
}

}  // namespace pvol::formats::detail
