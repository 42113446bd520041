// What one look-up, one step of the walk and one tentative collision cost: our bricks against a
// NanoVDB grid with a persistent accessor, and the terms of the walk's cost model (THEORY.md,
// T2.1).
//
//   lookup_bench CLOUD [Google Benchmark options]
#include <benchmark/benchmark.h>
#include <nanovdb/NanoVDB.h>
#include <nanovdb/util/SampleFromVoxels.h>

#include <cstdio>
#include <exception>
#include <vector>

#include "nano_grid.h"
#include "pvol/formats/cloud.h"
#include "pvol/math/direction.h"
#include "pvol/track/flight.h"
#include "pvol/volume/facts.h"
#include "pvol/volume/make_volume.h"
#include "pvol/volume/phase.h"
#include "pvol/volume/volume.h"

namespace {

using namespace pvol;

/// Places where a path looks the density up: collisions of random walks through the cloud.
struct Place {
  LatticePoint at;
  LeafHandle leaf;
};

struct Bench {
  formats::Cloud cloud;
  Volume volume;
  std::vector<Place> coherent;   // in the order of the walks
  std::vector<Place> scattered;  // shuffled
  bench::NanoHandle nano;
};

Vec3f random_direction(Rng& rng) {
  const auto [u, v] = rng.uniform2();
  return turn({0, 0, 1}, 2 * u, v);
}

/// Follows isotropic walks from random entries until there are enough places.
void find_places(Bench& b, std::size_t count) {
  const Octree& tree = b.volume.density.octree;
  Rng rng(1, 0, 0);
  const BrickExtinction<LookUp::trilinear> extinction{b.volume.density.bricks(), tree,
                                                      b.volume.density.scale};
  NoTally none;
  while (b.coherent.size() < count) {
    const auto [x, y] = rng.uniform2();
    const Vec3d size = tree.support().extent();
    Cursor cursor = make_cursor(
        tree, tree.support().lo + size * Vec3d(double(x), double(y), double(rng.uniform())));
    for (int k = 0; k < 1000 && b.coherent.size() < count; ++k) {
      Walk walk(tree, cursor, widen(random_direction(rng)));
      LeafHandle leaf = 0;
      const PlainField field{[&](const Segment& s, const LatticePoint& p) {
        leaf = s.leaf;
        return extinction(s, p);
      }};
      const Flight hit = free_flight<Tracker::delta>(walk, field, rng, none);
      if (!hit.collided) break;
      const LatticePoint p = walk.point(hit.t);
      b.coherent.push_back({p, leaf});
      cursor = walk.stop_at(p);
    }
  }
  b.scattered = b.coherent;
  for (std::size_t i = b.scattered.size(); i > 1; --i) {
    std::swap(b.scattered[i - 1], b.scattered[std::size_t(rng.block().lo % i)]);
  }
}

/// Calls `lookup(place)` over all places, over and over.
template <class Lookup>
void run(benchmark::State& state, const std::vector<Place>& places, const Lookup& lookup) {
  std::size_t i = 0;
  float sum = 0;
  for (auto _ : state) {
    sum += lookup(places[i]);
    i = i + 1 < places.size() ? i + 1 : 0;
  }
  benchmark::DoNotOptimize(sum);
}

void add_lookups(const Bench& b, const std::string& order, const std::vector<Place>& places) {
  const Volume& v = b.volume;
  const auto add = [&](const std::string& name, const auto& lookup) {
    benchmark::RegisterBenchmark((name + "/" + order).c_str(),
                                 [&, lookup](benchmark::State& s) { run(s, places, lookup); });
  };
  add("bricks/from_segment", [&v](const Place& p) {
    return density<LookUp::trilinear>(v.density.bricks(), v.density.octree, p.leaf, p.at);
  });
  add("bricks/from_root", [&v](const Place& p) {
    return density<LookUp::trilinear>(v.density.bricks(), v.density.octree, Octree::kNodeBit, p.at);
  });
  const auto* nano = b.nano.grid<float>();
  const Vec3f origin(v.density.octree.origin);
  add("nanovdb/persistent_accessor", [nano, origin](const Place& p) {
    static thread_local auto accessor = nano->getAccessor();
    const auto sampler = nanovdb::createSampler<1>(accessor);
    return sampler(nanovdb::Vec3f(origin.x + float(p.at.cell[0]) + p.at.frac[0],
                                  origin.y + float(p.at.cell[1]) + p.at.frac[1],
                                  origin.z + float(p.at.cell[2]) + p.at.frac[2]));
  });
  add("nanovdb/bare_tree", [nano, origin](const Place& p) {
    const auto sampler = nanovdb::createSampler<1>(nano->tree());
    return sampler(nanovdb::Vec3f(origin.x + float(p.at.cell[0]) + p.at.frac[0],
                                  origin.y + float(p.at.cell[1]) + p.at.frac[1],
                                  origin.z + float(p.at.cell[2]) + p.at.frac[2]));
  });
}

/// Segments of rays through the whole cloud; time is per segment.
void walk_bench(benchmark::State& state, const Octree& tree) {
  Rng rng(2, 0, 0);
  const Vec3d size = tree.support().extent();
  std::int64_t segments = 0;
  for (auto _ : state) {
    const auto [x, y] = rng.uniform2();
    Cursor cursor = make_cursor(tree, tree.support().lo + size * Vec3d(double(x), double(y), 0.5));
    Walk walk(tree, cursor, widen(random_direction(rng)));
    while (const auto s = walk.next()) {
      ++segments;
      benchmark::DoNotOptimize(s->hi);
    }
  }
  state.counters["per_segment"] = benchmark::Counter(
      double(segments), benchmark::Counter::kIsRate | benchmark::Counter::kInvert);
}

void tentative_bench(benchmark::State& state) {
  Rng rng(3, 0, 0);
  float sum = 0;
  for (auto _ : state) {
    const Rng::Tentative t = rng.tentative();
    sum += t.depth * t.u;
  }
  benchmark::DoNotOptimize(sum);
}

int run_all(int argc, char** argv) {
  benchmark::Initialize(&argc, argv);
  if (argc != 2) {
    std::fprintf(stderr, "usage: lookup_bench CLOUD [--benchmark_... options]\n");
    return 2;
  }
  Bench b;
  b.cloud = formats::load_cloud(argv[1]);
  const VolumeFacts of_unit = describe(b.cloud.grid(), 1, {});
  const Medium medium{.extinction = 64 / of_unit.mean_optical_thickness[0]};
  b.volume = make_volume(b.cloud.grid(), b.cloud.pyramid, medium, {});
  b.nano = bench::make_nano(b.cloud.grid());
  find_places(b, 1 << 20);

  add_lookups(b, "along_paths", b.coherent);
  add_lookups(b, "shuffled", b.scattered);
  benchmark::RegisterBenchmark(
      "walk/ray", [&](benchmark::State& s) { walk_bench(s, b.volume.density.octree); });
  benchmark::RegisterBenchmark("tentative/random_numbers", tentative_bench);
  benchmark::RunSpecifiedBenchmarks();
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  try {
    return run_all(argc, argv);
  } catch (const std::exception& e) {
    std::fprintf(stderr, "lookup_bench: error: %s\n", e.what());
    return 1;
  }
}
