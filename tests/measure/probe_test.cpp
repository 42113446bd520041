// What a probe of a cloud says that its paths cost.
#include "pvol/measure/probe.h"

#include <gtest/gtest.h>

#include "support/small_cloud.h"

namespace pvol::test {
namespace probe_test {

TEST(Probe, CostsAreCountsForEachCollision) {
  measure::ProbeOptions options;
  options.width = 16;
  const measure::Probe p = measure::probe(cloud().grid, build_pyramid(cloud().grid), options);
  for (const measure::PathCosts* c : {&p.delta, &p.decomposition, &p.squeezed}) {
    const Tally& paths = c->counts.path;
    const auto collisions = double(c->counts.collisions);
    ASSERT_GT(collisions, 0);
    EXPECT_DOUBLE_EQ(c->lookups.value, double(paths.lookups) / collisions);
    EXPECT_DOUBLE_EQ(c->tentative, 1 + double(paths.null_collisions) / collisions);
    EXPECT_DOUBLE_EQ(c->bounds_tests, double(paths.bounds_tests) / collisions);
    EXPECT_DOUBLE_EQ(c->segments, double(paths.segments) / collisions);
  }
}

}  // namespace probe_test
}  // namespace pvol::test
