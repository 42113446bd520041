// Maps of densities, albedos and fires in lanes: the pictures of values that are mapped one by one.
#include <gtest/gtest.h>

#include <memory>
#include <string>
#include <vector>

#include "pvol/volume/albedo_field.h"
#include "pvol/volume/emitter.h"
#include "pvol/volume/make_volume.h"
#include "render/light/emission/emission_setup.h"
#include "support/lit_scenes.h"
#include "support/wavefront_shots.h"

namespace pvol::test {
namespace wavefront_maps_test {

/// The same ramp with more points than lanes ask one after the other, all beyond the fields'
/// values.
Ramp with_many_points(Ramp ramp) {
  const float last = ramp.points.back().y;
  for (int k = 0; k < 20; ++k) ramp.points.push_back({100.0f + float(k), last});
  return ramp;
}
/// One with as many among these values.
Ramp of_many_points() {
  Ramp ramp;
  for (int k = 0; k < 23; ++k)
    ramp.points.push_back({0.04f * float(k), 0.2f + 0.13f * float(k % 5)});
  return ramp;
}

Ramp uneven() { return {{{0.1f, 0}, {0.2f, 1.5f}, {0.5f, 0.25f}, {0.9f, 0.7f}}, false}; }

/// They make 0 of 0.
std::vector<FieldMap> maps() {
  return {{.ramp = uneven()},
          {.scale = 3, .offset = -0.7, .ramp = {{{0, 0}, {2, 1}}, false}},
          {.clamp = std::array{0.2, 0.6}, .power = 2, .ramp = uneven()},
          {.scale = 1.1, .power = 3, .ramp = uneven()}};
}

TEST(WavefrontMaps, OfDensitiesGiveTheBitsOfMapsOneByOne) {
  std::size_t turn = 0;
  const std::vector<FieldMap> all = maps();
  for (const KernelKind kernel : simd_kernels()) {
    ++turn;
    for (const LookUp look_up : {LookUp::trilinear, LookUp::nearest}) {
      for (const FieldMap& map : all) {
        const auto number = std::size_t(&map - all.data());
        if (!proof::has_turn(turn + number + (look_up == LookUp::nearest))) continue;
        CloudScene s = sunny();
        s.options.samples = 8;
        s.options.look_up = look_up;
        const auto picture = [&](const FieldMap& m) {
          VolumeOptions o = s.volume_options();
          o.map = std::make_shared<const FieldMap>(m);
          const Volume v =
              pvol::make_volume(puff().grid, build_pyramid(puff().grid), s.medium.medium(), o);
          s.camera = frame(v.density.world_box, 1);
          return render_with(kernel, {"", s, {v}}, s);
        };
        FieldMap many = map;
        many.ramp = with_many_points(map.ramp);
        const Film film = picture(map);
        EXPECT_GT(average(film).mean.x, 0);
        EXPECT_TRUE(same_bytes(film, picture(many)))
            << name(kernel) << ' ' << name(look_up) << ' ' << map.power;
      }
    }
  }
}

/// A field of numbers that lies askew in the puff, and does not cover all of it.
AlbedoField askew(const AlbedoMap& map) {
  const Affine place{{Vec3d{0.5, 0.3, 0}, Vec3d{-0.3, 0.45, 0.1}, Vec3d{0, -0.1, 0.6}}, {6, 9, 2}};
  return make_albedo_field(map, {puff().grid, build_pyramid(puff().grid)}, place);
}

TEST(WavefrontMaps, OfAlbedosGiveTheBitsOfThoseOneByOne) {
  const ColorRamp colors{{Ramp{{{0, 0.9f}, {0.4f, 1}, {1, 0.3f}}, false},
                          Ramp{{{0, 0.5f}, {0.4f, 0.8f}, {1, 1}}, false},
                          Ramp{{{0, 0.2f}, {0.4f, 0.9f}, {1, 0.6f}}, false}}};
  ColorRamp many = colors;
  for (Ramp& r : many.channels) r = with_many_points(r);
  std::size_t turn = 0;
  for (const KernelKind kernel : simd_kernels()) {
    for (const GuideUse guide : guides_in_turn(turn++, GuideUse::off)) {
      CloudScene s = sunny();
      s.options.samples = 8;
      s.options.guide = guide;
      const auto picture = [&](const AlbedoField& field) {
        Volume v = volume_of(s);
        v.albedo = std::make_shared<const AlbedoField>(field);
        return render_with(kernel, {"", s, {v}}, s);
      };
      std::vector<FieldMap> all = maps();
      all.push_back({.ramp = {{{0.5f, 0.8f}}, false}});
      for (const FieldMap& map : all) {
        const AlbedoField field = askew({.map = map, .colors = colors});
        AlbedoField searched = field;
        ASSERT_NE(field.values->leaves, nullptr);
        searched.values->leaves = nullptr;
        const Film film = picture(field);
        EXPECT_TRUE(same_bytes(film, picture(searched))) << "places of samples, one by one";
        EXPECT_TRUE(same_bytes(film, picture(askew({.map = map, .colors = many})))) << "ramps";
      }
      EXPECT_FALSE(same_bytes(picture(askew({})), picture(askew({.colors = colors}))));
      const AlbedoField field = askew({.map = {.ramp = of_many_points()}});
      AlbedoField searched = field;
      searched.values->leaves = nullptr;
      EXPECT_TRUE(same_bytes(picture(field), picture(searched))) << "ramps of many points";
    }
  }
}

/// Of the puff's density, which brings light at collisions, in the colours of another field.
std::shared_ptr<const Emitter> fire_in_the_puff(const Fire& fire) {
  const Pyramid pyramid = build_pyramid(puff().grid);
  Emitter e = make_emitter(fire, {puff().grid, pyramid}, nullptr, {});
  e.color_by = *askew({}).values;
  return std::make_shared<const Emitter>(std::move(e));
}

TEST(WavefrontMaps, OfFiresGiveTheBitsOfThoseOneByOne) {
  const ColorRamp colors{{uneven(), of_many_points(), with_many_points(uneven())}};
  const std::vector<Fire> fires{
      {.intensity = 0.3, .color = {1.0f, 0.6f, 0.3f}},
      {.map = {.power = 2, .ramp = uneven()}, .intensity = 0.7, .colors = colors},
      {.intensity = 1, .kelvin = 2500, .kelvin_of_intensity = 1800}};
  std::size_t turn = 0;
  for (const KernelKind kernel : simd_kernels()) {
    for (const Fire& fire : fires) {
      if (!proof::has_turn(turn++)) continue;
      CloudScene s = sunny();
      s.options.samples = 8;
      s.options.line_emission = LineEmission::off;
      const auto picture = [&](const std::shared_ptr<const Emitter>& emitter) {
        Volume v = volume_of(s);
        v.fire = emitter;
        if (emitter != nullptr) {
          EXPECT_TRUE(plan({&v, 1}, s.scene()).emission->lines.sources.empty()) << "some on lines";
        }
        return render_with(kernel, {"", s, {v}}, s);
      };
      Emitter searched = *fire_in_the_puff(fire);
      ASSERT_NE(searched.color_by->leaves, nullptr);
      searched.color_by->leaves = nullptr;
      const Film film = picture(fire_in_the_puff(fire));
      EXPECT_TRUE(same_bytes(film, picture(std::make_shared<const Emitter>(searched))))
          << name(kernel) << ' ' << fire.intensity;
      EXPECT_FALSE(same_bytes(film, picture(nullptr)));
    }
  }
}

}  // namespace wavefront_maps_test
}  // namespace pvol::test
