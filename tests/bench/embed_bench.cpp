// pvol inside another renderer: one path tracer, and the medium that it asks is a NanoVDB grid
// behind a grid of majorants, or a volume of pvol by one of its APIs: path by path in C++ and in
// C, or as a wavefront whose rays are batches.
//
//   embed_bench CLOUD [OPTIONS]     (see kUsage)
//
// The light, a sun and a sky, and the camera are those of samples/peer_scene.toml. All media see
// the same cloud along the same camera rays, in turn, on one thread. Fails where their mean
// radiances differ by more than four standard errors.
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <exception>
#include <string>
#include <vector>

#include "embed_capi.h"
#include "embed_media.h"
#include "embed_paths.h"
#include "embed_waves.h"
#include "pvol/bounds/leaf_index.h"
#include "pvol/error.h"
#include "pvol/formats/cloud.h"
#include "pvol/volume/facts.h"
#include "pvol/volume/make_volume.h"

namespace {

using namespace pvol;
using namespace pvol::bench;

constexpr const char* kUsage =
    "usage: embed_bench CLOUD [--thickness X] [--g X] [--paths N] [--rounds N] [--analog]\n"
    "                   [--micro-bounds auto|none|2|1|codes] [--only TEXT]\n"
    "CLOUD            samples with trilinear look-ups; .vdb, .pvol, ...\n"
    "--thickness 78   mean optical thickness along x\n"
    "--g 0.877        mean cosine of the phase function, Henyey and Greenstein's\n"
    "--paths 20000    of each medium in each round\n"
    "--rounds 7       times are medians over them\n"
    "--analog         shadow rays are free flights; ratio tracking without\n"
    "--only TEXT      media whose names contain it, for profilers; the first is the baseline\n";

struct Wishes {
  std::string cloud, only;
  double thickness = 78, g = 0.877;
  int paths = 20000, rounds = 7;
  bool analog = false;
  MicroBoundsUse micro_bounds = MicroBoundsUse::automatic;
};

/// Throws std::runtime_error.
Wishes read(int argc, char** argv) {
  Wishes w;
  for (int i = 1; i < argc; ++i) {
    const std::string key = argv[i];
    if (key == "--analog") {
      w.analog = true;
    } else if (!key.starts_with("--") && w.cloud.empty()) {
      w.cloud = key;
    } else if (++i == argc) {
      throw std::runtime_error(kUsage);
    } else if (key == "--thickness") {
      w.thickness = std::atof(argv[i]);
    } else if (key == "--only") {
      w.only = argv[i];
    } else if (key == "--g") {
      w.g = std::atof(argv[i]);
    } else if (key == "--paths") {
      w.paths = std::atoi(argv[i]);
    } else if (key == "--rounds") {
      w.rounds = std::atoi(argv[i]);
    } else if (const auto use = find_named<MicroBoundsUse>(argv[i]);
               use && key == "--micro-bounds") {
      w.micro_bounds = *use;
    } else {
      throw std::runtime_error(kUsage);
    }
  }
  if (w.cloud.empty() || w.paths < 2 || w.rounds < 1) throw std::runtime_error(kUsage);
  return w;
}

void print_paths(const std::vector<Row>& rows) {
  std::printf("%-34s %19s %9s %9s %9s %9s %7s\n", "medium", "radiance", "look-ups", "segments",
              "bounds", "ns/path", "ratio");
  for (const Row& r : rows) {
    std::printf("%-34s %8.5f +- %.5f ", r.name.c_str(), r.radiance.mean(), r.radiance.error());
    if (r.counted) {
      const auto each = [&](std::uint64_t n) { return double(n) / double(r.counted); };
      std::printf("%9.1f %9.1f %9.1f ", each(r.tally.lookups), each(r.tally.segments),
                  each(r.tally.bounds_tests));
    } else {
      std::printf("%9s %9s %9s ", "-", "-", "-");
    }
    std::printf("%9.0f %7.3f\n", median(r.ns), median(ratios(r.ns, rows.front().ns)));
  }
}

bool agree(const std::vector<Row>& rows) {
  bool ok = true;
  for (const Row& r : rows) {
    const double d = r.radiance.mean() - rows.front().radiance.mean();
    const double e = std::hypot(r.radiance.error(), rows.front().radiance.error());
    if (&r == &rows.front() || std::abs(d) <= 4 * e) continue;
    std::fprintf(stderr, "embed_bench: %s differs from %s by %.1f standard errors\n",
                 r.name.c_str(), rows.front().name.c_str(), d / e);
    ok = false;
  }
  return ok;
}

/// Of a volume's density, without samples that are the grid's.
void print_bytes(const char* name, const Volume& v, double theirs) {
  const VolumeField& f = v.density;
  const std::uint64_t index = f.leaves ? f.leaves->bytes() : 0;
  const std::uint64_t samples = f.value_bytes() - f.shared_bytes();
  const std::uint64_t all = samples + f.octree.bytes() + f.squeeze_bytes() + index;
  const auto mb = [](std::uint64_t bytes) { return double(bytes) / 1e6; };
  std::printf(
      "bytes: %s %.2f MB: samples %.2f, octree %.2f, index %.2f, micro-bounds %.2f; "
      "ratio %.3f\n",
      name, mb(all), mb(samples), mb(f.octree.bytes()), mb(index), mb(f.squeeze_bytes()),
      double(all) / theirs);
}

void print_bytes(const NanoMedium& nano, const Volume& volume, const Volume& shared) {
  const double grid = double(nano.handle.size()) / 1e6, all = double(nano.bytes()) / 1e6;
  std::printf("bytes: NanoVDB %.2f MB and majorants %.2f\n", grid, all - grid);
  print_bytes("pvol", volume, all * 1e6);
  print_bytes("pvol beside samples that are shared", shared, all * 1e6);
}

template <bool kAnalog>
void add_volume(Bench& bench, const Volume& volume, const std::string& name) {
  bench.add_paths(name + " segments, extinction_at",
                  [&] { return SegmentsAndPoints<kAnalog>{volume}; });
  visit_field(volume, [&](const auto& field) {
    using Field = std::decay_t<decltype(field)>;
    if constexpr (kIsTrilinear<Field>) {
      bench.add_paths(name + " segments, look-ups at t", [&volume, field] {
        return SegmentsAndField<kAnalog, Field>{volume, field};
      });
      bench.add_paths(name + " the same from cursors", [&volume, field] {
        return CursorsAndField<kAnalog, Field>{volume, field};
      });
    }
  });
  bench.add_paths(name + " whole flights", [&] { return WholeFlights<kAnalog>{volume}; });
}

template <bool kAnalog>
void add_media(Bench& bench, const NanoMedium& nano, const Volume& volume, const Volume& shared) {
  bench.add_paths("NanoVDB accessor, majorants 64^3", [&] {
    return NanoPath<NanoAccessor, kAnalog>{nano, nano.grid().getAccessor()};
  });
  bench.add_paths("NanoVDB tree, majorants 64^3", [&] {
    return NanoPath<const NanoTree&, kAnalog>{nano, nano.grid().tree()};
  });
  add_volume<kAnalog>(bench, volume, "pvol");
  add_volume<kAnalog>(bench, shared, "shared");
}

/// For each kernel that the machine has.
std::vector<BatchField> batch_fields(const Volume& volume) {
  std::vector<BatchField> all;
  for (const KernelKind kernel : {KernelKind::avx2, KernelKind::avx512}) {
    try {
      all.emplace_back(volume, kernel);
    } catch (const Error& e) {
      std::printf("no batches by %s: %s\n", name(kernel), e.what());
    }
  }
  return all;
}

void add_waves(Bench& bench, const std::vector<BatchField>& fields, bool analog) {
  const Transmittance estimator = analog ? Transmittance::analog : Transmittance::ratio;
  for (const BatchField& f : fields) {
    const auto trace = [&bench, &f, estimator](const Round& round, Mean& mean) {
      const BatchRays rays{f, estimator, 2 + std::uint64_t(round.number)};
      trace_waves(bench.setting, rays, round, mean);
    };
    bench.rows.push_back(
        {.name = std::string("pvol batches, ") + name(f.kernel()), .trace = trace});
  }
}

template <bool kAnalog>
void add_capi(Bench& bench, const pvol_volume* capi) {
  bench.add_paths("C API, segments and look-ups",
                  [capi] { return CapiSegmentsMedium<kAnalog>{capi}; });
  bench.add_paths("C API, one call a ray", [capi] { return CapiCalls<kAnalog>{capi}; });
  bench.add_paths("C API, walks that go on", [capi] { return CapiWalks<kAnalog>{capi}; });
  const auto trace = [&bench, capi](const Round& round, Mean& mean) {
    const CapiBatchRays rays{capi, CapiCalls<kAnalog>::kEstimator, 2 + std::uint64_t(round.number)};
    trace_waves(bench.setting, rays, round, mean);
  };
  bench.rows.push_back({.name = "C API, batches", .trace = trace});
}

int run(const Wishes& w) {
  const formats::Cloud cloud = formats::load_cloud(w.cloud);
  const double unit = describe(cloud.grid(), 1, {}).mean_optical_thickness[0];
  const Medium medium{.extinction = w.thickness / unit};
  const Volume volume =
      make_volume(cloud.grid(), cloud.pyramid, medium, {.micro_bounds = w.micro_bounds});
  const NanoMedium nano = make_nano_medium(cloud.grid(), volume.density.scale);
  const Setting setting = make_setting(volume.density.world_box, w.g);
  const Volume shared =
      make_volume(cloud.grid(), cloud.pyramid, medium,
                  {.micro_bounds = w.micro_bounds, .samples = SampleStorage::shared});
  print_bytes(nano, volume, shared);

  const CapiVolume capi = make_capi_volume(cloud.grid(), medium.extinction);
  const std::vector<BatchField> batches = batch_fields(volume);

  Bench bench{setting, w.paths, w.rounds};
  w.analog ? add_media<true>(bench, nano, volume, shared)
           : add_media<false>(bench, nano, volume, shared);
  add_waves(bench, batches, w.analog);
  w.analog ? add_capi<true>(bench, capi.get()) : add_capi<false>(bench, capi.get());
  std::erase_if(bench.rows, [&](const Row& r) { return r.name.find(w.only) == r.name.npos; });
  if (bench.rows.empty()) throw std::runtime_error("no medium is called " + w.only);
  bench.run();
  print_paths(bench.rows);
  if (!bench.places.empty()) print_points(nano, volume, bench.places, w.rounds);
  return agree(bench.rows) ? 0 : 1;
}

}  // namespace

int main(int argc, char** argv) {
  try {
    return run(read(argc, argv));
  } catch (const std::exception& e) {
    std::fprintf(stderr, "embed_bench: error: %s\n", e.what());
    return 1;
  }
}
