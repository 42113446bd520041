// A path tracer in C++17 with a sampler of its own, over pvol's flights: path_tracer CLOUD.pvol
// REFERENCE.txt renders samples/peer_scene.toml, with medium.g=0.5, and compares it with the
// reference, a picture of the same scene by pvol-render: blocks of 4 x 4 pixels, and the whole, agree
// within their noise.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <iterator>
#include <string>
#include <vector>

#include "pvol/pvol.hpp"
#include "pvol/pvol_file.h"

namespace {

using Vec = pvol::api::Vec;
constexpr double kPi = 3.141592653589793;

Vec operator*(double s, const Vec& v) { return {s * v[0], s * v[1], s * v[2]}; }
Vec operator+(const Vec& a, const Vec& b) { return {a[0] + b[0], a[1] + b[1], a[2] + b[2]}; }
double dot(const Vec& a, const Vec& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }
Vec cross(const Vec& a, const Vec& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}
Vec unit(const Vec& v) { return 1 / std::sqrt(dot(v, v)) * v; }

/// Samples of a pixel: the first dimensions are stratified over them by the roots of a plastic
/// number (a Kronecker sequence) from an offset of the pixel, the others are random.
class Sampler {
 public:
  Sampler(int pixel, int sample)
      : sample_(sample), state_(std::uint64_t(pixel) * 0x9e3779b97f4a7c15u + 1) {
    for (double& o : offset_) o = random();
    state_ += std::uint64_t(sample) * 0xd1342543de82ef95u;
    (void)random();
  }
  double operator()() {
    if (dimension_ >= kStratified) return random();
    const double x = offset_[dimension_] + sample_ * kSteps[dimension_];
    ++dimension_;
    return x - std::floor(x);
  }

 private:
  static constexpr std::size_t kStratified = 4;
  static constexpr double kSteps[kStratified] = {0.8566748838545029, 0.7338918566271260,
                                                 0.6287067210378087, 0.5385972572236101};
  int sample_;
  std::size_t dimension_ = 0;
  std::uint64_t state_;
  std::array<double, kStratified> offset_{};

  double random() {  // SplitMix64
    std::uint64_t x = state_ += 0x9e3779b97f4a7c15u;
    x = (x ^ (x >> 30)) * 0xbf58476d1ce4e5b9u;
    x = (x ^ (x >> 27)) * 0x94d049bb133111ebu;
    return double((x ^ (x >> 31)) >> 11) * 0x1p-53;
  }
};

constexpr double kG = 0.5, kAlbedo = 0.999, kSky = 0.5, kIrradiance = 3, kExtinction = 200;

double phase(double cosine) {
  const double d = 1 + kG * kG - 2 * kG * cosine;
  return (1 - kG * kG) / (4 * kPi * d * std::sqrt(d));
}

Vec scatter(const Vec& from, double u, double v) {
  const double s = (1 - kG * kG) / (1 - kG + 2 * kG * u), c = (1 + kG * kG - s * s) / (2 * kG);
  const double r = std::sqrt(std::max(0.0, 1 - c * c)), phi = 2 * kPi * v;
  const Vec x = unit(cross(from, std::abs(from[0]) < 0.9 ? Vec{1, 0, 0} : Vec{0, 1, 0}));
  return unit(c * from + r * std::cos(phi) * x + r * std::sin(phi) * cross(from, x));
}

double radiance(const pvol::api::Volume& cloud, const Vec& eye, Vec direction, Sampler& numbers) {
  const Vec sun = unit({0.6, 0.8, 0.35});
  auto random = pvol::api::Random::of(numbers);
  pvol::api::Walk walk = cloud.enter(pvol::api::ray(eye, direction));
  double light = 0, weight = 1;
  while (const auto t = walk.flight(random)) {
    weight *= kAlbedo;
    pvol::api::Walk shadow = walk;  // starts where the path is
    if (shadow.resume(*t, sun) && !shadow.flight(random)) {
      light += weight * kIrradiance * phase(dot(direction, sun));
    }
    if (weight < 0.5) {
      if (numbers() >= weight) return light;
      weight = 1;
    }
    direction = scatter(direction, numbers(), numbers());
    if (!walk.resume(*t, direction)) return light;
  }
  return light + weight * kSky;
}

/// Pixels by rows from the top, of text as oiiotool --dumpdata prints it.
std::vector<double> read_red(const char* path) {
  std::vector<double> red;
  std::ifstream file(path);
  for (std::string line; std::getline(file, line);) {
    int x = 0, y = 0;
    double value = 0;
    if (std::sscanf(line.c_str(), " Pixel (%d, %d): %lf", &x, &y, &value) == 3) {
      red.push_back(value);
    }
  }
  return red;
}

struct Mean {
  double sum = 0, squares = 0, expected = 0;
  int count = 0;
  double deviation() const {  // in standard errors; the reference has little noise of its own
    const double mean = sum / count, variance = (squares / count - mean * mean) / count;
    return (mean - expected) / std::sqrt(1.15 * variance + 1e-12);
  }
};

}  // namespace

int main(int count, char** arguments) {
  if (count != 3) return 2;
  const std::vector<double> reference = read_red(arguments[2]);
  const int n = int(std::lround(std::sqrt(double(reference.size())))), kSamples = 128;
  if (n == 0 || std::size_t(n) * std::size_t(n) != reference.size() || n % 4 != 0) return 2;
  std::ifstream file(arguments[1], std::ios::binary);
  const std::vector<char> bytes{std::istreambuf_iterator<char>(file), {}};
  pvol::api::Volume cloud;
  if (pvol_read_bytes(cloud.get(), bytes.data(), bytes.size()) != PVOL_OK) {
    std::fprintf(stderr, "%s\n", pvol_message(cloud.get()));
    return 2;
  }
  cloud.set_extinction(kExtinction).commit();

  const Vec eye{1.2, -0.3, 3.8}, z = unit(Vec{0, 0.02, 0} + -1.0 * eye);
  const Vec x = unit(cross(z, {0, 1, 0})), y = cross(x, z);
  const double half = std::tan(21.5 / 360 * kPi);
  std::vector<Mean> blocks(std::size_t(n / 4 * (n / 4)));
  Mean all;
  for (int pixel = 0; pixel < n * n; ++pixel) {
    Mean& block = blocks[std::size_t(pixel / n / 4 * (n / 4) + pixel % n / 4)];
    for (int sample = 0; sample < kSamples; ++sample) {
      Sampler numbers(pixel, sample);
      const double u = (pixel % n + numbers()) / n, v = (pixel / n + numbers()) / n;
      const Vec direction = unit(z + half * (2 * u - 1) * x + half * (1 - 2 * v) * y);
      const double value = radiance(cloud, eye, direction, numbers);
      for (Mean* m : {&block, &all}) m->sum += value, m->squares += value * value, ++m->count;
    }
    block.expected += reference[std::size_t(pixel)] / 16;
    all.expected += reference[std::size_t(pixel)] / (n * n);
  }
  double worst = 0;
  for (const Mean& b : blocks) worst = std::max(worst, std::abs(b.deviation()));
  std::printf("mean %.4f, pvol-render %.4f: %.2f standard errors; worst of %zu blocks: %.2f\n",
              all.sum / all.count, all.expected, all.deviation(), blocks.size(), worst);
  return std::abs(all.deviation()) < 4 && worst < 4.5 ? 0 : 1;
}
