// The C API over samples that stay with the caller: the same as copies of them, in less memory.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstring>

#include "capi/capi_fields.h"
#include "support/messages.h"

namespace pvol::test {
namespace sharing_test {

constexpr std::int32_t kEdge = 64;

[[nodiscard]] api::Volume commit(api::Volume v, pvol_interpolation interpolation = PVOL_TRILINEAR) {
  v.set_transform(PVOL_DENSITY, kPlacement).set_extinction(3);
  v.set_interpolation(interpolation).commit();
  return v;
}

/// A smoke in leaves of a tree, and a tile beside it.
struct Leaves {
  static constexpr std::size_t kAlong = kEdge / 8;
  std::vector<std::array<float, 512>> samples =
      std::vector<std::array<float, 512>>(kAlong * kAlong * kAlong);
  std::vector<pvol_leaf> leaves;
  pvol_tile tile{{0, 0, 128}, 128, 0.25f};

  explicit Leaves(const Smoke& smoke) {
    for (std::size_t b = 0; b < samples.size(); ++b) {
      const auto o = [&](std::size_t i) { return std::int32_t(i % kAlong * 8); };
      leaves.push_back({samples[b].data(), {o(b / kAlong / kAlong), o(b / kAlong), o(b)}});
      for (std::size_t i = 0; i < 512; ++i) {
        const std::size_t x = std::size_t(leaves[b].origin[0]) + (i >> 6),
                          y = std::size_t(leaves[b].origin[1]) + (i >> 3 & 7),
                          z = std::size_t(leaves[b].origin[2]) + (i & 7);
        samples[b][i] = smoke.values[(x * kEdge + y) * kEdge + z];
      }
    }
  }
  [[nodiscard]] pvol_leaves all(std::size_t tiles) const {
    pvol_leaves l{};
    l.leaves = leaves.data(), l.leaf_count = leaves.size();
    l.tiles = &tile, l.tile_count = tiles;
    return l;
  }
};

[[nodiscard]] bool is_positive(float v) { return v > 0; }

/// Rays as the caller follows them, segment by segment and by random numbers of its own.
void expect_same_walks(const api::Volume& a, const api::Volume& b) {
  Rng rng(3, 3, 3);
  for (int i = 0; i < 200; ++i) {
    const pvol_ray ray = random_ray(rng, kEdge);
    api::Walk x(a.get(), ray), y(b.get(), ray);
    while (const auto s = x.next()) {
      const auto other = y.next();
      ASSERT_TRUE(other && s->t0 == other->t0 && s->t1 == other->t1);
      ASSERT_EQ(s->hi, other->hi);
      const double t = 0.5 * (s->t0 + s->t1);
      ASSERT_EQ(x.extinction(t), y.extinction(t));
      ASSERT_EQ(x.exceeds(t, 0.5f * s->hi), y.exceeds(t, 0.5f * s->hi));
    }
    ASSERT_FALSE(y.next());
    ASSERT_EQ(api::Walk(a.get(), ray).optical_depth(), api::Walk(b.get(), ray).optical_depth());
    Rng mine(7, 7, std::uint64_t(i)), theirs = mine;
    const auto next = [](Rng& r) { return [&r] { return double(r.uniform()); }; };
    auto p = next(mine), q = next(theirs);
    api::Random u = api::Random::of(p), v = api::Random::of(q);
    ASSERT_EQ(a.flight(ray, u), b.flight(ray, v));
    ASSERT_EQ(a.transmittance(ray, PVOL_RATIO, u), b.transmittance(ray, PVOL_RATIO, v));
  }
}

TEST(CapiSharing, OfAnArrayIsTheCopy) {
  const Smoke smoke(kEdge);
  std::vector<float> pairs;  // every other float, z first
  for (std::size_t k = 0; k < kEdge; ++k) {
    for (std::size_t j = 0; j < kEdge; ++j) {
      for (std::size_t i = 0; i < kEdge; ++i) {
        pairs.insert(pairs.end(), {smoke.values[(i * kEdge + j) * kEdge + k], -1});
      }
    }
  }
  pvol_array strange = smoke.array();
  strange.values = pairs.data();
  strange.stride[0] = 8, strange.stride[1] = 8 * kEdge, strange.stride[2] = 8 * kEdge * kEdge;
  for (const pvol_interpolation interpolation : {PVOL_TRILINEAR, PVOL_NEAREST}) {
    const auto copied = commit(api::Volume().set(PVOL_DENSITY, smoke.array()), interpolation);
    for (const pvol_array& array : {smoke.array(), strange}) {
      const auto shared = commit(api::Volume().share(PVOL_DENSITY, array), interpolation);
      expect_same(shared, copied, kEdge, "an array");
      expect_same_walks(shared, copied);
      EXPECT_LT(shared.bytes(), copied.bytes() * 2 / 3);
    }
  }
}

TEST(CapiSharing, OfLeavesIsTheCopy) {
  const Leaves leaves{Smoke(kEdge)};
  for (const std::size_t tiles : {0u, 1u}) {
    const auto copied = commit(api::Volume().set(PVOL_DENSITY, leaves.all(tiles)));
    const auto shared = commit(api::Volume().share(PVOL_DENSITY, leaves.all(tiles)));
    expect_same(shared, copied, kEdge, "leaves");
    expect_same_walks(shared, copied);
    // Less by most of what copies of the samples take, 9^3 of each leaf with density.
    const auto filled = std::count_if(
        leaves.samples.begin(), leaves.samples.end(),
        [](const auto& values) { return std::any_of(values.begin(), values.end(), is_positive); });
    EXPECT_LT(shared.bytes() + 2 * 729 * sizeof(float) * std::size_t(filled) / 3, copied.bytes());
  }
}

/// The samples are read where they are: what changes there is seen at once.
TEST(CapiSharing, GoesRayByRayInBatches) {
  const Smoke smoke(kEdge);
  const auto v = commit(api::Volume().share(PVOL_DENSITY, smoke.array()));
  Rng rng(2, 2, 2);
  std::vector<double> o, d, t(100);
  std::vector<pvol_ray> all;
  for (std::size_t i = 0; i < t.size(); ++i) {
    all.push_back(random_ray(rng, kEdge));
    o.insert(o.end(), all[i].o, all[i].o + 3), d.insert(d.end(), all[i].d, all[i].d + 3);
  }
  pvol_rays rays{};
  rays.count = t.size();
  rays.origins = api::vectors(o.data()), rays.directions = api::vectors(d.data());
  pvol_streams streams{};
  streams.seed = 8;
  EXPECT_EQ(v.flights(rays, streams, {t.data(), t.size()}), 0u);
  for (std::size_t i = 0; i < t.size(); ++i) {
    api::Random own(8, i, 0);
    EXPECT_EQ(t[i], v.flight(all[i], own).value_or(api::kInfinity));
  }
}

TEST(CapiSharing, CopiesNothing) {
  Leaves leaves{Smoke(kEdge)};
  const auto v = commit(api::Volume().share(PVOL_DENSITY, leaves.all(0)));
  const api::Vec middle = place_of(30, 30, 30);
  const float before = v.density(middle);
  EXPECT_GT(before, 0);
  for (auto& block : leaves.samples) {
    for (float& x : block) x *= 0.5f;
  }
  EXPECT_EQ(v.density(middle), 0.5f * before);
}

TEST(CapiSharing, FrameByFrame) {
  Smoke smoke(kEdge);
  api::Volume v = commit(api::Volume().share(PVOL_DENSITY, smoke.array()));
  v.set_extinction(5).commit();
  expect_same(v, make_smoke(smoke, 5), kEdge, "another extinction");
  std::fill_n(smoke.values.begin() + kEdge * kEdge * 30, kEdge * kEdge, 0.3f);
  v.share(PVOL_DENSITY, smoke.array());
  v.set_changed(PVOL_DENSITY, {{30, 0, 0}}, {{31, kEdge, kEdge}}).commit();
  expect_same(v, make_smoke(smoke, 5), kEdge, "samples that changed where they are");
  v.set(PVOL_DENSITY, smoke.array());
  v.set_changed(PVOL_DENSITY, {{0, 0, 0}}, {{1, 1, 1}}).commit();
  const Smoke kept = smoke;
  std::fill(smoke.values.begin(), smoke.values.end(), 0.0f);
  expect_same(v, make_smoke(kept, 5), kEdge, "copied from now on");
  v.share(PVOL_DENSITY, kept.array());
  v.set_changed(PVOL_DENSITY, {{0, 0, 0}}, {{1, 1, 1}}).commit();
  expect_same(v, make_smoke(kept, 5), kEdge, "and shared again");
}

TEST(CapiSharing, IsRefusedWhereItDoesNotGo) {
  const Smoke smoke(16);
  const auto message = [&](const auto& set) {
    api::Volume v;
    try {
      set(v);
    } catch (const api::Error& e) {
      return std::string(e.what());
    }
    return std::string();
  };
  const auto refused = [&](pvol_array a) {
    return message([&](api::Volume& v) { v.share(PVOL_DENSITY, a).commit(); });
  };
  const std::vector<double> doubles(16 * 16 * 16, 1.0);
  EXPECT_NE(refused(api::array(doubles.data(), {{16, 16, 16}})).find("PVOL_FLOAT"),
            std::string::npos);
  pvol_array packed = smoke.array();
  packed.stride[0] = 16 * 16 * 5, packed.stride[1] = 16 * 5, packed.stride[2] = 5;
  std::vector<char> bytes(16 * 16 * 16 * 5 + 4);
  packed.values = bytes.data();
  EXPECT_TRUE(says(refused(packed), "capi.arrays_whose_address"));
  EXPECT_NE(message([&](api::Volume& v) { v.share(3, smoke.array()); }).find("field 0"),
            std::string::npos);
  EXPECT_NE(message([&](api::Volume& v) {
              v.share(PVOL_DENSITY, smoke.array()).set_interpolation(PVOL_TRICUBIC).commit();
            }).find("tricubic"),
            std::string::npos);
}

}  // namespace sharing_test
}  // namespace pvol::test
