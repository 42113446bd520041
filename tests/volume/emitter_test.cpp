// Fires: the colour of black bodies, emission at places, and what cannot be.
#include "pvol/volume/emitter.h"

#include <gtest/gtest.h>

#include <cmath>

#include "pvol/volume/blackbody.h"
#include "support/error_of.h"
#include "support/fields.h"
#include "support/messages.h"

namespace pvol::test {
namespace emitter_test {

TEST(Blackbody, HasThePublishedChromaticities) {
  // CIE 15:2004 and Wyszecki, Stiles, Color Science, table of the Planckian locus.
  constexpr double kPublished[][3] = {{1000, 0.6528, 0.3444}, {2000, 0.5267, 0.4133},
                                      {2856, 0.4476, 0.4074}, {4000, 0.3805, 0.3768},
                                      {6500, 0.3135, 0.3237}, {10'000, 0.2807, 0.2884}};
  for (const auto& [kelvin, x, y] : kPublished) {
    const Vec3d c = blackbody_chromaticity(kelvin);
    EXPECT_NEAR(c.x, x, 6e-4) << kelvin;
    EXPECT_NEAR(c.y, y, 6e-4) << kelvin;
  }
}

TEST(Blackbody, ColorsHaveLuminanceOneAndTurnFromRedToBlue) {
  float red = 1e9f, blue = -1;
  for (float kelvin = 100; kelvin < 1e5f; kelvin *= 1.01f) {
    const Rgb c = blackbody_color(kelvin);
    EXPECT_NEAR(luminance(c), 1, 1e-4f) << kelvin;
    EXPECT_LE(c.x, red * (1 + 1e-6f)) << kelvin;
    EXPECT_GE(c.z, blue) << kelvin;
    red = c.x, blue = c.z;
  }
  // About white between 6000 and 7000 K: Rec.709's white is D65, a little off the black body.
  const Rgb white = blackbody_color(6500);
  EXPECT_NEAR(white.x, 1.0f, 0.06f);
  EXPECT_NEAR(white.z, 1.0f, 0.06f);
  EXPECT_EQ(blackbody_color(1500).z, 0) << "beyond the gamut";
}

TEST(Blackbody, IsTabulatedFinely) {
  for (const float kelvin : {1034.5f, 1571.2f, 2345.6f, 6789.0f, 23'456.0f}) {
    const Vec3d c = blackbody_chromaticity(double(kelvin));
    const double x = c.x / c.y, z = c.z / c.y;
    const double red = std::max(0.0, 3.2404542 * x - 1.5371385 - 0.4985314 * z);
    const double green = std::max(0.0, -0.9692660 * x + 1.8760108 + 0.0415560 * z);
    const Rgb found = blackbody_color(kelvin);
    EXPECT_NEAR(double(found.x / found.y), red / green, 2e-3 * red / green) << kelvin;
  }
}

TEST(Blackbody, HasTheSameColourInEverySpace) {
  for (const float kelvin : {2800.0f, 5000.0f, 12'000.0f}) {  // within all gamuts
    const Vec3d c = blackbody_chromaticity(double(kelvin));
    for (const auto& space : names(ColorSpace{})) {
      const Vec3d found(blackbody_color(kelvin, space.value));
      EXPECT_NEAR(dot(found, luminance_weights(space.value)), 1, 1e-4) << space.name;
      const Vec3d back = conversion(space.value, ColorSpace::rec709).vector(found);
      EXPECT_NEAR(back.x / back.y,
                  (3.2404542 * c.x - 1.5371385 * c.y - 0.4985314 * c.z) /
                      (-0.9692660 * c.x + 1.8760108 * c.y + 0.0415560 * c.z),
                  3e-3 * back.x / back.y)
          << space.name;
    }
  }
  EXPECT_GT(blackbody_color(1500, ColorSpace::acescg).z, 0) << "within that gamut";
}

TEST(Fire, GlowsInItsColorSpace) {
  Fire fire{.kelvin = 1};
  fire.color_space = ColorSpace::acescg;
  EXPECT_EQ(emission(fire, 1, 3000), blackbody_color(3000, ColorSpace::acescg));
  EXPECT_NE(emission(fire, 1, 3000), blackbody_color(3000));
}

/// Flames that rise along x, and a temperature that falls along y, on lattices of their own.
const Field& flames() {
  static const Field f =
      make_field("flames", {0, 0, 0}, {24, 24, 24}, [](Vec3i p) { return p.x / 32.0; });
  return f;
}
const Field& heat() {
  static const Field f = make_field("temperature", {-8, -8, -8}, {48, 48, 48},
                                    [](Vec3i p) { return 3000 - 50.0 * p.y; });
  return f;
}

struct Bound {
  explicit Bound(const Field& f) : pyramid(build_pyramid(f.grid)), grid{f.grid, pyramid} {}
  Pyramid pyramid;
  BoundedGrid grid;
};

TEST(Emitter, EmitsByItsFields) {
  const Bound field(flames()), color(heat());
  Fire fire{.map = {.scale = 2, .power = 2}, .intensity = 3, .color = Rgb(1.0f, 0.5f, 2.0f)};
  const Vec3d place{10.5, 7.25, 13.75};
  const float mapped = float(std::pow(2 * 10.5 / 32, 2));
  const Emitter grey = make_emitter(fire, field.grid, nullptr, {});
  for (int c = 0; c < 3; ++c) {
    EXPECT_NEAR(emission_at(grey, place)[c], 3 * mapped * fire.color[c], 1e-5f);
  }
  fire.kelvin = 0.5;  // 1500 K less 25 a voxel
  fire.kelvin_of_intensity = 1000;
  const Emitter hot = make_emitter(fire, field.grid, &color.grid, {});
  const float kelvin = 0.5f * (3000 - 50 * 7.25f);
  const Rgb black = blackbody_color(kelvin);
  for (int c = 0; c < 3; ++c) {
    const float expected = 3 * mapped * fire.color[c] * black[c] * std::pow(kelvin / 1000, 4.0f);
    EXPECT_NEAR(emission_at(hot, place)[c], expected, 1e-4f * (1 + expected));
  }
  EXPECT_EQ(emission_at(hot, {-3, 5, 5}), Rgb(0.0f)) << "outside the flames";
}

TEST(Emitter, HasColorsAlongAField) {
  const Bound field(flames());
  Fire fire;
  for (std::size_t c = 0; c < 3; ++c) {
    fire.colors.channels[c].points = {{0, 0}, {0.5f, float(c)}, {1, 1}};
  }
  const Emitter e = make_emitter(fire, field.grid, nullptr, {});
  const Rgb at = emission_at(e, {8, 5, 5});  // 0.25 of half-way to (0, 1, 2)
  for (int c = 0; c < 3; ++c) EXPECT_NEAR(at[c], 0.25f * 0.5f * float(c), 1e-6f);
}

TEST(Emitter, IsPlacedWithItsVolume) {
  const Bound field(flames());
  const Affine place = translation({5, -7, 3}) * scaling(Vec3d(0.5));
  const Emitter at_origin = make_emitter({}, field.grid, nullptr, {});
  const Emitter placed = make_emitter({}, field.grid, nullptr, place);
  const Vec3d p{12.3, 4.5, 17.8};
  EXPECT_NEAR(emission_at(placed, place.point(p)).x, emission_at(at_origin, p).x, 1e-6f);
  EXPECT_TRUE(placed.field.world_box.contains(place.point(p)));
}

TEST(Emitter, RefusesWhatCannotBe) {
  const Bound field(flames());
  const auto refusal = [&](const Fire& fire) {
    return error_of([&] { (void)make_emitter(fire, field.grid, nullptr, {}); });
  };
  EXPECT_TRUE(says(refusal({.map = {.offset = 1}}), "fire.map_makes_fill"));
  EXPECT_NE(refusal({.intensity = -1}).find("intensity"), std::string::npos);
  EXPECT_NE(refusal({.kelvin_of_intensity = 1000}).find("kelvin"), std::string::npos);
  Fire both{.kelvin = 1};
  for (Ramp& r : both.colors.channels) r.points = {{0, 1}};
  EXPECT_NE(refusal(both).find("either"), std::string::npos);
}

}  // namespace emitter_test
}  // namespace pvol::test
