// What a ray costs in a batch, and by one call each: flights and transmittances from places where
// paths scatter, in all directions.
//
//   batch_bench CLOUD [THICKNESS=64] [RAYS=200000]
//
// CLOUD is a grid, or a recipe, whose grid is made. THICKNESS is the mean optical thickness
// along its x axis. Times are those of one thread; quote the ratios, for the times themselves
// belong to one machine on one day.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <exception>
#include <limits>
#include <string>
#include <vector>

#include "pvol/embed.h"
#include "pvol/error.h"
#include "pvol/formats/cloud.h"
#include "pvol/math/direction.h"
#include "pvol/volume/batch.h"
#include "pvol/volume/facts.h"
#include "pvol/volume/make_volume.h"
#include "pvol/volume/phase.h"

namespace {

using namespace pvol;

constexpr int kRounds = 5;

Vec3d random_direction(Rng& rng) {
  const auto [u, v] = rng.uniform2();
  return Vec3d(turn({0, 0, 1}, 2 * u, v));
}

/// Rays that leave the collisions of isotropic walks from outside, in the order of the walks.
std::vector<Ray> find_rays(const Volume& v, std::size_t count) {
  const Box box = v.density.world_box;
  std::vector<Ray> all;
  for (std::uint64_t walk = 0; all.size() < count; ++walk) {
    Rng rng(1, walk, 0);
    const auto [a, b] = rng.uniform2();
    const Vec3d within = box.lo + box.extent() * Vec3d(double(a), double(b), double(rng.uniform()));
    const Vec3d d = random_direction(rng);
    Ray ray{within - d * (2 * length(box.extent())), d};
    for (int k = 0; k < 200 && all.size() < count; ++k) {
      const Flight f = sample_flight(v, ray, std::numeric_limits<double>::infinity(), rng);
      if (!f.collided) break;
      ray = {ray.at(f.t), random_direction(rng)};
      all.push_back(ray);
    }
  }
  return all;
}

/// Nanoseconds of processor time a ray, in the fastest round.
template <class Work>
double time_of(std::size_t rays, const Work& work) {
  const auto now = [] {
    timespec t{};
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
    return 1e9 * double(t.tv_sec) + double(t.tv_nsec);
  };
  double least = 1e300;
  for (int round = 0; round < kRounds; ++round) {
    const double start = now();
    work();
    least = std::min(least, now() - start);
  }
  return least / double(rays);
}

struct Times {
  double flights, analog, ratio;
  double left, through;  // means, for those who doubt that it is the same work
};

template <class T, class IsOne>
double mean_of(const std::vector<T>& all, const IsOne& value) {
  double sum = 0;
  for (const T v : all) sum += value(v);
  return sum / double(all.size());
}

template <class Fly, class Pass>
Times measure(std::size_t n, const Fly& fly, const Pass& pass) {
  std::vector<double> t(n);
  std::vector<float> a(n), r(n);
  Times times{};
  times.flights = time_of(n, [&] { fly(t); });
  times.analog = time_of(n, [&] { pass(Transmittance::analog, a); });
  times.ratio = time_of(n, [&] { pass(Transmittance::ratio, r); });
  times.left = mean_of(t, [](double x) { return std::isinf(x) ? 1.0 : 0.0; });
  times.through = mean_of(r, [](float x) { return double(x); });
  return times;
}

void print(const std::string& what, const Times& t, const Times& of) {
  std::printf("%-22s %8.1f %5.2fx %8.1f %5.2fx %8.1f %5.2fx   %.4f %.4f\n", what.c_str(), t.flights,
              of.flights / t.flights, t.analog, of.analog / t.analog, t.ratio, of.ratio / t.ratio,
              t.left, t.through);
}

int run_all(int argc, char** argv) {
  if (argc < 2 || argc > 4) {
    std::fprintf(stderr, "usage: batch_bench CLOUD [THICKNESS=64] [RAYS=200000]\n");
    return 2;
  }
  const double thickness = argc > 2 ? std::atof(argv[2]) : 64;
  const std::size_t n = argc > 3 ? std::size_t(std::atol(argv[3])) : 200'000;
  const formats::Cloud cloud = formats::load_cloud(argv[1]);
  const VolumeFacts of_unit = describe(cloud.grid(), 1, {});
  const Medium medium{.extinction = thickness / of_unit.mean_optical_thickness[0]};
  const Volume v = make_volume(cloud.grid(), cloud.pyramid, medium, {});
  const std::vector<Ray> rays = find_rays(v, n);
  std::printf(
      "%zu rays; ns a ray of flights, analog and ratio, beside one call a ray;\n"
      "shares that left, by flights and by ratio\n",
      n);

  const double far = std::numeric_limits<double>::infinity();
  const Times single = measure(
      n,
      [&](std::vector<double>& t) {
        for (std::size_t i = 0; i < n; ++i) {
          Rng rng(2, i, 0);
          t[i] = sample_flight(v, rays[i], far, rng).t;
        }
      },
      [&](Transmittance estimator, std::vector<float>& t) {
        for (std::size_t i = 0; i < n; ++i) {
          Rng rng(3, i, 0);
          t[i] = sample_transmittance(v, rays[i], far, rng, estimator);
        }
      });
  print("one call a ray", single, single);
  for (const KernelKind kernel : {KernelKind::scalar, KernelKind::avx2, KernelKind::avx512}) {
    try {
      const BatchField f(v, kernel);
      for (const std::size_t size : {std::size_t(64), std::size_t(1024), n}) {
        const auto in_parts = [&](const auto& sample) {
          for (std::size_t at = 0; at < n; at += size) {
            const char* const o = reinterpret_cast<const char*>(&rays[at].o);
            const RayBatch part{std::min(size, n - at),
                                {o, true, sizeof(Ray), sizeof(double)},
                                {o + sizeof(Vec3d), true, sizeof(Ray), sizeof(double)}};
            sample(part, at);
          }
        };
        const Times times = measure(
            n,
            [&](std::vector<double>& t) {
              in_parts([&](const RayBatch& part, std::size_t at) {
                (void)sample_flights(f, part, {.seed = 2, .first = at}, t.data() + at);
              });
            },
            [&](Transmittance estimator, std::vector<float>& t) {
              in_parts([&](const RayBatch& part, std::size_t at) {
                (void)sample_transmittances(f, part, {.seed = 3, .first = at}, estimator,
                                            t.data() + at);
              });
            });
        print(std::string(name(kernel)) + ", by " + std::to_string(size), times, single);
      }
    } catch (const Error& e) {
      std::printf("%s: %s\n", name(kernel), e.what());
    }
  }
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  try {
    return run_all(argc, argv);
  } catch (const std::exception& e) {
    std::fprintf(stderr, "batch_bench: error: %s\n", e.what());
    return 1;
  }
}
