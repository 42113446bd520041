// A renderer's plug-in in C++17, loaded when the renderer runs (host.c): pvol is linked into it.
// The manual is pvol/pvol.hpp.
#include <array>
#include <random>
#include <vector>

#include "pvol/pvol.hpp"

namespace {

/// A medium as some renderer wants it, with random numbers of that renderer.
class Medium {
 public:
  explicit Medium(int n) {
    std::vector<float> samples(std::size_t(n) * std::size_t(n) * std::size_t(n), 0.5f);
    volume_.set(PVOL_DENSITY, pvol::api::array(samples.data(), {{n, n, n}}));
    volume_.set_extinction(0.25).commit();
  }

  /// Whether a ray through the middle gets through.
  template <class Numbers>
  bool passes(Numbers& numbers) const {
    pvol::api::Random random = pvol::api::Random::of(numbers);
    return !volume_.flight(pvol::api::ray({-1, 10.25, 9.75}, {1, 0, 0}), random);
  }

 private:
  pvol::api::Volume volume_;
};

}  // namespace

/// The share of `rays` that get through 20 voxels and the ramps at their ends.
extern "C" double transmittance_of_plugin(int rays) {
  const Medium medium(20);
  std::mt19937_64 engine(7);
  std::uniform_real_distribution<double> uniform(0, 1);
  auto numbers = [&] { return uniform(engine); };
  int passed = 0;
  for (int i = 0; i < rays; ++i) passed += medium.passes(numbers);
  return double(passed) / rays;
}

/// Whether pvol's errors are caught on its side of the API.
extern "C" int plugin_catches_errors(void) {
  try {
    pvol::api::Volume().set_extinction(-1);
  } catch (const pvol::api::Error& e) {
    return e.status() == PVOL_INVALID;
  }
  return 0;
}
