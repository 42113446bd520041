// Where the sun is, against published examples.
#include "pvol/render/sun_position.h"

#include <gtest/gtest.h>

#include <cmath>
#include <string>

namespace pvol {
namespace sun_position_test {

double days(const char* date) {
  const auto d = parse_date(date);
  EXPECT_TRUE(d) << date;
  return d.value_or(0);
}

/// The elevation at the north pole, less the parallax.
double declination(const char* date) {
  const double e = sun_position(days(date), 90, 0).elevation;
  return e + 8.794 / 3600 * std::cos(e * 3.14159265358979 / 180);
}

TEST(Date, CountsDaysFromNoonOfTheFirstOf2000) {
  EXPECT_EQ(days("2000-01-01T12:00:00Z"), 0);
  EXPECT_EQ(days("2000-01-01 12:00Z"), 0);
  EXPECT_EQ(days("2000-01-01T14:00:00+02:00"), 0);
  EXPECT_EQ(days("2000-01-01T06:30:00-0530"), 0);
  EXPECT_NEAR(days("2000-01-01T12:00:01.5Z"), 1.5 / 86400, 1e-12);
  // Julian dates of Meeus, Astronomical Algorithms (1998), table 7.a, less 2451545.
  EXPECT_EQ(days("1999-01-01T00:00:00Z"), 2451179.5 - 2451545);
  EXPECT_EQ(days("1987-01-27T00:00:00Z"), 2446822.5 - 2451545);
  EXPECT_EQ(days("1988-06-19T12:00:00Z"), 2447332.0 - 2451545);
  EXPECT_EQ(days("1900-01-01T00:00:00Z"), 2415020.5 - 2451545);
  EXPECT_EQ(days("2000-03-01T00:00:00Z") - days("2000-02-29T00:00:00Z"), 1);
  EXPECT_EQ(days("2001-01-01T00:00:00Z") - days("2000-01-01T00:00:00Z"), 366);
  EXPECT_EQ(days("2101-01-01T00:00:00Z") - days("2100-01-01T00:00:00Z"), 365);
}

TEST(Date, OtherTextsAreRefused) {
  for (const char* text : {"",
                           "2024",
                           "2024-06-21",
                           "2024-06-21T12:00",
                           "2024-06-21T12:00:00",
                           "2024-13-01T00:00Z",
                           "2024-00-01T00:00Z",
                           "2023-02-29T00:00Z",
                           "2100-02-29T00:00Z",
                           "2024-06-31T00:00Z",
                           "2024-06-21T24:00Z",
                           "2024-06-21T12:60Z",
                           "2024-06-21T12:00:61Z",
                           "2024-06-21T12:00:00z",
                           "2024-06-21T12:00:00.Z",
                           "2024-06-21T12:00:00+2",
                           "2024-06-21T12:00:00+24:00",
                           "2024-06-21T12:00:00+02:60",
                           "2024-06-21T12:00:00Z ",
                           " 2024-06-21T12:00:00Z",
                           "2024-6-21T12:00:00Z",
                           "24-06-21T12:00:00Z",
                           "2024-06-21X12:00:00Z",
                           "1799-12-31T23:59Z",
                           "2201-01-01T00:00Z",
                           "2024-06-21T1\xc3\xa4:00Z",
                           "-024-06-21T12:00Z",
                           "99999-06-21T12:00Z"}) {
    EXPECT_FALSE(parse_date(text)) << text;
  }
  const std::string whole = "2024-06-21T14:30:00.25+02:00";
  ASSERT_TRUE(parse_date(whole));
  for (std::size_t n = 0; n < whole.size(); ++n) {
    if (n == whole.size() - 3)
      continue;  // +02 alone lacks its minutes, as all others lack something
    EXPECT_FALSE(parse_date(whole.substr(0, n))) << n;
  }
}

TEST(SunPosition, IsThatOfThePublishedExampleOfSpa) {
  // Reda and Andreas 2004, A.5: topocentric zenith 50.11162 and azimuth 194.34024 degrees, with
  // refraction at 820 mbar and 11 degrees Celsius, by their equation 42.
  const SunPosition p = sun_position(days("2003-10-17T12:30:30-07:00"), 39.742476, -105.1786);
  const double true_elevation = 39.8721;  // what equation 42 lifts to 90 - 50.11162
  const double lifted =
      true_elevation +
      820.0 / 1010 * 283 / (273 + 11) * 1.02 / 60 /
          std::tan((true_elevation + 10.3 / (true_elevation + 5.11)) * 3.14159265358979 / 180);
  ASSERT_NEAR(lifted, 90 - 50.11162, 2e-4);
  EXPECT_NEAR(p.elevation, true_elevation, 0.01);
  EXPECT_NEAR(p.azimuth, 194.34024, 0.01);
}

TEST(SunPosition, HasThePublishedDeclination) {
  // Meeus 1998, examples 25.a and b, for 0h of terrestrial time, 59 s ahead: the accurate one.
  EXPECT_NEAR(declination("1992-10-12T23:59:01Z"), -7.783817, 0.005);
  // The same example by the low-precision theory, with nutation: 25.a.
  EXPECT_NEAR(declination("1992-10-13T00:00Z"), -7.78507, 1e-4);
  // The March equinoxes and that of September 2000, by the minute.
  for (const char* equinox : {"2000-03-20T07:35Z", "2010-03-20T17:32Z", "2020-03-20T03:50Z",
                              "2024-03-20T03:06Z", "2000-09-22T17:28Z"}) {
    EXPECT_NEAR(declination(equinox), 0, 0.008) << equinox;
  }
  EXPECT_NEAR(declination("2000-06-21T01:48Z"), 23.4390, 0.005);
  EXPECT_NEAR(declination("2000-12-21T13:37Z"), -23.4390, 0.005);
}

TEST(SunPosition, CrossesTheMeridianAtNoonByTheEquationOfTime) {
  // Meeus 1998, example 28.a: the equation of time was 3.427351 degrees on 13 October 1992, 0h.
  const double noon = days("1992-10-13T00:00Z") - 0.5 - 3.427351 / 360;
  for (const double longitude : {0.0, 100.0, -77.5}) {
    const double when = noon - longitude / 360;
    const SunPosition p = sun_position(when, 50, longitude);
    EXPECT_NEAR(p.azimuth, 180, 0.1) << longitude;  // it changes by a tenth a day at most
    EXPECT_LT(sun_position(when - 0.01, 50, longitude).azimuth, 180);
    EXPECT_GT(sun_position(when + 0.01, 50, longitude).azimuth, 180);
    EXPECT_LT(sun_position(when - 0.2, -35, longitude).azimuth, 90) << "mornings are in the east";
  }
}

TEST(SunPosition, IsFiniteEverywhere) {
  for (const char* date : {"1800-01-01T00:00Z", "1969-07-20T20:17Z", "2200-12-31T23:59:60Z"}) {
    for (double latitude = -90; latitude <= 90; latitude += 15) {
      for (double longitude = -360; longitude <= 360; longitude += 45) {
        const SunPosition p = sun_position(days(date), latitude, longitude);
        EXPECT_TRUE(std::abs(p.elevation) <= 90.01);
        EXPECT_TRUE(p.azimuth >= 0 && p.azimuth < 360);
      }
    }
  }
}

TEST(Refraction, LiftsTheHorizonByHalfADegree) {
  EXPECT_NEAR(refraction(0) * 60, 28.9, 0.1);  // true elevation 0: NOAA's 1735 seconds
  EXPECT_NEAR(refraction(10) * 60, 5.3, 0.1);  // Bennett 1982: 5.3 arc minutes there
  EXPECT_NEAR(refraction(45) * 60, 0.97, 0.02);
  EXPECT_EQ(refraction(90), 0);
  double before = -91;
  for (double e = -90; e <= 90; e += 0.01) {
    const double seen = e + refraction(e);
    EXPECT_GT(seen, before) << e;
    EXPECT_LT(seen - before, 1.1) << e;
    before = seen;
  }
}

}  // namespace sun_position_test
}  // namespace pvol
