// A client that instantiates pvol's templates itself and is compiled with options of its own, such
// as -ffast-math or -O0. What it gets from the library must not change by that: it prints a hash of
// the library's results, which the check compares.
#include <bit>
#include <cstdint>
#include <cstdio>
#include <vector>

#include "pvol/pvol.h"
#include "pvol/trackers.h"

namespace {

constexpr int kSize = 40;

std::uint64_t hash = 1469598103934665603u;
void add(std::uint64_t bits) { hash = (hash ^ bits) * 1099511628211u; }

/// What the library asks this volume too, compiled by the client: the loops for its look-ups, and
/// for all that may decide collisions. Those for other fields would change no result.
double instantiate(const pvol::Volume& cloud, const pvol::Ray& ray, pvol::Rng& rng) {
  double sum = 0;
  constexpr pvol::LookUp kLookUp = pvol::LookUp::trilinear;
  pvol::visit_squeeze<kLookUp>(pvol::squeeze_of(cloud.density), [&](auto squeeze) {
    const auto field = pvol::make_field<kLookUp, squeeze>(cloud.density);
    pvol::NoTally none;
    if (auto walk = pvol::enter(cloud, ray)) {
      sum += pvol::free_flight<pvol::Tracker::decomposition>(*walk, field, rng, none).collided;
    }
    if (auto walk = pvol::enter(cloud, ray)) {
      sum += double(pvol::transmittance<pvol::Transmittance::ratio, pvol::Tracker::delta>(
          *walk, field, rng, none));
    }
    if (auto walk = pvol::enter(cloud, ray)) sum += pvol::optical_depth(*walk, field, none);
  });
  return sum;
}

}  // namespace

int main() {
  std::vector<float> samples;
  for (int i = 0; i < kSize * kSize * kSize; ++i) {
    samples.push_back(float(pvol::mix64(std::uint64_t(i) / 7) >> 40) * 0x1p-24f);
  }
  const pvol::VoxelGrid grid =
      pvol::make_grid({.values = samples.data(), .size = {kSize, kSize, kSize}});
  const pvol::Volume cloud = pvol::make_volume(grid, {.extinction = 0.15});
  double own = 0;
  for (std::uint64_t i = 0; i < 20'000; ++i) {
    const pvol::Ray ray{{-3, 3.1 + double(i % 31), 17.3}, {1, 0.2, 0.0011 * double(i % 100)}};
    pvol::Rng rng(1, 2, i);
    const pvol::Flight flight = pvol::sample_flight(cloud, ray, 1e9, rng);
    add(flight.collided ? std::bit_cast<std::uint64_t>(flight.t) : 0);
    add(std::bit_cast<std::uint32_t>(pvol::sample_transmittance(cloud, ray, 1e9, rng)));
    add(std::bit_cast<std::uint64_t>(pvol::exact_transmittance(cloud, ray, 1e9)));
    add(std::bit_cast<std::uint32_t>(pvol::density_at(cloud, {12.25, 3.5 + double(i % 30), 9.75})));
    own += instantiate(cloud, ray, rng);
  }
  std::fprintf(stderr, "own sum: %.9g\n", own);
  std::printf("%016llx\n", static_cast<unsigned long long>(hash));
}
