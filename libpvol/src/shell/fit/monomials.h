// Quadrics over many points at once: values, extremes and the moments that gradients are made of.
#pragma once

#include <array>
#include <vector>

#include "pvol/form/quadric.h"
#include "shell/fit/points.h"

namespace pvol::detail {

/// Coefficients of the monomials x^2 y^2 z^2 yz zx xy x y z 1, in float for loops over points.
using Monomials = std::array<float, 10>;
[[nodiscard]] Monomials monomials(const Quadric& q);

/// Finds q at each of the points, and returns the greatest value; minus infinity without points.
float evaluate(const Monomials& q, const Points& points, float* values);

/// That value alone.
[[nodiscard]] float greatest(const Monomials& q, const Points& points);

/// How many of the points have a value above 0.
[[nodiscard]] std::size_t count_positive(const Monomials& q, const Points& points);

/// Sums of weight times each of the ten monomials. Here and below the numbers of points are
/// multiples of kWide: see `pad`.
[[nodiscard]] QuadricTerms moments(const Points& points, const std::vector<float>& weights);

/// Those sums with weights max(0, 1 - (most - value) per_reach)^4: of points whose values are near
/// the greatest.
[[nodiscard]] QuadricTerms moments_near(const Points& points, const std::vector<float>& values,
                                        float most, float per_reach);

/// Those sums with weights (1 + u^2)^(-3/2), the slope of u / sqrt(1 + u^2) at u = (q - most)
/// per_width.
[[nodiscard]] QuadricTerms moments_of_slopes(const Monomials& q, const Points& points, float most,
                                             float per_width);

/// Mean square of the length of q's gradient over weighted points, by those sums.
[[nodiscard]] double mean_square_gradient(const Quadric& q, const QuadricTerms& moments);

/// The loops of these functions, as they are compiled for an instruction set.
struct PointLoops {
  float (*evaluate)(const Monomials& q, const Points& points, float* values);
  QuadricTerms (*moments)(const Points& points, const float* weights);
  QuadricTerms (*moments_near)(const Points& points, const float* values, float most,
                               float per_reach);
  QuadricTerms (*moments_of_slopes)(const Monomials& q, const Points& points, float most,
                                    float per_width);
};

/// For AVX2, where the processor has it, and for the compiler's default: they find the same bits.
[[nodiscard]] std::vector<PointLoops> point_loops();

/// The weights of the greatest values: a softmax with a kernel that ends, (1 - x)^4 for exp(-4 x);
/// its reach in widths of a sigmoid.
inline constexpr double kNearGreatest = 1.2;

inline constexpr std::size_t kWide = 8;

/// Repeats points until their number is a multiple of kWide.
inline void pad(Points& points) {
  for (std::size_t i = 0; points.size() % kWide != 0; ++i) points.add(points[i]);
}

}  // namespace pvol::detail
