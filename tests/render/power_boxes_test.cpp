#include "render/light/emission/power_boxes.h"

#include <gtest/gtest.h>

#include <cmath>

#include "pvol/math/direction.h"
#include "support/effort.h"
#include "support/fields.h"

namespace pvol::test {
namespace power_boxes_test {

using detail::BoxDensities;
using detail::BoxLine;
using detail::EmissionSource;
using detail::PowerBoxes;
using detail::SeenBoxes;

/// Boxes of any sizes around the origin, some of which meet, the power of some 0.
SeenBoxes random_boxes(Rng& rng, int count) {
  SeenBoxes boxes;
  for (int i = 0; i < count; ++i) {
    const auto [x, y, z, power] = rng.uniform4();
    const auto [a, b, c, dark] = rng.uniform4();
    const Vec3f lo = (Vec3f(x, y, z) - Vec3f(0.5f)) * 60.0f;
    boxes.add(lo, lo + Vec3f(1 + 9 * a, 1 + 9 * b, 1 + 9 * c), dark < 0.1f ? 0 : power);
  }
  boxes.fill_register();
  return boxes;
}

/// The same by definition, in doubles: t from the line's begin.
std::array<double, 2> densities(const SeenBoxes& boxes, Vec3d place, Vec3d direction) {
  double weights = 0, along_line = 0;
  for (std::size_t i = 0; i < boxes.size(); ++i) {
    double t0 = 0, t1 = 1e30, squared = 0, radius = 0, volume = 1;
    for (int axis = 0; axis < 3; ++axis) {
      const auto k = std::size_t(axis);
      const double lo = double(boxes.lo[k][i]), hi = double(boxes.hi[k][i]);
      const double a = (lo - place[axis]) / direction[axis],
                   b = (hi - place[axis]) / direction[axis];
      t0 = std::max(t0, std::min(a, b)), t1 = std::min(t1, std::max(a, b));
      const double away = place[axis] - (lo + hi) / 2;
      squared += away * away, radius += (hi - lo) * (hi - lo) / 4, volume *= hi - lo;
    }
    const double weight = double(boxes.power[i]) / std::max(squared, radius);
    weights += weight;
    if (t0 < t1) along_line += weight * (t1 * t1 * t1 - t0 * t0 * t0) / (3 * volume);
  }
  return {weights, along_line};
}

TEST(BoxKernels, GiveTheSameBitsAndTheDefinition) {
  const std::vector<detail::BoxKernel> kernels = detail::box_kernels();
  Rng rng(1, 2, 3);
  int met = 0;
  for (int round = 0; round < 300; ++round) {
    const SeenBoxes boxes = random_boxes(rng, 1 + round % 128);
    const auto [x, y, z, spare] = rng.uniform4();
    const double distance = round % 5 == 0 ? 1e5 : round % 3 == 0 ? 5 : 100;
    const Vec3d place = direction_on_spiral(round, 300) * distance;
    const Vec3d target = Vec3d(double(x), double(y), double(z)) * 60.0 - Vec3d(30.0);
    const Vec3d direction = normalize(target - place);
    const double before = std::max(-dot(place, direction), 0.0);
    const BoxLine line{Vec3f(place + direction * before), Vec3f(direction), float(before)};

    const BoxDensities first = kernels.front().find_densities(boxes, Vec3f(place), line);
    std::vector<float> weights(boxes.size());
    kernels.front().find_weights(boxes, Vec3f(place), weights.data());
    for (const detail::BoxKernel& other : kernels) {
      const BoxDensities found = other.find_densities(boxes, Vec3f(place), line);
      EXPECT_EQ(found.weights, first.weights);
      EXPECT_EQ(found.along_line, first.along_line);
      std::vector<float> again(boxes.size());
      other.find_weights(boxes, Vec3f(place), again.data());
      EXPECT_EQ(again, weights);
    }
    const auto [sum, along_line] = densities(boxes, place, direction);
    EXPECT_NEAR(double(first.weights), sum, 1e-5 * sum);
    double each = 0;
    for (const float w : weights) each += double(w);
    EXPECT_NEAR(each, sum, 1e-5 * sum);
    // Of a line that cuts a corner few digits are left.
    EXPECT_NEAR(double(first.along_line), along_line, 1e-3 * along_line + 1e-5 * sum * distance);
    met += along_line > 0;
  }
  EXPECT_GT(met, 100);
}

/// A line in the plane of a face, or along an edge, is within the box or not, and no other number.
TEST(BoxKernels, TakeLinesAlongFaces) {
  SeenBoxes boxes;
  boxes.add(Vec3f(-1), Vec3f(1), 2);
  boxes.fill_register();
  for (const detail::BoxKernel& kernel : detail::box_kernels()) {
    const auto along = [&](Vec3f nearest) {
      return kernel.find_densities(boxes, Vec3f(-5, 0, 0), {nearest, Vec3f(1, 0, 0), 5}).along_line;
    };
    const float through = along(Vec3f(0));
    EXPECT_NEAR(through, 2.0 / 25 * (6 * 6 * 6 - 4 * 4 * 4) / 3 / 8, 1e-5);
    EXPECT_EQ(along(Vec3f(0, 1.001f, 0)), 0);
    for (const Vec3f face : {Vec3f(0, 1, 0), Vec3f(0, -1, 0), Vec3f(0, 1, -1)}) {
      const float found = along(face);
      EXPECT_TRUE(found >= 0 && found <= through) << found;  // part of it where it rounds
    }
  }
}

/// What PowerBoxes have of a field, and what the field has by its samples.
TEST(PowerBoxes, ArePowerfulWhereTheFieldIs) {
  for (const char* const name : {"gaussian", "tiles_8"}) {
    const Field& f = field(name);
    const Volume v = make_test_volume(f, 1, {});
    const PowerBoxes boxes(EmissionSource{.field = &v.density, .of_depth = Rgb(1.0f)});
    ASSERT_FALSE(boxes.dark()) << name;
    // Their power is the integral of the field, by 64 points of each leaf.
    EXPECT_NEAR(boxes.power(), f.sum, 0.1 * f.sum) << name;
    // Points are drawn where the field has samples, as often as these are large: halves of it.
    const double middle = boxes.bounds().centre().x;
    double below = 0;
    for (int x = 0; x < f.size.x; ++x) {
      for (int y = 0; y < f.size.y; ++y) {
        for (int z = 0; z < f.size.z; ++z) {
          const double at = double(x + f.origin.x - v.density.octree.origin.x);
          const double value = double(f.at(f.origin + Vec3i(x, y, z)));
          below += value * std::clamp(middle - at + 0.5, 0.0, 1.0) / f.sum;
        }
      }
    }
    Rng rng(proof::seeded(3), 1, 1);
    constexpr int kPoints = 20'000;
    int found = 0;
    for (int i = 0; i < kPoints; ++i) found += boxes.sample(rng).x < middle;
    EXPECT_NEAR(found / double(kPoints), below, 0.05) << name;
  }
}

/// Densities of directions stay right however far the place is: those of samples are what the solid
/// angle of the boxes leads to expect.
TEST(PowerBoxes, KeepTheirDigitsFarAway) {
  const Volume v = make_test_volume(field("gaussian"), 1, {});
  const PowerBoxes boxes(EmissionSource{.field = &v.density, .of_depth = Rgb(1.0f)});
  const Vec3d way = normalize(Vec3d{0.6, -0.3, 0.74});
  double near = 0;
  for (const double distance : {1e3, 1e5, 1e7}) {
    const Vec3d place = boxes.bounds().centre() + way * distance;
    // The pdf times the squared distance, of parallel rays through the middle, does not depend on
    // the distance.
    const double density = boxes.pdf({place, way * -1.0}, 1) / (distance * distance);
    if (near == 0) near = density;
    EXPECT_GT(density, 0);
    EXPECT_NEAR(density / near, 1, 0.05) << distance;
  }
}

}  // namespace power_boxes_test
}  // namespace pvol::test
