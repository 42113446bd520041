// What a renderer does that has its density in memory: a volume from a dense array, then free
// flights and transmittance along rays of the world from several threads, here checked against the
// law of Beer and Lambert. The manual is pvol/embed.h. Trackers of its own and a picture are in
// trackers.cpp and picture.cpp.
#include <array>
#include <cmath>
#include <cstdio>
#include <thread>
#include <vector>

#include "consumer.h"
#include "pvol/embed.h"

namespace {

constexpr int kSize = 40, kThreads = 4, kRays = 50'000;
constexpr double kVoxel = 0.05, kExtinction = 3;

/// Waves on a slope, equal in y and z: rays along x have a simple closed form.
float density(int x) { return 0.02f * float(x) * (1.2f + std::sin(0.5f * float(x))); }

/// Means over one thread's rays: transmittance, flights that left, transmittance to collisions, and
/// flights that left by a tracker of the consumer's own.
using Means = std::array<double, 4>;
Means trace(const pvol::Volume& cloud, int thread) {
  constexpr pvol::Ray kRay{{-1, 1, 1}, {1, 0, 0}};
  constexpr double kFar = 100;
  Means sum{};
  for (int i = 0; i < kRays; ++i) {
    pvol::Rng rng(/*seed=*/1, /*stream=*/std::uint64_t(thread), /*sample=*/std::uint64_t(i));
    sum[0] += double(pvol::sample_transmittance(cloud, kRay, kFar, rng)) / kRays;
    const pvol::Flight flight = pvol::sample_flight(cloud, kRay, kFar, rng);
    if (flight.collided) {
      sum[2] += pvol::exact_transmittance(cloud, kRay, flight.t) / kRays;
    } else {
      sum[1] += 1.0 / kRays;
    }
    if (passes(cloud, kRay, rng)) sum[3] += 1.0 / kRays;
  }
  return sum;
}

}  // namespace

int main() {
  std::vector<float> samples;  // x slowest, z fastest
  double depth = 0;            // optical depth of a ray along x: the trapezium rule is exact
  for (int x = 0; x < kSize; ++x) {
    samples.insert(samples.end(), kSize * kSize, density(x));
    depth += kExtinction * kVoxel * double(density(x));
  }
  const pvol::VoxelGrid grid =
      pvol::make_grid({.values = samples.data(), .size = {kSize, kSize, kSize}},
                      pvol::scaling({kVoxel, kVoxel, kVoxel}));
  const pvol::Volume cloud = pvol::make_volume(grid, {.extinction = kExtinction});

  std::vector<Means> found(kThreads);
  std::vector<std::thread> threads;
  for (std::size_t i = 0; i < kThreads; ++i) {
    threads.emplace_back([&, i] { found[i] = trace(cloud, int(i)); });
  }
  for (std::thread& t : threads) t.join();

  // A flight ends where the transmittance has fallen to a number uniform in [0, 1].
  const double t = std::exp(-depth), exact[4] = {t, t, (1 - t * t) / 2, t};
  bool ok = true;
  for (std::size_t k = 0; k < 4; ++k) {
    double mean = 0;
    for (const Means& m : found) mean += m[k] / kThreads;
    std::printf("%.4f, exactly %.4f\n", mean, exact[k]);
    ok &= std::abs(mean - exact[k]) < 0.003;  // 5 standard errors
  }

  pvol::Rng rng(/*seed=*/2, /*stream=*/0, /*sample=*/0);
  int turns = 0;
  for (int i = 0; i < 1000; ++i) turns += count_turns(cloud, {{-1, 1, 1}, {1, 0, 0}}, rng);
  const double mean = mean_of_picture(cloud);
  std::printf("%d turns of 1000 paths; white furnace: %.4f, exactly 1\n", turns, mean);
  ok &= turns > 0 && std::abs(mean - 1) < 1e-3;
  return ok ? 0 : 1;
}
