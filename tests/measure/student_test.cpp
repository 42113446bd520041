#include "pvol/measure/student.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numbers>

#include "support/statistics.h"

namespace pvol::measure {
namespace student_test {

TEST(Student, HasItsClosedForms) {
  for (double t = 1e-6; t < 1e6; t *= 3.7) {
    const double one = 1 - 2 / std::numbers::pi * std::atan(t);
    EXPECT_NEAR(student_p_value(t, 1), t > 1 ? 2 / std::numbers::pi * std::atan(1 / t) : one,
                1e-12);
    // 1 - t / sqrt(2 + t^2), without cancellation.
    const double root = std::sqrt(2 + t * t), two = 2 / (root * (root + t));
    EXPECT_NEAR(student_p_value(-t, 2) / two, 1, 1e-9) << t;
  }
}

TEST(Student, AgreesWithAnotherAlgorithmForAnyDegreesOfFreedom) {
  for (const double t : {1e-3, 0.1, 0.7, 1.0, 1.96, 3.3, 5.0, 9.0, 20.0}) {
    for (const double dof : {0.3, 1.0, 2.5, 7.0, 15.0, 63.4, 511.0, 2e4, 1e6}) {
      EXPECT_NEAR(student_p_value(t, dof) / proof::student_p_value(t, dof), 1, 1e-8)
          << t << ", " << dof;
    }
    // The laws differ by about t^4 / (4 dof).
    for (const double dof : {3e8, 2e10, 1e14}) {
      EXPECT_NEAR(student_p_value(t, dof) / proof::normal_p_value(t), 1, 1e-8 + t * t * t * t / dof)
          << t << ", " << dof;
    }
  }
}

TEST(Student, EndsAreThere) {
  const double infinity = std::numeric_limits<double>::infinity();
  EXPECT_EQ(student_p_value(0, 5), 1);
  EXPECT_EQ(student_p_value(infinity, 5), 0);
  for (const double none : {0.0, -1.0}) {
    EXPECT_EQ(student_p_value(3, none), 1);
    EXPECT_EQ(student_quantile(0.95, none), infinity);
  }
  EXPECT_TRUE(std::isnan(student_p_value(std::nan(""), 5)));
  EXPECT_GT(student_p_value(30, 1e6), 0);
  EXPECT_LT(student_p_value(30, 1e6), 1e-190);
}

TEST(Student, QuantilesInvertProbabilities) {
  EXPECT_NEAR(student_quantile(0.95, 10), 2.228138852, 1e-8);
  EXPECT_NEAR(student_quantile(0.95, 1e9), 1.959963985, 1e-8);
  EXPECT_NEAR(student_quantile(0.99, 3), 5.840909310, 1e-8);
  EXPECT_EQ(student_quantile(0, 3), 0);
  for (const double confidence : {0.01, 0.5, 0.9, 0.999, 0.999999}) {
    for (const double dof : {1.0, 4.0, 33.3, 1e5}) {
      const double t = student_quantile(confidence, dof);
      EXPECT_NEAR(student_p_value(t, dof) / (1 - confidence), 1, 1e-6) << confidence << ' ' << dof;
    }
  }
}

TEST(Student, TheSmallestOfManyIsAsRareAsItIs) {
  EXPECT_DOUBLE_EQ(sidak_p_value(0.5, 2), 0.75);
  EXPECT_NEAR(sidak_p_value(1e-20, 1e6), 1e-14, 1e-19);
  EXPECT_EQ(sidak_p_value(1, 7), 1);
  EXPECT_EQ(sidak_p_value(0, 7), 0);
}

}  // namespace student_test
}  // namespace pvol::measure
