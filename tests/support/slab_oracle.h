// Light in homogeneous plane-parallel slabs and half-spaces, without random numbers: for tests.
#pragma once

#include <cstddef>
#include <vector>

namespace pvol::test {

/// Nodes x and weights on (0, 1).
struct Quadrature {
  std::vector<double> x, weight;
};

/// Gauss and Legendre's, exact for polynomials of degree up to 2 n - 1.
[[nodiscard]] Quadrature gauss_legendre(int n);

struct SlabOptics {
  double depth;   ///< optical thickness, > 0
  double albedo;  ///< in [0, 1]
  double g;       ///< mean cosine of the Henyey-Greenstein phase function
};

/// Shares of the light that falls on a slab.
struct Fluxes {
  double reflected;
  double transmitted;  ///< after scattering
  double direct;       ///< without a collision
};

/// The scattering operators of a slab, by adding and doubling: for azimuthal means, hence exact for
/// fluxes, for views along the normal and, at g = 0, for every view.
///
/// The radiative transfer equation at Gauss nodes of the cosines becomes a system of linear
/// differential equations, whose Taylor series gives a thin layer; doubling it k times gives the
/// slab. The phase function's Legendre series is cut where the quadrature stays exact, so that
/// scattering conserves energy to rounding. With the default number of streams, fluxes are accurate
/// to 1e-9 for |g| <= 0.9 and depths up to 10, and the radiance of single scattering to 2e-5 of
/// itself; slab_oracle_test.cpp refines the streams and compares with closed forms.
/// Based on: van de Hulst. Multiple Light Scattering. 1980, chapter 4; Grant, Hunt. Discrete Space
/// Theory of Radiative Transfer. 1969.
class Slab {
 public:
  static constexpr int kStreams = 64;

  /// `cosines`, in (0, 1], are angles to the normal at which one wants to know; below they are
  /// meant by their index.
  Slab(const SlabOptics& optics, const std::vector<double>& cosines, int streams = kStreams);

  /// For a beam that falls in at that cosine.
  [[nodiscard]] Fluxes collimated(std::size_t incidence) const;
  /// For a hemisphere of equal radiance.
  [[nodiscard]] Fluxes diffuse() const;

  /// Radiance that leaves at cosine `view`, averaged over azimuths, in a beam of cosine `incidence`
  /// that brings the irradiance 1 to a plane across it.
  [[nodiscard]] double reflected_radiance(std::size_t view, std::size_t incidence) const;
  /// Without the beam itself; view and incidence must be different entries, perhaps of one cosine.
  [[nodiscard]] double transmitted_radiance(std::size_t view, std::size_t incidence) const;

 private:
  [[nodiscard]] Fluxes at_node(std::size_t node) const;

  double depth_;
  std::size_t streams_;
  std::vector<double> mu_, weight_;  // Gauss nodes, then the cosines that were asked for
  std::vector<double> reflection_, transmission_;  // operators on radiances at the nodes, by rows
};

/// Chandrasekhar's H-function for isotropic scattering, accurate to 1e-8 for cosines above 0.01.
/// Based on: Chandrasekhar. Radiative Transfer. 1950, chapter V, by iterating
/// 1 / H(mu) = sqrt(1 - albedo) + albedo / 2 int_0^1 x H(x) / (mu + x) dx.
class HFunction {
 public:
  explicit HFunction(double albedo);
  [[nodiscard]] double operator()(double mu) const;
  /// The share of a beam at this cosine that an isotropically scattering half-space reflects.
  [[nodiscard]] double plane_albedo(double mu) const;

 private:
  double albedo_;
  Quadrature nodes_;
  std::vector<double> h_;  // at the nodes
};

}  // namespace pvol::test
