#include "render/light/sky/spectrum.h"

#include "pvol/math/observer.h"

namespace pvol::detail {
namespace {

/// The sun above the air in W / (m^2 nm), ASTM G-173-03, as means over 10 nm that begin at 380 nm,
/// 390 nm and so on.
constexpr std::array<double, 41> kSun{
    1.0125, 1.1472, 1.7277, 1.7305, 1.6887, 1.6125, 1.9120, 2.0347, 2.0204, 2.0221, 1.9338,
    1.9581, 1.9169, 1.8298, 1.8685, 1.8931, 1.8515, 1.8504, 1.8341, 1.8345, 1.8147, 1.7816,
    1.7533, 1.6965, 1.6819, 1.6465, 1.6048, 1.5214, 1.5562, 1.5113, 1.4740, 1.4482, 1.4102,
    1.3678, 1.3419, 1.3143, 1.2830, 1.2676, 1.2367, 1.2082, 1.1874};

/// X, Y, Z that each band adds, where Y of them all is 1. Spectra are linear between bands and
/// constant beyond them, so that the lines of the sun's own count in full.
using Weights = std::array<Vec3d, kBands>;
Weights make_weights() {
  Weights w{};
  double sum = 0;
  constexpr int kParts = 10;  // of an interval of the tables
  for (int i = 0; i + 1 < int(kObserver.size()); ++i) {
    for (int part = 0; part < kParts; ++part) {
      const double u = (part + 0.5) / kParts, nm = kFirstNm + kStepNm * (i + u);
      const Vec3d seen = (kObserver[std::size_t(i)] * (1 - u) + kObserver[std::size_t(i) + 1] * u) *
                         kSun[std::size_t(i)];
      const double at =
          std::clamp((nm - kFirstBand) / (band_nm(1) - kFirstBand), 0.0, double(kBands - 1));
      const auto band = std::size_t(std::min(int(at), kBands - 2));
      w[band] += seen * (double(band) + 1 - at);
      w[band + 1] += seen * (at - double(band));
      sum += seen.y;
    }
  }
  for (Vec3d& v : w) v = v / sum;
  return w;
}

}  // namespace

Vec3d seen_as(const Spectrum& factor, ColorSpace space) {
  static const Weights weights = make_weights();
  Vec3d c;
  for (std::size_t i = 0; i < kBands; ++i) c += weights[i] * double(factor.v[i]);
  return conversion(ColorSpace::rec709, space).vector(rec709(c));
}

Spectrum albedo_spectrum(Rgb albedo) {
  return Spectrum([&](double nm) {
    const double red = std::clamp((nm - 570) / 40, 0.0, 1.0);
    const double blue = std::clamp((510 - nm) / 40, 0.0, 1.0);
    return red * double(albedo.x) + (1 - red - blue) * double(albedo.y) + blue * double(albedo.z);
  });
}

}  // namespace pvol::detail
