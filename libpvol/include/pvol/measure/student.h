// Student's t: from a deviation to a probability, and from a confidence to an interval.
#pragma once

namespace pvol::measure {

/// Probability that a Student variable with `dof` > 0 degrees of freedom (which need not be whole)
/// is farther from 0 than t; 1 for t = 0 or without degrees of freedom, 0 for an infinite t.
/// Relative accuracy about 1e-8 down to 1e-300; above 1e8 degrees of freedom the normal law stands
/// in, which is off by t^4 / (4 dof).
[[nodiscard]] double student_p_value(double t, double dof);

/// The t that a Student variable stays below in absolute value with probability `confidence`, in
/// [0, 1): a mean's interval is its standard error times this, to either side. Relative accuracy
/// about 1e-9; infinite where the interval has no end in double, as without degrees of freedom.
[[nodiscard]] double student_quantile(double confidence, double dof);

/// The probability that the smallest of `count` independent p-values is at most `p`:
/// 1 - (1 - p)^count.
/// Based on: Sidak. Rectangular Confidence Regions for the Means of Multivariate Normal
/// Distributions. JASA 62, 1967.
[[nodiscard]] double sidak_p_value(double p, double count);

}  // namespace pvol::measure
