// Micro-bounds by leaf, as files keep them, against those of a field.
#include "pvol/field/leaf_micro_bounds.h"

#include <gtest/gtest.h>

#include <cmath>

#include "pvol/error.h"
#include "pvol/volume/volume.h"
#include "support/bodies.h"
#include "support/cloud_scene.h"
#include "support/fields.h"
#include "support/messages.h"

namespace pvol::test {
namespace leaf_micro_bounds_test {

std::string error_of(const std::function<void()>& action) {
  try {
    action();
  } catch (const Error& e) {
    return e.what();
  }
  return {};
}

/// A grid with leaves of its own samples, leaves of one value and uniform cubes.
VoxelGrid mixed_grid() {
  VoxelGrid g = field("checkerboard").grid;
  g.tiles.push_back({{128, 128, 128}, 128, 0.5f});
  return g;
}

TEST(LeafMicroBounds, AreThoseOfTheFieldRearranged) {
  std::vector<VoxelGrid> grids{mixed_grid()};
  for (const Field& f : fields()) grids.push_back(f.grid);
  for (const VoxelGrid& g : grids) {
    const Pyramid p = build_pyramid(g);
    const FieldWithLinks f = build_field(g, p);
    for (const int edge : {1, 2}) {
      const LeafMicroBounds stored = build_leaf_micro_bounds(g, p, edge);
      EXPECT_EQ(stored.by_leaf.scales.size(), p.levels[0].size());
      EXPECT_EQ(arrange(stored, f.field, f.brick_of, p), build_micro_bounds(f.field, edge));
    }
  }
  EXPECT_TRUE(build_leaf_micro_bounds({}, {}, 2).by_leaf.scales.empty());
}

TEST(LeafMicroBounds, ThatDoNotHoldAreRefusedByLeaf) {
  const VoxelGrid g = field("gaussian").grid;
  const Pyramid p = build_pyramid(g);
  const FieldWithLinks f = build_field(g, p);
  const LeafMicroBounds good = build_leaf_micro_bounds(g, p, 2);
  const auto error = [&](const auto& change) {
    LeafMicroBounds bad = good;
    change(bad.by_leaf);
    return error_of([&] { (void)arrange(bad, f.field, f.brick_of, p); });
  };
  const std::size_t leaf = p.levels[0].size() / 2;
  EXPECT_NE(error([&](MicroBounds& m) {
              ++m.codes[leaf * 64 + 7].lo;
            }).find("leaf " + std::to_string(leaf) + " at ("),
            std::string::npos);
  EXPECT_NE(error([&](MicroBounds& m) { --m.codes[leaf * 64 + 63].hi; }).find("leaf"),
            std::string::npos);
  EXPECT_NE(error([&](MicroBounds& m) { m.scales[0].step = std::nanf(""); }).find("leaf 0"),
            std::string::npos);
  EXPECT_NE(error([](MicroBounds& m) { m.scales.pop_back(); }).find("leaves"), std::string::npos);
  EXPECT_NE(error([](MicroBounds& m) { m.codes.pop_back(); }).find("leaves"), std::string::npos);
  EXPECT_NE(error([](MicroBounds& m) { m.edge = 3; }).find("leaves"), std::string::npos);
}

TEST(LeafMicroBounds, AreUsedWhereTheSceneWantsThem) {
  const VoxelGrid g = mixed_grid();
  const Pyramid p = build_pyramid(g);
  const LeafMicroBounds stored = build_leaf_micro_bounds(g, p, 2);
  CloudScene s;
  s.medium.extinction = 1;
  for (const LookUp i : {LookUp::nearest, LookUp::trilinear}) {
    s.options.look_up = i;
    s.options.micro_bounds = MicroBoundsUse::edge_2;
    const Volume built = make_volume(g, p, s), taken = make_volume(g, p, s, &stored);
    EXPECT_FALSE(built.density.micro_stored);
    EXPECT_TRUE(taken.density.micro_stored);
    EXPECT_EQ(built.density.micro, taken.density.micro);
  }
  s.options.micro_bounds = MicroBoundsUse::edge_1;
  EXPECT_FALSE(make_volume(g, p, s, &stored).density.micro_stored);
  EXPECT_EQ(make_volume(g, p, s, &stored).density.micro.edge, 1);
  s.options.micro_bounds = MicroBoundsUse::none;
  EXPECT_FALSE(make_volume(g, p, s, &stored).density.micro_stored);
  s.options.micro_bounds = MicroBoundsUse::automatic;  // which wants codes
  EXPECT_EQ(make_volume(g, p, s, &stored).density.micro.edge, 0);
  s.options.micro_bounds = MicroBoundsUse::codes;
  EXPECT_FALSE(make_volume(g, p, s, &stored).density.micro_stored);
  EXPECT_NE(make_volume(g, p, s, &stored).density.codes, nullptr);
}

TEST(LeafMicroBounds, OfAnotherDensityMakeNoVolume) {
  const VoxelGrid g = field("gaussian").grid;
  const Pyramid p = build_pyramid(g);
  LeafMicroBounds stored = build_leaf_micro_bounds(g, p, 2);
  for (auto& scale : stored.by_leaf.scales) scale.base *= 1.01f;
  CloudScene s;
  s.medium.extinction = 1;
  s.options.micro_bounds = MicroBoundsUse::edge_2;
  EXPECT_TRUE(
      says(error_of([&] { (void)make_volume(g, p, s, &stored); }), "bounds.micro_bounds_leaf"));
}

}  // namespace leaf_micro_bounds_test
}  // namespace pvol::test
