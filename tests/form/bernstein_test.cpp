// Polynomials by their Bernstein coefficients.
#include "form/bernstein.h"

#include <gtest/gtest.h>

namespace pvol {
namespace bernstein_test {

/// Zeros count as positive on either side of them.
TEST(Bernstein, ZerosChangeNoSign) {
  EXPECT_EQ(sign_changes({1, 0, 1, 1, 1}), 0);
  EXPECT_EQ(sign_changes({0, 0, 0, 0, 0}), 0);
  EXPECT_EQ(sign_changes({1, 0, 0, 0, -1}), 1);
  EXPECT_EQ(sign_changes({-1, 0, 0, 1, 2}), 1);
  EXPECT_EQ(sign_changes({-1, 0, -1, 0, -1}), 4);
}

}  // namespace bernstein_test
}  // namespace pvol
