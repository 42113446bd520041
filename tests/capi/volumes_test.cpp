// Volumes of the C API: what they are made of, what is said of them, and how commits end.
#include <gtest/gtest.h>
#include <sys/resource.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <limits>
#include <thread>

#include "capi/capi_fields.h"
#include "support/messages.h"

namespace pvol::test {
namespace volumes_test {

/// Whether both have the same density at many places, within the rounding of how they were given.
void expect_same_density(const api::Volume& a, const api::Volume& b, int n, float slack = 0) {
  Rng rng(1, 2, 3);
  float largest = 0;
  for (int i = 0; i < 2000; ++i) {
    const auto [x, y] = rng.uniform2();
    const api::Vec at = place_of(double(x) * n, double(y) * n, double(rng.uniform()) * n);
    ASSERT_NEAR(a.density(at), b.density(at), slack);
    largest = std::max(largest, a.density(at));
  }
  EXPECT_GT(largest, 0.3f);
}

template <class F>
api::Error error_of(const F& f) {
  try {
    f();
  } catch (const api::Error& e) {
    return e;
  }
  return {PVOL_OK, "no error"};
}

/// The code of the half nearest to v, of [0, 65504]; compilers have a type of it for some
/// processors only.
std::uint16_t half_of(float v) {
  const int exponent = v < 0x1p-14f ? -14 : std::ilogb(v);
  return std::uint16_t(std::lrint(std::ldexp(v, 10 - exponent)) + (exponent + 14) * 1024);
}

TEST(CapiVolume, ArraysOfAnyTypeAndStride) {
  const Smoke smoke;
  const auto n = std::size_t(smoke.n);
  const api::Volume packed = make_smoke(smoke);

  std::vector<double> turned(n * n * n * 2);  // x fastest, every second number
  for (std::size_t i = 0; i < n; ++i) {
    for (std::size_t j = 0; j < n; ++j) {
      for (std::size_t k = 0; k < n; ++k) {
        turned[2 * ((k * n + j) * n + i)] = double(smoke.values[(i * n + j) * n + k]);
      }
    }
  }
  pvol_array a = api::array(turned.data(), {{smoke.n, smoke.n, smoke.n}});
  a.stride[0] = 16, a.stride[1] = 16 * smoke.n, a.stride[2] = 16 * smoke.n * smoke.n;
  api::Volume doubles;
  doubles.set(PVOL_DENSITY, a).set_transform(PVOL_DENSITY, kPlacement).commit();
  expect_same_density(packed, doubles, smoke.n);

  std::vector<std::uint16_t> halves(smoke.values.size());
  std::transform(smoke.values.begin(), smoke.values.end(), halves.begin(), half_of);
  pvol_array h = smoke.array();
  h.values = halves.data(), h.type = PVOL_HALF;
  api::Volume small;
  small.set(PVOL_DENSITY, h).set_transform(PVOL_DENSITY, kPlacement).commit();
  expect_same_density(packed, small, smoke.n, 0.001f);
}

TEST(CapiVolume, BricksAndLeavesAreArraysInOtherWords) {
  const Smoke smoke;
  const api::Volume packed = make_smoke(smoke);

  pvol_bricks bricks{};
  bricks.hi[0] = bricks.hi[1] = bricks.hi[2] = smoke.n;
  bricks.user = const_cast<Smoke*>(&smoke);
  bricks.fill = [](void* user, const std::int32_t o[3], float* values) {
    const Smoke& s = *static_cast<const Smoke*>(user);
    for (int i = 0; i < 512; ++i)
      values[i] = s.at(o[0] + (i >> 6), o[1] + (i >> 3 & 7), o[2] + (i & 7), 0);
    return 0;
  };
  api::Volume filled;
  filled.set(PVOL_DENSITY, bricks).set_transform(PVOL_DENSITY, kPlacement).commit();
  expect_same_density(packed, filled, smoke.n);

  std::vector<std::array<float, 512>> samples(125);
  std::vector<pvol_leaf> leaves;
  for (std::int32_t b = 0; b < 125; ++b) {
    const std::int32_t o[3] = {b / 25 * 8, b / 5 % 5 * 8, b % 5 * 8};
    bricks.fill(bricks.user, o, samples[std::size_t(b)].data());
    leaves.push_back({samples[std::size_t(b)].data(), {o[0], o[1], o[2]}});
  }
  const pvol_tile tile{{128, 0, 0}, 128, 0.25f};
  pvol_leaves sparse{};
  sparse.leaves = leaves.data(), sparse.leaf_count = leaves.size();
  sparse.tiles = &tile, sparse.tile_count = 1;
  api::Volume of_leaves;
  of_leaves.set(PVOL_DENSITY, sparse).set_transform(PVOL_DENSITY, kPlacement).commit();
  expect_same_density(packed, of_leaves, smoke.n);
  EXPECT_EQ(of_leaves.density(place_of(200, 50.5, 50)), 0.25f);
  EXPECT_EQ(of_leaves.density(place_of(90, 50.5, 50)), 0);
}

TEST(CapiVolume, SaysWhatIsWrong) {
  const Smoke smoke;
  api::Volume v;
  std::string heard;
  pvol_set_error_function(
      v.get(), [](void* user, pvol_status, const char* m) { *static_cast<std::string*>(user) = m; },
      &heard);
  const auto expect = [&](const char* key, const auto& f) {
    const api::Error e = error_of(f);
    EXPECT_EQ(e.status(), PVOL_INVALID) << key;
    EXPECT_TRUE(says(e.what(), key));
    EXPECT_EQ(heard, e.what());
    EXPECT_STREQ(pvol_message(v.get()), e.what());
  };
  expect("capi.no_field", [&] { v.set(16, smoke.array()); });
  expect("capi.no_field_minus", [&] { v.clear(-1); });
  expect("capi.map_lattice_points", [&] { v.set_transform(PVOL_DENSITY, {}); });
  expect("capi.extinction_minus", [&] { v.set_extinction(-1); });
  expect("capi.shares_extinction", [&] { v.set_extinction_color({0.5f, 0.5f, 0.5f}); });
  const float nan = std::nanf("");
  expect("capi.shares_not_finite", [&] { v.set_extinction_color({1.0f, nan, 0.5f}); });
  expect("capi.no_interpolation", [&] { v.set_interpolation(pvol_interpolation(3)); });
  pvol_array a = smoke.array();
  a.reserved[1] = 1;
  expect("capi.reserved_member_not", [&] { v.set(PVOL_DENSITY, a); });
  const auto commit_with = [&](const pvol_array& array) {
    return [&v, array] { v.set(PVOL_DENSITY, array).commit(); };
  };
  a = smoke.array();
  a.values = nullptr;
  expect("capi.address_array_samples", commit_with(a));
  a = smoke.array();
  a.size[1] = 0;
  expect("capi.array_samples_expected", commit_with(a));
  a = smoke.array();
  a.type = pvol_type(3);
  expect("capi.no_type_samples", commit_with(a));
  Smoke bad;
  bad.values[41 * 40 + 7] = -1;
  expect("capi.sample_density_expected", commit_with(bad.array()));
  bad.values[41 * 40 + 7] = std::numeric_limits<float>::quiet_NaN();
  expect("capi.sample_density_expected", commit_with(bad.array()));
  std::vector<std::uint16_t> halves(smoke.values.size());
  halves[41 * 40 + 7] = 0xbc00;  // -1
  a = smoke.array();
  a.values = halves.data(), a.type = PVOL_HALF;
  expect("capi.sample_density_expected", commit_with(a));
  pvol_leaf leaf{smoke.values.data(), {0, 4, 0}};
  pvol_leaves leaves{};
  leaves.leaves = &leaf, leaves.leaf_count = 1;
  expect("capi.cube_samples_lies", [&] { v.set(PVOL_DENSITY, leaves).commit(); });
  pvol_tile tile{{0, 0, 0}, 16, 1};
  leaves = {};
  leaves.tiles = &tile, leaves.tile_count = 1;
  expect("capi.tile_edge", [&] { v.set(PVOL_DENSITY, leaves).commit(); });

  const std::vector<float> ones(512, 1.0f);
  const pvol_leaf twice[] = {{ones.data(), {0, 8, 0}}, {ones.data(), {0, 8, 0}}};
  leaves = {};
  leaves.leaves = twice, leaves.leaf_count = 2;
  expect("capi.cubes_overlap", [&] { v.set(PVOL_DENSITY, leaves).commit(); });
  const pvol_tile around{{0, 0, -128}, 128, 1};
  const pvol_leaf within{ones.data(), {0, 120, -8}};
  leaves.leaves = &within, leaves.leaf_count = 1;
  leaves.tiles = &around, leaves.tile_count = 1;
  expect("capi.cube_in_tile", [&] { v.set(PVOL_DENSITY, leaves).commit(); });

  v.set(PVOL_DENSITY, smoke.array()).commit();  // and all is well after that
  EXPECT_GT(v.density({20, 20, 20}), 0);
  EXPECT_EQ(pvol_commit(nullptr, nullptr), PVOL_INVALID);
  EXPECT_EQ(pvol_api_version(), PVOL_API_VERSION);
}

/// Of one number over and over: all bricks are occupied.
/// Rounding leaves an inverse to rows that depend on each other.
TEST(CapiVolume, RefusesMapsThatFlatten) {
  const Smoke smoke;
  api::Volume v;
  v.set(PVOL_DENSITY, smoke.array());
  v.set_transform(PVOL_DENSITY, {1, 2, 3, 0, 4, 5, 6, 0, 7, 8, 9, 0});
  EXPECT_TRUE(says(error_of([&] { v.commit(); }).what(), "capi.map_that_flattens"));
}

TEST(CapiVolume, RefusesWhatNoMemoryHolds) {
  constexpr std::int32_t kMany = 100'000;
  const std::vector<float> ones(kMany, 1.0f);
  pvol_array a = api::array(ones.data(), {{kMany, kMany, kMany}});
  a.stride[2] = sizeof(float);  // and none along the other axes
  api::Volume v;
  const api::Error e = error_of([&] { v.set(PVOL_DENSITY, a).commit(); });
  EXPECT_EQ(e.status(), PVOL_NO_MEMORY);
  EXPECT_TRUE(says(e.what(), "capi.needs_memory"));
}

#if !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
/// Bricks that a function fills, whose need shows as they are read.
TEST(CapiVolumeDeathTest, RefusesBricksWhenMemoryEnds) {
  GTEST_FLAG_SET(death_test_style, "threadsafe");
  const auto fill_up = [] {
    pvol_bricks bricks{};
    bricks.hi[0] = bricks.hi[1] = bricks.hi[2] = 100'000;
    bricks.fill = [](void*, const std::int32_t*, float* values) {
      values[0] = 1;
      return 0;
    };
    api::Volume v;
    v.set(PVOL_DENSITY, bricks);
    rlimit limit{};
    getrlimit(RLIMIT_AS, &limit);
    limit.rlim_cur = rlim_t(1) << 30;
    setrlimit(RLIMIT_AS, &limit);
    const api::Error e = error_of([&] { v.commit(); });
    std::exit(e.status() == PVOL_NO_MEMORY && says(e.what(), "capi.needs_memory") ? 0 : 1);
  };
  EXPECT_EXIT(fill_up(), testing::ExitedWithCode(0), "");
}
#endif

/// Before the commit, by the call that is given one.
TEST(CapiVolume, NullPointersAreRefused) {
  const Smoke smoke;
  api::Volume owner;
  owner.set(PVOL_DENSITY, smoke.array()).commit();
  pvol_volume* const v = owner.get();
  const auto expect_invalid = [&](pvol_status status, const char* key) {
    EXPECT_EQ(status, PVOL_INVALID) << key;
    EXPECT_TRUE(says(pvol_message(v), key));
  };
  pvol_array array = smoke.array();
  array.values = nullptr;
  expect_invalid(pvol_set_array(v, 0, &array), "capi.address_array_samples");
  expect_invalid(pvol_set_array(v, 0, nullptr), "capi.null_description");
  const pvol_bricks bricks{};
  expect_invalid(pvol_set_bricks(v, 0, &bricks), "capi.null_function");
  pvol_leaves leaves{};
  leaves.leaf_count = 1;
  expect_invalid(pvol_set_leaves(v, 0, &leaves), "capi.null_leaves");
  leaves = {};
  leaves.tile_count = 1;
  expect_invalid(pvol_set_leaves(v, 0, &leaves), "capi.null_tiles");
  expect_invalid(pvol_set_transform(v, 0, nullptr), "capi.null_map");
  expect_invalid(pvol_set_extinction_color(v, nullptr), "capi.null_shares");
  const int32_t corner[3] = {0, 0, 0};
  expect_invalid(pvol_set_changed(v, 0, nullptr, corner), "capi.null_low_corner");
  expect_invalid(pvol_set_changed(v, 0, corner, nullptr), "capi.null_high_corner");
  EXPECT_GT(owner.density({20, 20, 20}), 0) << "as it was";
}

TEST(CapiVolume, WithoutDensityEverythingGetsThrough) {
  api::Volume v;
  const pvol_ray ray = api::ray({0, 0, 0}, {1, 0, 0});
  api::Random random(1, 2, 3);
  double t;
  EXPECT_EQ(pvol_sample_flight(v.get(), &ray, &random, &t), PVOL_BAD_RAY) << "not committed";
  v.commit();
  EXPECT_FALSE(v.box());
  EXPECT_FALSE(v.flight(ray, random));
  EXPECT_EQ(v.transmittance(ray, PVOL_RATIO, random), 1);
  EXPECT_EQ(v.density({0, 0, 0}), 0);
  double depth;
  EXPECT_EQ(pvol_optical_depth(v.get(), &ray, &depth), 1);
  EXPECT_EQ(depth, 0);
}

TEST(CapiVolume, FurtherFieldsHavePlacesOfTheirOwn) {
  const Smoke smoke, heat(24, 1);
  api::Volume v;
  v.set(PVOL_DENSITY, smoke.array()).set(3, heat.array()).set_transform(3, kPlacement).commit();
  const api::Volume alone = make_smoke(heat);
  Rng rng(4, 5, 6);
  for (int i = 0; i < 500; ++i) {
    const auto [x, y] = rng.uniform2();
    const api::Vec at = place_of(double(x) * heat.n, double(y) * heat.n, 11.5);
    EXPECT_EQ(v.value(3, at), alone.density(at));
  }
  EXPECT_EQ(v.value(2, {5, 5, 5}), 0);
  v.clear(3).commit();
  EXPECT_EQ(v.value(3, place_of(12, 12, 12)), 0);
  EXPECT_GT(v.density({20, 20, 20}), 0) << "the density stays";
}

TEST(CapiVolume, BoxesAndRangesHoldTheDensity) {
  const Smoke smoke;
  for (const pvol_interpolation interpolation : {PVOL_TRILINEAR, PVOL_NEAREST, PVOL_TRICUBIC}) {
    api::Volume v;
    v.set(PVOL_DENSITY, smoke.array()).set_transform(PVOL_DENSITY, kPlacement).set_extinction(3);
    v.set_interpolation(interpolation).commit();
    const auto box = v.box();
    ASSERT_TRUE(box);
    Rng rng(7, 8, 9);
    double tightness = 0;
    for (int i = 0; i < 300; ++i) {
      const auto [x, y] = rng.uniform2();
      const api::Vec at = place_of(double(x) * smoke.n, double(y) * smoke.n, 17.3);
      const double half = 0.5 * double(rng.uniform());
      api::Vec lo = at, hi = at;
      for (std::size_t axis = 0; axis < 3; ++axis) lo[axis] -= half, hi[axis] += half;
      float range[2];
      ASSERT_EQ(pvol_extinction_range(v.get(), lo.data(), hi.data(), range), 1);
      float most = 0, least = 1e30f;
      for (int k = 0; k < 60; ++k) {
        api::Vec p = lo;
        for (std::size_t axis = 0; axis < 3; ++axis) {
          p[axis] += (hi[axis] - lo[axis]) * double(rng.uniform());
        }
        const float mu = v.extinction(p);
        ASSERT_LE(range[0], mu);
        ASSERT_GE(range[1], mu);
        most = std::max(most, mu), least = std::min(least, mu);
        const bool inside = p[0] >= box->first[0] && p[1] >= box->first[1] &&
                            p[2] >= box->first[2] && p[0] <= box->second[0] &&
                            p[1] <= box->second[1] && p[2] <= box->second[2];
        ASSERT_TRUE(inside || mu == 0);
      }
      tightness += double(range[1] - range[0]) / std::max(0.01, double(most - least)) / 300;
    }
    EXPECT_LT(tightness, 60) << "bounds are of use";
  }
}

/// Single voxels, whose leaves are empty but for a part.
TEST(CapiVolume, RangesOfSparksHoldThem) {
  constexpr std::int32_t kEdge = 32;
  std::vector<float> values(kEdge * kEdge * kEdge);
  for (std::size_t x = 5; x < kEdge; x += 8) {
    for (std::size_t y = 4; y < kEdge; y += 8) {
      for (std::size_t z = 6; z < kEdge; z += 8) values[(x * kEdge + y) * kEdge + z] = 1;
    }
  }
  api::Volume v;
  v.set(PVOL_DENSITY, api::array(values.data(), {{kEdge, kEdge, kEdge}}));
  v.set_extinction(5).commit();
  Rng rng(5, 6, 7);
  int met = 0;
  for (int i = 0; i < 20000; ++i) {
    api::Vec lo, hi, at;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      lo[axis] = double(rng.uniform()) * kEdge;
      hi[axis] = lo[axis] + 4 * double(rng.uniform());
      at[axis] = lo[axis] + (hi[axis] - lo[axis]) * double(rng.uniform());
    }
    float range[2];
    ASSERT_EQ(pvol_extinction_range(v.get(), lo.data(), hi.data(), range), 1);
    const float mu = v.extinction(at);
    ASSERT_LE(range[0], mu);
    ASSERT_GE(range[1], mu);
    met += mu > 0;
  }
  EXPECT_GT(met, 150);
}

TEST(CapiVolume, WithoutExtinctionLetsAllPass) {
  std::vector<float> values(16 * 16 * 16);
  values[(2 * 16 + 2) * 16 + 2] = 1;
  api::Volume v;
  v.set(PVOL_DENSITY, api::array(values.data(), {{16, 16, 16}})).set_extinction(0).commit();
  api::Random random(1, 2, 3);
  const pvol_ray ray = api::ray({-3, 2, 2}, {1, 0, 0});
  EXPECT_FALSE(v.flight(ray, random));
  EXPECT_EQ(v.transmittance(ray, PVOL_RATIO, random), 1);
  v.set_extinction(9).commit();
  EXPECT_LT(v.transmittance(ray, PVOL_EXACT, random), 0.001f);
}

TEST(CapiVolume, ShellsHoldTheDensity) {
  const Smoke smoke;
  api::Volume v;
  v.set(PVOL_DENSITY, smoke.array())
      .set_transform(PVOL_DENSITY, kPlacement)
      .set_shell(true)
      .commit();
  Rng rng(10, 11, 12);
  const api::Volume plain = make_smoke(smoke);
  double in_shell = 0, in_box = 0;
  for (int i = 0; i < 400; ++i) {
    const pvol_ray ray = random_ray(rng, smoke.n);
    pvol_span spans[8];
    const int count = pvol_shell_spans(v.get(), &ray, spans, 8);
    ASSERT_GE(count, 0);
    ASSERT_LE(count, 8);
    api::Walk walk = v.enter(ray);
    while (const auto s = walk.next()) {
      for (double t = s->t0; t < s->t1; t += 0.01) {
        if (walk.density(t) == 0) continue;
        bool held = false;
        for (int k = 0; k < count; ++k) held = held || (spans[k].t0 <= t && t <= spans[k].t1);
        ASSERT_TRUE(held) << "ray " << i << " at " << t;
      }
    }
    for (int k = 0; k < count; ++k) in_shell += spans[k].t1 - spans[k].t0;
    pvol_span box;  // of a volume without a shell
    if (pvol_shell_spans(plain.get(), &ray, &box, 1) == 1) in_box += box.t1 - box.t0;
  }
  EXPECT_LT(in_shell, 0.9 * in_box) << "the shell is smaller than the box";
  EXPECT_GT(in_shell, 0);
  const pvol_ray bad = api::ray({0, 0, 0}, {0, 0, 0});
  EXPECT_EQ(pvol_shell_spans(v.get(), &bad, nullptr, 0), PVOL_BAD_RAY);
}

TEST(CapiCommit, ChangesOfTheMediumKeepTheSamples) {
  const Smoke smoke;
  api::Volume v = make_smoke(smoke, 3);
  {
    Smoke gone(40, 2);
    v.set(PVOL_DENSITY, gone.array()).commit();
  }
  v.set_extinction(7).commit();  // without the samples, which are gone
  const api::Volume fresh = make_smoke(Smoke(40, 2), 7);
  expect_same_density(v, fresh, smoke.n);
  Rng rng(1, 1, 1);
  for (std::uint64_t i = 0; i < 200; ++i) {
    const pvol_ray ray = random_ray(rng, smoke.n);
    api::Random a(1, 2, i), b(1, 2, i);
    EXPECT_EQ(v.flight(ray, a), fresh.flight(ray, b));
    EXPECT_EQ(v.transmittance(ray, PVOL_RATIO, a), fresh.transmittance(ray, PVOL_RATIO, b));
  }
  v.set_interpolation(PVOL_NEAREST).commit();
  const api::Error e = error_of([&] { v.set_interpolation(PVOL_TRICUBIC).commit(); });
  EXPECT_TRUE(says(e.what(), "capi.interpolation_changed_tricubic"));
  EXPECT_GT(v.density(place_of(20, 20, 20)), 0) << "as it was";
}

TEST(CapiCommit, TellsHowFarItIsAndCanBeCancelled) {
  const Smoke smoke;
  api::Volume v = make_smoke(smoke);
  struct Watch {
    double last = -1;
    int calls = 0, most;
  } watch{-1, 0, 1000};
  pvol_commit_options o{};
  o.threads = 1;  // of several, that tell of what they read, one waits for none: calls would differ
  o.user = &watch;
  o.progress = [](void* user, double done) {
    auto& w = *static_cast<Watch*>(user);
    EXPECT_GE(done, w.last);
    w.last = done;
    return ++w.calls > w.most ? 1 : 0;
  };
  v.set(PVOL_DENSITY, smoke.array()).commit(o);
  EXPECT_EQ(watch.last, 1);
  ASSERT_GT(watch.calls, 4);

  const Smoke other(40, 1);
  for (int most = 0; most < watch.calls - 1; ++most) {
    Watch stopping{-1, 0, most};
    pvol_commit_options stop = o;
    stop.user = &stopping;
    v.set(PVOL_DENSITY, other.array());
    EXPECT_EQ(error_of([&] { v.commit(stop); }).status(), PVOL_CANCELLED) << most;
    expect_same_density(v, make_smoke(smoke), smoke.n);
  }
  v.commit();
  expect_same_density(v, make_smoke(other), other.n);
}

TEST(CapiCommit, IsCancelledFromAnotherThread) {
  // A brick's function waits until the commit was cancelled, and then some: the loop that calls it
  // ends before its parts are done.
  struct Bricks {
    api::Volume* volume;
    std::atomic<int> calls = 0;
  };
  api::Volume v;
  Bricks user{&v};
  pvol_bricks bricks{};
  bricks.hi[0] = bricks.hi[1] = bricks.hi[2] = 400;
  bricks.user = &user;
  bricks.fill = [](void* u, const std::int32_t*, float* values) {
    auto& b = *static_cast<Bricks*>(u);
    if (++b.calls == 10) pvol_cancel(b.volume->get());
    values[0] = 1;
    return 0;
  };
  v.set(PVOL_DENSITY, bricks);
  EXPECT_EQ(error_of([&] { v.commit(); }).status(), PVOL_CANCELLED);
  EXPECT_LT(user.calls, 50 * 50 * 50);
  pvol_cancel(v.get());  // no commit runs: nothing happens
  v.set(PVOL_DENSITY, Smoke().array()).commit();
  EXPECT_TRUE(v.box());

  bricks.fill = [](void*, const std::int32_t*, float*) { return 1; };
  v.set(PVOL_DENSITY, bricks);
  EXPECT_EQ(error_of([&] { v.commit(); }).status(), PVOL_CANCELLED) << "the function gave up";
}

/// Empty bricks, which end neither soon nor early by what they hold.
struct ManyBricks {
  api::Volume volume;
  int calls = 0, cancel_at = -1;
  std::vector<double> told;

