#include "pvol/shell/shell.h"

#include <gtest/gtest.h>

#include <limits>

#include "support/messages.h"

namespace pvol {
namespace shell_test {

/// A unit ball in the frame of a box of 2 x 2 x 2 units, with a dent and a bulge of radius 1/2.
Shell sample_shell(ShellKind kind) {
  Shell s;
  s.kind = kind;
  s.lo = {-32, -32, -32};
  s.hi = {32, 32, 32};
  s.form.base = ellipsoid({}, Vec3d(0.75));
  s.form.perturbations = {{{ellipsoid({0.5, 0, 0}, Vec3d(0.5)), {}}, -1},
                          {{ellipsoid({-0.5, 0, 0}, Vec3d(0.5)), {}}, 1}};
  s.form = round_to_float(s.form);
  s.certificate.bound = 1e-3;
  return s;
}

TEST(ShellFrame, MapsLatticePointsExactlyIntoTheUnitCube) {
  for (const Vec3l lo : {Vec3l(0), Vec3l(-7, 1000003, 5), Vec3l(-(1 << 24), 12, (1 << 30))}) {
    for (const Vec3l size : {Vec3l(1), Vec3l(2, 3, 5), Vec3l(126, 87, 155), Vec3l(1 << 24, 3, 9)}) {
      const ShellFrame f = frame(lo, lo + size);
      EXPECT_EQ(f.to_shell(f.centre), Vec3d());
      for (int i = 0; i < 100; ++i) {
        const Vec3l at = lo + Vec3l(size.x * i / 99, size.y * (i * 7 % 100) / 99, size.z * i / 99);
        const Vec3d p = f.to_shell(Vec3d(at));
        EXPECT_EQ(f.to_index(p), Vec3d(at));
        EXPECT_LE(max_component(max(p, -p)), 1);
      }
      const double half = double(max_component(size)) / (2 * f.unit);
      EXPECT_LE(half, 1);
      EXPECT_TRUE(half > 0.5 || f.unit == 1);
    }
  }
}

TEST(Shell, HardIsUnitedWithBulgesAndWithoutDents) {
  const Shell s = sample_shell(ShellKind::hard);
  EXPECT_TRUE(contains(s, {0, 16, 0}));      // in the base
  EXPECT_FALSE(contains(s, {16, 0, 0}));     // in the dent
  EXPECT_TRUE(contains(s, {-30, 0, 0}));     // in the bulge alone
  EXPECT_FALSE(contains(s, {0, 30, 0}));     // in nothing
  EXPECT_FALSE(contains(s, {-32.5, 0, 0}));  // outside the box
  EXPECT_EQ(slack(s, {0.5, 0, 0}), -1);      // in the middle of the dent
  EXPECT_EQ(slack(s, {-0.5, 0, 0}), 1);      // of the bulge
}

TEST(Shell, SoftIsTheFreeForm) {
  const Shell s = sample_shell(ShellKind::soft);
  for (double x = -1; x <= 1; x += 1.0 / 16) {
    EXPECT_EQ(slack(s, {x, 0.1, 0.2}), value(s.form, {x, 0.1, 0.2}));
  }
  EXPECT_EQ(contains(s, {16, 0, 0}), value(s.form, {0.5, 0, 0}) >= 0);
}

TEST(Shell, RoundsCoefficientsToFloats) {
  FreeForm form{{Vec3d(0.1), Vec3d(0.2), Vec3d(0.3), 0.4}, {{{ellipsoid({}, Vec3d(3)), {}}, 0.7}}};
  const FreeForm rounded = round_to_float(form);
  EXPECT_EQ(rounded.base.square.x, double(0.1f));
  EXPECT_EQ(rounded.base.constant, double(0.4f));
  EXPECT_EQ(rounded.perturbations[0].strength, double(0.7f));
  EXPECT_EQ(rounded, round_to_float(rounded));
}

TEST(Shell, ValidateNamesWhatIsWrong) {
  const auto broken = [](auto change) {
    Shell s = sample_shell(ShellKind::hard);
    change(s);
    return validate(s).value_or("valid");
  };
  EXPECT_EQ(broken([](Shell&) {}), "valid");
  EXPECT_TRUE(says(broken([](Shell& s) { s.hi.y = s.lo.y; }), "shell.box_empty"));
  EXPECT_NE(broken([](Shell& s) { s.form.base.constant = 0.1; }).find("float"), std::string::npos);
  EXPECT_NE(broken([](Shell& s) {
              s.form.perturbations[1].form.base.linear.y = std::numeric_limits<double>::infinity();
            }).find("finite"),
            std::string::npos);
  EXPECT_NE(broken([](Shell& s) { s.form.perturbations[0].strength = 0.5; }).find("strength"),
            std::string::npos);
  EXPECT_NE(broken([](Shell& s) { s.form.perturbations.resize(65); }).find("65"),
            std::string::npos);
  EXPECT_TRUE(says(broken([](Shell& s) { s.form.perturbations[0].form.perturbations.resize(1); }),
                   "shell.perturbation_itself_perturbed"));
  for (const double bound : {0.0, -1.0, std::numeric_limits<double>::quiet_NaN()}) {
    EXPECT_NE(broken([&](Shell& s) { s.certificate.bound = bound; }).find("certificate"),
              std::string::npos);
  }
}

}  // namespace shell_test
}  // namespace pvol
