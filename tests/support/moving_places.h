// Places that move, and a scene to see them in.
#pragma once

#include <utility>
#include <vector>

#include "pvol/render/placement.h"
#include "pvol/volume/moving_places.h"
#include "support/lit_scenes.h"

namespace pvol::test {

/// A field at places as they are at a time, standing still.
[[nodiscard]] inline Volume still_at(const Field& f, const CloudScene& s,
                                     const std::vector<MovingPlace>& places, double time) {
  VolumeOptions o = s.volume_options();
  o.object_to_world = places.front().object.at(time);
  for (const MovingPlace& p : places) o.instances.push_back(p.instance.at(time));
  if (places.size() == 1 && places.front().instance == MovingMap{}) o.instances.clear();
  const Pyramid pyramid = build_pyramid(f.grid, s.options.look_up);
  return pvol::make_volume(f.grid, pyramid, s.medium.medium(), o);
}

[[nodiscard]] inline Volume moving(const Field& f, const CloudScene& s,
                                   const std::vector<MovingPlace>& places) {
  return move_places(still_at(f, s, places, 0), places, s.camera.shutter);
}

// Made member by member: of vectors in temporaries GCC 12 warns without a reason.
[[nodiscard]] inline Placement turned(Vec3d axis, double degrees) {
  Placement p;
  p.rotate = {{axis, degrees}};
  return p;
}
[[nodiscard]] inline Placement moved(Vec3d by) {
  Placement p;
  p.translate = by;
  return p;
}
[[nodiscard]] inline Placement scaled(Vec3d by) {
  Placement p;
  p.scale = by;
  return p;
}
[[nodiscard]] inline Placement matrix(const Affine& map) {
  Placement p;
  p.matrix = map;
  return p;
}
[[nodiscard]] inline MovingPlace place_of(MovingMap instance, MovingMap object) {
  MovingPlace p;
  p.instance = std::move(instance);
  p.object = std::move(object);
  return p;
}
[[nodiscard]] inline std::vector<MovingPlace> alone(MovingMap object) {
  return {place_of(MovingMap{}, std::move(object))};
}

[[nodiscard]] inline MovingMap between(const Placement& from, const Placement& to) {
  return MovingPlacement{from, to}.map();
}
[[nodiscard]] inline MovingMap shifted(Vec3d from, Vec3d to) {
  return between(moved(from), moved(to));
}

/// About a point beside it.
[[nodiscard]] inline MovingMap swinging() {
  return between({.scale = Vec3d(1, 0.8, 1.1),
                  .rotate = {{{0.2, 1, 0.1}, 10}, {{0, 0, 1}, -20}},
                  .translate = Vec3d(3, -2, 5)},
                 {.scale = Vec3d(1.3, 0.9, 0.8),
                  .rotate = {{{0.2, 1, 0.1}, 120}, {{0, 0, 1}, 25}},
                  .translate = Vec3d(9, 4, -6)});
}

/// Maps that say where they go in every way.
[[nodiscard]] inline std::vector<MovingMap> maps() {
  const Placement stretched{
      .matrix = Affine{{Vec3d{1, 0.3, 0}, Vec3d{-0.2, 1.4, 0.1}, Vec3d{0.3, 0, 0.8}}, {4, 5, 6}}};
  const Placement askew{
      .scale = Vec3d(0.7, 1.2, 1), .rotate = {{{1, 2, 3}, 100}}, .translate = Vec3d(-7, 3, 1)};
  return {
      MovingMap{},
      shifted({1, 2, 3}, {-9, 6, 14}),
      swinging(),
      between(turned({0, 1, 0}, 0), turned({0, 1, 0}, 700)),
      between(turned({0, 1, 0}, 30), turned({1, 0, 0}, 50)),
      between(stretched, askew),
      between(scaled(Vec3d(-1, 1, 1)), {.scale = Vec3d(-2, 0.5, 1), .rotate = {{{1, 1, 0}, 80}}})};
}

[[nodiscard]] inline CloudScene scene_of(Shutter shutter) {
  CloudScene s;
  s.medium.extinction = 0.4;
  s.medium.albedo = Rgb(0.95f);
  s.environment = ConstantSky{Rgb(0.5f)};
  s.lights = {Sun{{0.6, 0.8, 0.35}, Rgb(3.0f), 0}};
  s.camera.position = {8, 12, 130};
  s.camera.target = {8, 8, 8};
  s.camera.shutter = shutter;
  s.options.width = s.options.height = 16;
  s.options.samples = 256;
  s.options.threads = 1;
  return s;
}

/// So many that a tree is asked which, and that their maps are not all kept.
[[nodiscard]] inline std::vector<MovingPlace> crowd() {
  Placement from = scaled(Vec3d(0.3)), to = turned({0, 1, 0}, 60);
  to.scale = from.scale;
  std::vector<MovingPlace> places;
  for (int i = 0; i < 90; ++i) {
    const Vec3d at(double(i % 10) * 12 - 50, double(i / 10) * 12 - 50, i % 3 * 9);
    places.push_back(place_of(i % 4 ? shifted(at, at + Vec3d(4, 3 * (i % 7), -5)) : shifted(at, at),
                              between(from, to)));
  }
  return places;
}

}  // namespace pvol::test
