// Time left, by a forecast and by the work so far.
#include "cli/time_left.h"

#include <gtest/gtest.h>

namespace pvol::cli {
namespace time_left_test {

TEST(TimeLeft, IsTheForecastAtFirst) {
  TimeLeft left;
  left.begin(100, 0, 0.5);
  EXPECT_NEAR(*left.at(100, 0, 40), 20, 1e-9);
}

TEST(TimeLeft, IsUnknownWithoutForecastAndWork) {
  const TimeLeft left;
  EXPECT_FALSE(left.at(3, 0, 40));
  EXPECT_NEAR(*left.at(3, 10, 40), 9, 1e-9);
}

TEST(TimeLeft, FollowsTheWorkWhereTheForecastWasWrong) {
  TimeLeft left;
  left.begin(0, 0, 0.1);  // a tenth of what a unit takes
  EXPECT_NEAR(*left.at(500, 500, 1000), 500, 50);
  EXPECT_NEAR(*left.at(990, 990, 1000), 10, 0.5);
}

/// A render that is resumed did not take its first samples in no time.
TEST(TimeLeft, LeavesOutWhatWasDoneBefore) {
  TimeLeft left;
  left.begin(10, 900, 0);
  EXPECT_FALSE(left.at(10, 900, 1000));
  EXPECT_NEAR(*left.at(30, 920, 1000), 80, 1e-9);
  EXPECT_NEAR(left.rate(30, 920), 1, 1e-9);
  EXPECT_EQ(left.rate(10, 900), 0);
}

}  // namespace time_left_test
}  // namespace pvol::cli
