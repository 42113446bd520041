// Volumes that are committed again, frame by frame: those that are told what changed are the same
// as those that are made anew, to the bit of every flight, and read no more than they must.
#include <gtest/gtest.h>

#include <atomic>

#include "capi/capi_fields.h"

namespace pvol::test {
namespace updates_test {

constexpr std::int32_t kEdge = 72;

struct Box3 {
  std::array<std::int32_t, 3> lo, hi;
};

/// A field of n^3 samples that changes in boxes.
struct Changing {
  std::vector<float> values = std::vector<float>(std::size_t(kEdge) * kEdge * kEdge);

  float& at(int i, int j, int k) {
    return values[(std::size_t(i) * kEdge + std::size_t(j)) * kEdge + std::size_t(k)];
  }
  template <class F>
  void fill(const Box3& box, const F& f) {
    for (int i = box.lo[0]; i < box.hi[0]; ++i) {
      for (int j = box.lo[1]; j < box.hi[1]; ++j) {
        for (int k = box.lo[2]; k < box.hi[2]; ++k) at(i, j, k) = f(i, j, k);
      }
    }
  }
  [[nodiscard]] pvol_array array() const {
    return api::array(values.data(), {{kEdge, kEdge, kEdge}});
  }
};

[[nodiscard]] api::Volume make_fresh(const Changing& field, pvol_interpolation interpolation) {
  api::Volume v;
  v.set(PVOL_DENSITY, field.array()).set_transform(PVOL_DENSITY, kPlacement).set_extinction(4);
  v.set_interpolation(interpolation).commit();
  return v;
}

void expect_all_same(const api::Volume& a, const api::Volume& b, const char* frame) {
  expect_same(a, b, kEdge, frame);
  expect_same_batches(a, b, kEdge, frame);
}

TEST(CapiUpdate, IsTheVolumeMadeAnew) {
  for (const pvol_interpolation interpolation : {PVOL_TRILINEAR, PVOL_NEAREST}) {
    Changing field;
    const auto ball = [](double cx, double cy, double cz, double r, float scale) {
      return [=](int i, int j, int k) {
        const double d = std::hypot(i - cx, j - cy, k - cz) / r;
        return d < 1 ? scale * float(1 - d) : 0.0f;
      };
    };
    field.fill({{20, 20, 20}, {50, 50, 50}}, ball(35, 35, 35, 14, 1));
    api::Volume v = make_fresh(field, interpolation);
    struct Frame {
      const char* name;
      std::vector<Box3> boxes;
      std::function<void(Changing&)> change;
    };
    const Frame frames[] = {
        {"some samples change",
         {{{30, 31, 33}, {39, 37, 41}}},
         [](Changing& f) {
           f.fill({{30, 31, 33}, {39, 37, 41}},
                  [](int i, int j, int) { return 0.2f + 0.01f * float(i * j % 7); });
         }},
        {"one sample",
         {{{40, 40, 40}, {41, 41, 41}}},
         [](Changing& f) { f.at(40, 40, 40) = 0.77f; }},
        {"the largest rises",
         {{{32, 32, 32}, {33, 33, 33}}},
         [](Changing& f) { f.at(32, 32, 32) = 3; }},
        {"the largest falls",
         {{{32, 32, 32}, {33, 33, 33}}},
         [](Changing& f) { f.at(32, 32, 32) = 0.1f; }},
        {"it grows beyond its box",
         {{{2, 3, 5}, {30, 28, 27}}, {{50, 50, 50}, {72, 70, 71}}},
         [&](Changing& f) {
           f.fill({{2, 3, 5}, {30, 28, 27}}, ball(16, 15, 16, 11, 0.5f));
           f.fill({{50, 50, 50}, {72, 70, 71}}, ball(60, 60, 60, 9, 0.7f));
         }},
        {"nothing changes", {{{0, 0, 0}, {8, 8, 8}}}, [](Changing&) {}},
        {"boxes that overlap",
         {{{30, 30, 30}, {45, 45, 45}}, {{38, 38, 38}, {52, 52, 52}}, {{38, 38, 38}, {40, 40, 40}}},
         [&](Changing& f) {
           f.fill({{30, 30, 30}, {45, 45, 45}}, ball(37, 37, 37, 8, 0.9f));
           f.fill({{38, 38, 38}, {52, 52, 52}}, ball(44, 45, 46, 6, 0.8f));
         }},
        {"a part goes",
         {{{50, 50, 50}, {72, 70, 71}}},
         [](Changing& f) {
           f.fill({{50, 50, 50}, {72, 70, 71}}, [](int, int, int) { return 0.0f; });
         }},
        {"all goes",
         {{{0, 0, 0}, {kEdge, kEdge, kEdge}}},
         [](Changing& f) { std::fill(f.values.begin(), f.values.end(), 0.0f); }},
        {"and comes again",
         {{{10, 60, 0}, {20, 72, 9}}},
         [&](Changing& f) {
           f.fill({{10, 60, 0}, {20, 72, 9}}, ball(15, 66, 4, 5, 0.6f));
         }},
    };
    for (const Frame& frame : frames) {
      frame.change(field);
      v.set(PVOL_DENSITY, field.array());
      for (const Box3& box : frame.boxes) v.set_changed(PVOL_DENSITY, box.lo, box.hi);
      v.commit();
      expect_all_same(v, make_fresh(field, interpolation), frame.name);
    }
  }
}

TEST(CapiUpdate, ManyFramesKeepToTheirMemory) {
  Changing field;
  Rng rng(9, 9, 9);
  api::Volume v;
  std::uint64_t most = 0;
  for (int frame = 0; frame < 60; ++frame) {
    Box3 box{};
    for (std::size_t axis = 0; axis < 3; ++axis) {
      box.lo[axis] = std::int32_t(double(rng.uniform()) * (kEdge - 24));
      box.hi[axis] = box.lo[axis] + 24;
    }
    const bool clear = frame % 3 == 2;
    field.fill(box, [&](int, int, int) { return clear ? 0.0f : rng.uniform(); });
    v.set(PVOL_DENSITY, field.array()).set_transform(PVOL_DENSITY, kPlacement).set_extinction(4);
    if (frame > 0) v.set_changed(PVOL_DENSITY, box.lo, box.hi);
    v.commit();
    if (frame % 10 == 9) expect_all_same(v, make_fresh(field, PVOL_TRILINEAR), "many frames");
    most = std::max(most, v.bytes());
  }
  api::Volume full;
  std::fill(field.values.begin(), field.values.end(), 1.0f);
  for (float& x : field.values) x = rng.uniform();
  full.set(PVOL_DENSITY, field.array()).commit();
  EXPECT_LT(most, 2 * full.bytes());
}

TEST(CapiUpdate, ReadsWhatChangedAlone) {
  std::atomic<int> calls = 0;
  pvol_bricks bricks{};
  bricks.hi[0] = bricks.hi[1] = bricks.hi[2] = 160;
  bricks.user = &calls;
  bricks.fill = [](void* user, const std::int32_t* o, float* values) {
    ++*static_cast<std::atomic<int>*>(user);
    for (int i = 0; i < 512; ++i) values[i] = 0.1f + 0.001f * float((o[0] + o[1] + o[2] + i) % 97);
    return 0;
  };
  api::Volume v;
  v.set(PVOL_DENSITY, bricks).commit();
  EXPECT_EQ(calls.exchange(0), 8000);
  v.set(PVOL_DENSITY, bricks).set_changed(PVOL_DENSITY, {{80, 80, 80}}, {{88, 88, 88}}).commit();
  EXPECT_LE(calls.exchange(0), 64) << "one brick and those around it";
  v.set(PVOL_DENSITY, bricks).commit();
  EXPECT_EQ(calls.exchange(0), 8000) << "without the promise all may have changed";
  EXPECT_THROW(v.set_changed(PVOL_DENSITY, {{8, 8, 8}}, {{8, 9, 9}}), api::Error);
  // The samples may have changed where they are, but nobody set them.
  v.set_changed(PVOL_DENSITY, {{8, 8, 8}}, {{9, 9, 9}});
  EXPECT_THROW(v.commit(), api::Error);
  v.set(PVOL_DENSITY, bricks).set_changed(PVOL_DENSITY, {{8, 8, 8}}, {{9, 9, 9}}).commit();
  EXPECT_LE(calls.exchange(0), 8064);
}

TEST(CapiUpdate, ThatIsCancelledLeavesTheVolumeAsItWas) {
  Changing field;
  field.fill({{20, 20, 20}, {50, 50, 50}},
             [](int i, int j, int k) { return 0.01f * float((i * j + k) % 83); });
  api::Volume v = make_fresh(field, PVOL_TRILINEAR);
  const api::Volume before = make_fresh(field, PVOL_TRILINEAR);
  Changing next = field;
  const Box3 box{{5, 5, 5}, {60, 60, 60}};
  next.fill(box, [](int i, int j, int k) { return 0.02f * float((i + j * k) % 53); });
  pvol_commit_options o{};
  struct Count {
    int left;
  } count{2};
  o.user = &count;
  o.progress = [](void* user, double) { return static_cast<Count*>(user)->left-- > 0 ? 0 : 1; };
  for (int round = 0; round < 3; ++round) {
    count.left = 1 + round;
    v.set(PVOL_DENSITY, next.array()).set_changed(PVOL_DENSITY, box.lo, box.hi);
    EXPECT_THROW(v.commit(o), api::Error);
    expect_all_same(v, before, "cancelled");
  }
  v.commit();
  expect_all_same(v, make_fresh(next, PVOL_TRILINEAR), "at last");
}

TEST(CapiUpdate, OfADensityThatWentIsNone) {
  Changing field;
  field.fill({{20, 20, 20}, {50, 50, 50}}, [](int, int, int) { return 1.0f; });
  api::Volume v = make_fresh(field, PVOL_TRILINEAR);
  v.set(PVOL_DENSITY, field.array()).set_changed(PVOL_DENSITY, {{0, 0, 0}}, {{8, 8, 8}});
  v.clear(PVOL_DENSITY).commit();
  EXPECT_FALSE(v.box());
  v.set_changed(PVOL_DENSITY, {{0, 0, 0}}, {{8, 8, 8}}).commit();
  EXPECT_FALSE(v.box());
  v.set(PVOL_DENSITY, field.array()).commit();
  expect_all_same(v, make_fresh(field, PVOL_TRILINEAR), "back again");
}

TEST(CapiUpdate, OfLeavesAndOfWhatCannotBeUpdatedIsRight) {
  Changing field;
  field.fill({{0, 0, 0}, {32, 32, 32}},
             [](int i, int j, int k) { return 0.01f * float((i * j + k) % 83); });
  std::vector<std::array<float, 512>> samples(64);
  std::vector<pvol_leaf> leaves;
  for (std::int32_t b = 0; b < 64; ++b) {
    leaves.push_back({samples[std::size_t(b)].data(), {b / 16 * 8, b / 4 % 4 * 8, b % 4 * 8}});
  }
  const auto copy = [&] {
    for (std::size_t b = 0; b < 64; ++b) {
      const std::int32_t* const o = leaves[b].origin;
      for (int i = 0; i < 512; ++i) {
        samples[b][std::size_t(i)] = field.at(o[0] + (i >> 6), o[1] + (i >> 3 & 7), o[2] + (i & 7));
      }
    }
  };
  copy();
  pvol_leaves all{};
  all.leaves = leaves.data(), all.leaf_count = leaves.size();
  for (const pvol_interpolation interpolation : {PVOL_TRILINEAR, PVOL_TRICUBIC}) {
    api::Volume v;
    v.set(PVOL_DENSITY, all).set_transform(PVOL_DENSITY, kPlacement).set_extinction(4);
    v.set_interpolation(interpolation).commit();
    field.fill({{9, 9, 9}, {20, 21, 22}}, [](int i, int j, int) { return 0.02f * float(i + j); });
    copy();
    v.set(PVOL_DENSITY, all).set_changed(PVOL_DENSITY, {{9, 9, 9}}, {{20, 21, 22}}).commit();
    expect_all_same(v, make_fresh(field, interpolation), "leaves");
  }
}

}  // namespace updates_test
}  // namespace pvol::test