  /// How a commit in one thread ends whose progress function gives up at `end`.
  pvol_status commit(std::int32_t x, double end) {
    pvol_bricks bricks{};
    bricks.hi[0] = x, bricks.hi[1] = bricks.hi[2] = 800;
    bricks.user = this;
    bricks.fill = [](void* user, const std::int32_t*, float*) {
      auto& b = *static_cast<ManyBricks*>(user);
      if (++b.calls == b.cancel_at) pvol_cancel(b.volume.get());
      return 0;
    };
    pvol_commit_options o{};
    o.threads = 1;
    std::pair both(this, end);
    o.user = &both;
    o.progress = [](void* user, double done) {
      auto& [b, last] = *static_cast<std::pair<ManyBricks*, double>*>(user);
      b->told.push_back(done);
      return done > last ? 1 : 0;
    };
    volume.set(PVOL_DENSITY, bricks);
    return pvol_commit(volume.get(), &o);
  }
};

TEST(CapiCommit, IsCancelledAtTheNextBrick) {
  ManyBricks bricks;
  bricks.cancel_at = 10;
  EXPECT_EQ(bricks.commit(20000, 1), PVOL_CANCELLED);
  EXPECT_EQ(bricks.calls, 10);
}

TEST(CapiCommit, TellsOfBricksAsTheyAreRead) {
  ManyBricks early;
  EXPECT_EQ(early.commit(20000, 0), PVOL_CANCELLED);
  EXPECT_LT(early.calls, 100'000) << "of 25 millions";
  EXPECT_EQ(early.told.size(), 2u) << "none after the one that cancelled";

  ManyBricks all;
  EXPECT_EQ(all.commit(80, 1), PVOL_OK);
  EXPECT_GT(std::count_if(all.told.begin(), all.told.end(), [](double d) { return d < 0.2; }), 50);
  EXPECT_TRUE(std::is_sorted(all.told.begin(), all.told.end()));
}

TEST(CapiCommit, WorksInTheArenaOrThreadsThatItIsGiven) {
  struct Threads {
    std::atomic<int> now = 0, most = 0;
  };
  const auto most_threads = [](pvol_commit_options o) {
    Threads threads;
    pvol_bricks bricks{};
    bricks.hi[0] = bricks.hi[1] = bricks.hi[2] = 128;
    bricks.user = &threads;
    bricks.fill = [](void* u, const std::int32_t*, float* values) {
      auto& t = *static_cast<Threads*>(u);
      const int now = ++t.now;
      int most = t.most;
      while (most < now && !t.most.compare_exchange_weak(most, now)) {
      }
      values[7] = 1;
      --t.now;
      return 0;
    };
    api::Volume v;
    v.set(PVOL_DENSITY, bricks).commit(o);
    EXPECT_TRUE(v.box());
    return threads.most.load();
  };
  pvol_commit_options one{};
  one.threads = 1;
  EXPECT_EQ(most_threads(one), 1);
  tbb::task_arena arena(1);
  pvol_commit_options in_arena{};
  in_arena.arena = &arena;
  EXPECT_EQ(most_threads(in_arena), 1);
  pvol_commit_options all{};
  all.threads = std::numeric_limits<int>::max();
  EXPECT_GE(most_threads(all), 1);
  pvol_commit_options bad{};
  bad.threads = -1;
  EXPECT_EQ(error_of([&] { api::Volume().commit(bad); }).status(), PVOL_INVALID);
}

TEST(CapiVolume, HandlesAreCounted) {
  pvol_volume* const v = pvol_new_volume();
  pvol_retain(v);
  pvol_release(v);
  EXPECT_EQ(pvol_commit(v, nullptr), PVOL_OK);
  pvol_release(v);
  pvol_release(nullptr);
  api::Volume a = make_smoke(Smoke()), b = a, c = std::move(a);
  a = b;
  b = api::Volume();
  EXPECT_GT(a.density(place_of(20, 20, 20)), 0);
  EXPECT_GT(c.bytes(), 40u * 40 * 40 * 4);
}

}  // namespace volumes_test
}  // namespace pvol::test
