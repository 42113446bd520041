// Samples of a sky's picture in lanes, on the instruction set of the tests' own compiler flags.
#include <gtest/gtest.h>
#include <hwy/highway.h>

#include <array>
#include <cmath>

#include "render/engine/wavefront/sky-inl.h"
#include "support/sky_pictures.h"

namespace pvol::test {
namespace sky_lanes_test {

namespace lanes = detail::HWY_NAMESPACE;

/// One sample after the other, of registers.
class Draws {
 public:
  Draws(const SkyPicture& picture, std::uint64_t stream) : tables_(picture.tables()) {
    std::array<std::uint32_t, lanes::kLanes> a, b;
    Rng rng(proof::seeded(38), stream, 0);
    for (std::size_t k = 0; k < a.size(); ++k) {
      const auto bits = rng.block();
      a[k] = std::uint32_t(bits.lo) | 1, b[k] = std::uint32_t(bits.hi);
    }
    random_ = {lanes::load(a.data()), lanes::load(b.data())};
  }
  LightSample operator()() {
    if (next_ == lanes::kLanes) draw();
    const std::size_t k = next_++;
    return {{x_[k], y_[k], z_[k]}, {r_[k], g_[k], b_[k]}, pdf_[k]};
  }

 private:
  void draw() {
    const lanes::PictureSample s = lanes::sample_picture(tables_, random_);
    lanes::store(s.direction.x, x_), lanes::store(s.direction.y, y_);
    lanes::store(s.direction.z, z_), lanes::store(s.pdf, pdf_);
    lanes::store(s.radiance.x, r_), lanes::store(s.radiance.y, g_), lanes::store(s.radiance.z, b_);
    next_ = 0;
  }

  SkyPicture::Tables tables_;
  lanes::Random random_;
  std::size_t next_ = lanes::kLanes;
  float x_[lanes::kLanes], y_[lanes::kLanes], z_[lanes::kLanes], r_[lanes::kLanes],
      g_[lanes::kLanes], b_[lanes::kLanes], pdf_[lanes::kLanes];
};

TEST(SkyLanes, FallIntoPixelsAtTheirDensityAndEstimateTheLight) {
  proof::Family family;
  std::uint64_t stream = 0;
  for (const TestSky& p : pictures()) {
    const SkyPicture picture(p.sky, SkyPixels::even);
    add_samples(p, Draws(picture, stream++), {2e-6f, 3e-7}, family);
  }
  EXPECT_TRUE(family.passes());
}

/// Smooth pixels have the radiance of the sample's direction, and samples of them bring the light.
TEST(SkyLanes, OfSmoothPixelsBringTheLightOfTheirDirection) {
  proof::Family family;
  std::uint64_t stream = 100;
  for (const TestSky& p : pictures()) {
    if (p.sky.height % 2 != 0) continue;
    const SkyPicture picture(p.sky, SkyPixels::smooth);
    Draws draw(picture, stream);
    Rng rng(proof::seeded(39), stream++, 0);
    proof::Moments in_lanes, alone;
    int off = 0;
    constexpr int kSamples = 100'000;
    for (int i = 0; i < kSamples; ++i) {
      const LightSample l = draw(), other = picture.sample(rng);
      const Rgb seen = picture.radiance(l.direction);
      // Between a bright and a dark pixel radiance is as exact as the direction.
      const float rounding = 1e-5f * picture.largest_luminance();
      off += std::abs(luminance(seen - l.radiance)) > 1e-4f * luminance(seen) + rounding ||
             std::abs(l.pdf - picture.pdf(l.direction)) > 2e-6f * l.pdf;
      in_lanes.add(double(luminance(l.radiance) / l.pdf));
      alone.add(double(luminance(other.radiance) / other.pdf));
    }
    EXPECT_LE(off, kSamples / 20'000) << p.name;
    family.add(p.name, proof::equal_means_p_value(in_lanes, alone));
  }
  EXPECT_TRUE(family.passes());
}

}  // namespace sky_lanes_test
}  // namespace pvol::test
