// Fields whose samples stay in leaves or in an array, against their copies in bricks: the same
// links, the same samples, and the same look-ups to the last bit.
#include "pvol/field/shared_field.h"

#include <gtest/gtest.h>

#include "pvol/bounds/pyramid.h"
#include "pvol/error.h"
#include "pvol/field/micro_bounds.h"
#include "support/effort.h"
#include "support/fields.h"
#include "support/nasty_offset.h"

namespace pvol::test {
namespace shared_field_test {

/// The samples of a field as somebody else may have them: in any order of axes, apart, from the
/// last to the first.
struct Layout {
  const char* name;
  std::array<int, 3> order;  ///< axes from the slowest to the fastest
  int apart = 1;             ///< floats between neighbours along the fastest
  bool reversed = false;
};

struct OtherArray {
  std::vector<float> memory;
  DenseArray array;

  OtherArray(const Field& f, const Layout& layout) {
    const Vec3l size(f.size);
    Vec3l stride;
    std::int64_t step = layout.apart;
    for (int i = 2; i >= 0; --i) {
      const int axis = layout.order[std::size_t(i)];
      stride[axis] = step;
      step *= size[axis] + 1;  // rows that do not touch
    }
    memory.assign(std::size_t(step), -7.0f);
    std::int64_t first = 0;
    if (layout.reversed) {
      first = dot(size - Vec3l(1), stride);
      stride = -stride;
    }
    std::size_t n = 0;
    for (std::int64_t x = 0; x < size.x; ++x) {
      for (std::int64_t y = 0; y < size.y; ++y) {
        for (std::int64_t z = 0; z < size.z; ++z) {
          memory[std::size_t(first + dot(Vec3l(x, y, z), stride))] = f.samples[n++];
        }
      }
    }
    array = {memory.data() + first, f.size, f.origin, stride};
  }
};

template <class Samples>
void expect_same_look_ups(const Samples& samples, const float* brick, Rng& rng) {
  for (int i = 0; i < 200; ++i) {
    const auto at = [&] { return int(rng.uniform() * 8) + 8 * int(rng.uniform() * 100); };
    const LatticePoint p{Int4{at(), at(), at(), 0},
                         Float4{nasty_offset(rng), nasty_offset(rng), nasty_offset(rng), 0}};
    ASSERT_EQ(density_among<LookUp::trilinear>(samples, p),
              density_in_brick<LookUp::trilinear>(brick, p));
    ASSERT_EQ(density_among<LookUp::nearest>(samples, p),
              density_in_brick<LookUp::nearest>(brick, p));
  }
}

void expect_same(const WithLinks<SharedField>& shared, const FieldWithLinks& copied,
                 const std::string& name) {
  ASSERT_EQ(shared.brick_of, copied.brick_of) << name;
  ASSERT_EQ(shared.field.bricks(), copied.field.bricks()) << name;
  Rng rng(1, 2, 3);
  for (std::uint32_t b = 0; b < copied.field.bricks(); ++b) {
    SCOPED_TRACE(name + ", brick " + std::to_string(b));
    const float* const brick = copied.field.brick(b);
    shared.field.in_leaves() ? expect_same_look_ups(shared.field.leaves[b], brick, rng)
                             : expect_same_look_ups(shared.field.windows[b], brick, rng);
    if (::testing::Test::HasFatalFailure()) return;
  }
  for (const int edge : {1, 2}) {
    EXPECT_EQ(build_micro_bounds(shared.field, edge), build_micro_bounds(copied.field, edge))
        << name;
  }
}

TEST(SharedField, InLeavesIsTheCopy) {
  for (const Field& f : fields()) {
    const Pyramid pyramid = build_pyramid(f.grid);
    const auto shared = build_shared_field(f.grid, pyramid, {});
    EXPECT_TRUE(shared.field.in_leaves());
    expect_same(shared, build_field(f.grid, pyramid), f.name);
  }
}

TEST(SharedField, InAnArrayIsTheCopy) {
  const Layout layouts[] = {{"z fastest", {0, 1, 2}},
                            {"x fastest", {2, 1, 0}},
                            {"one of three channels", {0, 1, 2}, 3},
                            {"backwards", {1, 0, 2}, 1, true}};
  for (const Field& f : fields()) {
    if (!f.grid.tiles.empty()) continue;  // arrays have none
    const Pyramid pyramid = build_pyramid(f.grid);
    const FieldWithLinks copied = build_field(f.grid, pyramid);
    for (const Layout& layout : layouts) {
      const OtherArray other(f, layout);
      const auto shared = build_shared_field(f.grid, pyramid, {}, &other.array);
      EXPECT_FALSE(shared.field.in_leaves());
      expect_same(shared, copied, f.name + ", " + layout.name);
    }
  }
}

/// What is deep inside an array is read there, and what is at its faces is copied.
TEST(SharedField, ReadsWhereTheSamplesAre) {
  const Field f = make_field("full", {3, 5, -9}, {40, 41, 48},
                             [](Vec3i p) { return 1 + 0.01 * double((p.x * p.y + p.z) % 89); });
  const Pyramid pyramid = build_pyramid(f.grid);
  OtherArray other(f, {"z fastest", {0, 1, 2}});
  const auto in_array = build_shared_field(f.grid, pyramid, {}, &other.array);
  const float *const begin = other.memory.data(), *const end = begin + other.memory.size();
  std::size_t inside = 0;
  for (const ArraySamples& w : in_array.field.windows) {
    inside += begin <= w.first && w.first < end;
  }
  EXPECT_EQ(inside, 4 * 4 * 5) << "leaves whose 9^3 samples are all in the array";
  EXPECT_EQ(in_array.field.shared_bytes, 40u * 41 * 48 * 4);

  const auto in_leaves = build_shared_field(f.grid, pyramid, {});
  EXPECT_EQ(in_leaves.field.owner, f.grid.owner);
  EXPECT_EQ(in_leaves.field.shared_bytes, f.grid.bricks.size() * 2048);
  EXPECT_LT(in_leaves.field.bytes() - in_leaves.field.shared_bytes,
            in_leaves.field.shared_bytes / 16);
}

/// A huge tile has a million leaves at its faces: equal ones are one.
TEST(SharedField, KeepsFewBricksOfHugeTiles) {
  VoxelGrid grid;
  grid.tiles.push_back({{0, 0, 0}, proof::runs_all() ? 4096 : 2048, 0.5f});
  const Pyramid pyramid = build_pyramid(grid);
  const auto shared = build_shared_field(grid, pyramid, {});
  EXPECT_LT(shared.field.bricks(), 100u);
  expect_same(shared, build_field(grid, pyramid), "a huge tile");
}

TEST(SharedField, RefusesBoundsThatDoNotHold) {
  const Field& f = field("gaussian");
  Pyramid pyramid = build_pyramid(f.grid);
  pyramid.levels[0][pyramid.levels[0].size() / 2].hi *= 0.5f;
  EXPECT_THROW((void)build_shared_field(f.grid, pyramid, {}), Error);
  OtherArray other(f, {"z fastest", {0, 1, 2}});
  EXPECT_THROW((void)build_shared_field(f.grid, pyramid, {}, &other.array), Error);
}

}  // namespace shared_field_test
}  // namespace pvol::test
