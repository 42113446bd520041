#include "support/slab_oracle.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

namespace pvol::test {
namespace slab_oracle_test {

using std::numbers::pi;

/// H by its closed form (Stibbs, Weir. MNRAS 119, 1959), by another quadrature than the oracle's.
double stibbs_weir(double albedo, double mu) {
  const Quadrature q = gauss_legendre(200);
  double sum = 0;
  for (std::size_t i = 0; i < q.x.size(); ++i) {
    // At albedo 1 there is a logarithm's branch at t = 0: t = pi/2 s^4.
    const double s = q.x[i], t = pi / 2 * s * s * s * s;
    const double c = std::cos(t), r = std::sin(t);
    const double one_minus_t_cot_t = t < 1e-3 ? t * t / 3 : 1 - t * c / r;
    sum += q.weight[i] * pi / 2 * 4 * s * s * s *
           std::log(1 - albedo + albedo * one_minus_t_cot_t) / (c * c + mu * mu * r * r);
  }
  return std::exp(-mu / pi * sum);
}

TEST(HFunction, HasPublishedValues) {
  // Chandrasekhar. Radiative Transfer. Table XI, for albedo 1.
  const HFunction h(1);
  EXPECT_NEAR(h(0.1), 1.2474, 6e-5);
  EXPECT_NEAR(h(0.2), 1.4503, 6e-5);
  EXPECT_NEAR(h(0.5), 2.0128, 6e-5);
  EXPECT_NEAR(h(1.0), 2.9078, 6e-5);
}

TEST(HFunction, AgreesWithItsClosedForm) {
  for (const double albedo : {0.1, 0.5, 0.9, 0.999, 1.0}) {
    const HFunction h(albedo);
    for (const double mu : {0.01, 0.1, 0.3, 0.7, 1.0}) {
      EXPECT_NEAR(h(mu), stibbs_weir(albedo, mu), 1e-8) << albedo << " " << mu;
    }
  }
}

/// int H = 2 (1 - sqrt(1 - albedo)) / albedo and, for albedo 1, int mu H = 2 / sqrt(3).
TEST(HFunction, HasKnownMoments) {
  const Quadrature q = gauss_legendre(100);
  for (const double albedo : {0.5, 0.9, 1.0}) {
    const HFunction h(albedo);
    double zeroth = 0, first = 0;
    for (std::size_t i = 0; i < q.x.size(); ++i) {
      zeroth += q.weight[i] * h(q.x[i]);
      first += q.weight[i] * q.x[i] * h(q.x[i]);
    }
    EXPECT_NEAR(zeroth, 2 * (1 - std::sqrt(1 - albedo)) / albedo, 1e-6);
    if (albedo == 1) {
      EXPECT_NEAR(first, 2 / std::sqrt(3.0), 1e-6);
    }
  }
}

/// Van de Hulst. Multiple Light Scattering. 1980, table 35, as quoted by Prahl et al. Applied
/// Optics 32, 1993, and Wang et al. MCML. 1995.
TEST(SlabOracle, HasVanDeHulstsValuesForASlab) {
  const Fluxes f = Slab({2, 0.9, 0.75}, {1}).collimated(0);
  EXPECT_NEAR(f.reflected, 0.09739, 6e-6);
  EXPECT_NEAR(f.transmitted + f.direct, 0.66096, 6e-6);
}

/// Between black plates, grey gas that only scatters or re-emits carries this share of the flux:
/// Heaslet, Warming. Int. J. Heat Mass Transfer 8, 1965.
TEST(SlabOracle, HasHeasletAndWarmingsValuesForDiffuseLight) {
  struct Value {
    double depth, flux;
  };
  for (const Value v : {Value{0.1, 0.9157}, Value{0.5, 0.7040}, Value{1, 0.5534}, Value{2, 0.3900},
                        Value{5, 0.2077}}) {
    const Fluxes f = Slab({v.depth, 1, 0}, {}).diffuse();
    EXPECT_NEAR(f.transmitted + f.direct, v.flux, 2e-4) << v.depth;
  }
}

TEST(SlabOracle, ThickSlabsAreHalfSpaces) {
  for (const double albedo : {0.5, 0.8, 0.9, 0.99}) {
    const HFunction h(albedo);
    const Slab slab({200, albedo, 0}, {1, 0.3, 0.05});
    const double mu[] = {1, 0.3, 0.05};
    for (std::size_t i = 0; i < 3; ++i) {
      EXPECT_NEAR(slab.collimated(i).reflected, h.plane_albedo(mu[i]), 1e-6) << albedo;
      for (std::size_t k = 0; k < 3; ++k) {
        // The law of diffuse reflection, Chandrasekhar, chapter III, equation 110.
        const double expected = albedo / (4 * pi) * mu[k] / (mu[i] + mu[k]) * h(mu[i]) * h(mu[k]);
        EXPECT_NEAR(slab.reflected_radiance(i, k), expected, 1e-6) << albedo;
      }
    }
  }
}

TEST(SlabOracle, WithoutAbsorptionNoLightIsLost) {
  for (const double g : {0.0, 0.5, 0.9, -0.4}) {
    for (const double depth : {0.01, 1.0, 100.0}) {
      const Slab slab({depth, 1, g}, {1, 0.3});
      for (const Fluxes f : {slab.collimated(0), slab.collimated(1), slab.diffuse()}) {
        EXPECT_NEAR(f.reflected + f.transmitted + f.direct, 1, 1e-8) << g << " " << depth;
      }
    }
  }
}

TEST(SlabOracle, WithoutScatteringOnlyTheBeamIsLeft) {
  const Fluxes f = Slab({1.5, 0, 0.5}, {0.3}).collimated(0);
  EXPECT_NEAR(f.reflected, 0, 1e-14);
  EXPECT_NEAR(f.transmitted, 0, 1e-14);
  EXPECT_DOUBLE_EQ(f.direct, std::exp(-5.0));
}

/// To first order in albedo, light at the cosine s leaves along the normal as
/// albedo p(-s) s / (1 + s) (1 - exp(-depth (1 + 1/s))), and downward likewise.
TEST(SlabOracle, FaintScatteringIsSingleScattering) {
  constexpr double kAlbedo = 1e-6, kDepth = 0.7;
  for (const double g : {0.0, 0.5, -0.4, 0.877}) {
    const Slab slab({kDepth, kAlbedo, g}, {1, 0.3, 0.8});
    const double mu[] = {1, 0.3, 0.8};
    for (const std::size_t sun : {1, 2}) {
      const double s = mu[sun];
      const auto phase = [&](double cosine) {
        return (1 - g * g) / (4 * pi * std::pow(1 + g * g - 2 * g * cosine, 1.5));
      };
      const double up = kAlbedo * phase(-s) * s / (1 + s) * -std::expm1(-kDepth * (1 + 1 / s));
      const double down =
          kAlbedo * phase(s) * s / (1 - s) * (std::exp(-kDepth) - std::exp(-kDepth / s));
      // What the series of the phase function leaves out shows most here.
      EXPECT_NEAR(slab.reflected_radiance(0, sun) / up, 1, 2e-5) << g;
      EXPECT_NEAR(slab.transmitted_radiance(0, sun) / down, 1, 2e-5) << g;
    }
  }
}

/// By flux: exchanging view and incidence exchanges mu_v L(v, s) with mu_s L(s, v).
TEST(SlabOracle, IsReciprocal) {
  for (const double g : {0.0, 0.877}) {
    const Slab slab({3, 0.9, g}, {1, 0.3});
    EXPECT_NEAR(slab.reflected_radiance(0, 1) * 1, slab.reflected_radiance(1, 0) * 0.3, 1e-10);
    EXPECT_NEAR(slab.transmitted_radiance(0, 1) * 1, slab.transmitted_radiance(1, 0) * 0.3, 1e-10);
  }
}

TEST(SlabOracle, MoreStreamsChangeNothing) {
  for (const double g : {0.0, 0.877, 0.9, -0.9}) {
    for (const double depth : {0.1, 10.0}) {
      const std::vector<double> cosines{1, 0.3};
      const Slab slab({depth, 0.9, g}, cosines);
      const Slab fine({depth, 0.9, g}, cosines, Slab::kStreams * 3 / 2);
      for (const std::size_t i : {0, 1}) {
        const Fluxes a = slab.collimated(i), b = fine.collimated(i);
        EXPECT_NEAR(a.reflected, b.reflected, 1e-9) << g << " " << depth;
        EXPECT_NEAR(a.transmitted, b.transmitted, 1e-9) << g << " " << depth;
      }
      EXPECT_NEAR(slab.diffuse().reflected, fine.diffuse().reflected, 1e-9) << g << " " << depth;
    }
  }
}

}  // namespace slab_oracle_test
}  // namespace pvol::test
