// Batches of rays, for tests with each kernel.
#pragma once

#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "pvol/volume/batch.h"
#include "support/error_of.h"
#include "support/placed_clouds.h"

namespace pvol::test {

inline constexpr auto kRatio = Transmittance::ratio, kAnalog = Transmittance::analog;

/// Rays as rows of doubles.
struct Rays {
  std::vector<Vec3d> o, d;
  std::vector<double> t_max;

  void add(const Ray& ray, double end) {
    o.push_back(ray.o), d.push_back(ray.d), t_max.push_back(end);
  }
  [[nodiscard]] RayBatch batch() const { return part(0, o.size()); }
  [[nodiscard]] RayBatch part(std::size_t begin, std::size_t size) const {
    return {size,
            {o.data() + begin, true, sizeof(Vec3d), sizeof(double)},
            {d.data() + begin, true, sizeof(Vec3d), sizeof(double)},
            {t_max.data() + begin, true, sizeof(double)}};
  }
};

/// One ray, again and again.
inline RayBatch again(const Ray& ray, const double& t_max, std::size_t times) {
  return {times,
          {&ray.o, true, 0, sizeof(double)},
          {&ray.d, true, 0, sizeof(double)},
          {&t_max, true, 0}};
}

inline Rays aimed(const PlacedCloud& cloud, std::size_t count, std::uint64_t stream) {
  Rays all;
  for (std::size_t i = 0; i < count; ++i) {
    Rng rng(kPlacedSeed, stream, i);
    const auto [ray, t_max] = cloud.aim(int(i) % kKinds, rng);
    all.add(ray, t_max);
  }
  return all;
}

inline std::vector<double> flights(const BatchField& f, const RayBatch& rays,
                                   const BatchNumbers& n) {
  std::vector<double> t(rays.size, -1);
  EXPECT_EQ(sample_flights(f, rays, n, t.data()), 0u);
  return t;
}
inline std::vector<float> through(const BatchField& f, const RayBatch& rays, const BatchNumbers& n,
                                  Transmittance estimator) {
  std::vector<float> t(rays.size, -1);
  EXPECT_EQ(sample_transmittances(f, rays, n, estimator, t.data()), 0u);
  return t;
}

/// All that batches answer, as bits.
struct Answers {
  std::vector<double> t;
  std::vector<float> analog, ratio;
  friend bool operator==(const Answers&, const Answers&) = default;

  void append(const Answers& more) {
    t.insert(t.end(), more.t.begin(), more.t.end());
    analog.insert(analog.end(), more.analog.begin(), more.analog.end());
    ratio.insert(ratio.end(), more.ratio.begin(), more.ratio.end());
  }
};
inline Answers answers(const BatchField& f, const RayBatch& rays, const BatchNumbers& n) {
  return {flights(f, rays, n), through(f, rays, n, kAnalog), through(f, rays, n, kRatio)};
}

/// Each test, with each kernel that the machine has.
class Batch : public ::testing::TestWithParam<KernelKind> {
 protected:
  void SetUp() override {
    const PlacedCloud cloud(field("gaussian"), {}, 1);
    const std::string why = error_of([&] { BatchField(cloud.volume, GetParam()); });
    if (!why.empty()) GTEST_SKIP() << why;
  }
  [[nodiscard]] BatchField ready(const PlacedCloud& cloud) const {
    return BatchField(cloud.volume, GetParam());
  }
};

}  // namespace pvol::test
