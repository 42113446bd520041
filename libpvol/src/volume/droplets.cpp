#include "pvol/volume/droplets.h"

namespace pvol {
namespace {

struct Fit {
  double peak_g, wide_g, wide_alpha, wide_share;
};

/// The four ranges of the paper, for the diameter d in micrometres.
Fit fit(double d) {
  if (d <= 0.1) {
    return {13.8 * d * d, 1.1456 * d * std::sin(9.29044 * d), 250,
            0.252977 - 312.983 * std::pow(d, 4.3)};
  }
  const double l = std::log(d);
  if (d < 1.5) {
    const double inner = std::cos((l - 0.238604) * (l + 1.00667) / (0.507522 - 0.15677 * l));
    return {0.862 - 0.143 * l * l,
            0.379685 * std::cos(1.19692 * inner + 1.37932 * l + 0.0625835) + 0.344213, 250,
            0.146209 * std::cos(3.38707 * l + 2.11193) + 0.316072 + 0.0778917 * l};
  }
  if (d < 5) {
    const double ll = std::log(l);
    return {0.0604931 * ll + 0.940256, 0.500411 - 0.081287 / (-2 * l + std::tan(l) + 1.27551),
            7.30354 * l + 6.31675,
            0.026914 * (l - std::cos(5.68947 * (ll - 0.0292149))) + 0.376475};
  }
  return {std::exp(-0.0990567 / (d - 1.67154)), std::exp(-2.20679 / (d + 3.91029) - 0.428934),
          std::exp(3.62489 - 8.29288 / (d + 5.52825)),
          std::exp(-0.599085 / (d - 0.641583) - 0.665888)};
}

}  // namespace

Droplets::Droplets(double micrometres) : diameter(micrometres) {
  const Fit f = fit(diameter);
  peak = HenyeyGreenstein(f.peak_g);
  wide = Draine(f.wide_g, f.wide_alpha);
  wide_share = f.wide_share;
}

double mean_cosine(const Droplets& p) {
  return (1 - p.wide_share) * mean_cosine(p.peak) + p.wide_share * mean_cosine(p.wide);
}

float pdf_phase(const Droplets& p, Vec3f from, Vec3f to) {
  const auto w = float(p.wide_share);
  return (1 - w) * pdf_phase(p.peak, from, to) + w * pdf_phase(p.wide, from, to);
}

PhaseSample sample_phase(const Droplets& p, Vec3f from, float u, float azimuth) {
  const auto w = float(p.wide_share);
  const Vec3f d = u < w ? sample_phase(p.wide, from, u / w, azimuth).direction
                        : sample_phase(p.peak, from, (u - w) / (1 - w), azimuth).direction;
  return {d, pdf_phase(p, from, d)};
}

}  // namespace pvol
