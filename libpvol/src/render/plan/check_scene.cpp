#include "render/plan/check_scene.h"

#include <algorithm>
#include <limits>
#include <string>

#include "math/digits.h"
#include "pvol/error.h"
#include "pvol/render/deep.h"
#include "pvol/render/lighting.h"
#include "pvol/render/lights.h"
#include "pvol/volume/emitter.h"
#include "pvol/volume/facts.h"
#include "pvol/volume/motion.h"
#include "pvol/volume/moving_places.h"
#include "render/light/lamp.h"
#include "volume/placement.h"

namespace pvol::detail {
namespace {

void require(bool ok, const std::string& message) {
  if (!ok) throw Error(message);
}

void check(const Scene& scene) {
  validate(scene.environment);
  for (const Light& light : scene.lights) validate(light);
  validate(scene.options);
  validate(scene.camera);
  for (const Surface& surface : scene.surfaces) validate(surface);
}

/// The places that a fire got from its volume, which was made without it.
void check_places(const Emitter& fire, const Volume& volume) {
  const std::size_t places = count_places(volume);
  for (std::size_t i = 1; i < places; ++i) {
    const Affine to_cells = fire.field.world_to_cells * to_first_place(volume, i);
    naming_place(i, places, [&] {
      check_placement(inverse(to_cells), to_cells, world_box(fire.field, volume, i));
    });
  }
}

/// Of what moves by velocities.
void check_shutter(const VolumeField& field, const Scene& scene) {
  require(field.motion == nullptr || field.motion->shutter == scene.camera.shutter,
          "the volume was made for another shutter than the camera's; make it again for this one");
}

/// Of a volume that moves.
void check_motion(const Volume& volume, const Scene& scene) {
  const RenderOptions& o = scene.options;
  check_shutter(volume.density, scene);
  require(o.tracker != Tracker::regular && o.transmittance != Transmittance::regular,
          "regular tracking and regular transmittance have no closed form for a volume that moves; "
          "choose another tracker or transmittance, or set the shutter to [0, 0]");
}

/// Of a volume that moves as a whole.
void check_moving_places(const Volume& volume, const Scene& scene) {
  require(volume.moving_places->shutter == scene.camera.shutter,
          "the volume's instances were made for another shutter than the camera's; make them again "
          "for this one");
}

void check(const Volume& volume, const RenderOptions& o) {
  validate(volume.medium);
  require(volume.density.majorant_excess == 1 || is_weighted(o.tracker),
          "the volume's majorants do not hold, which needs a weighted tracker; choose "
          "weighted-delta or weighted-decomposition");
  require(has_closed_form(o.look_up) ||
              (o.tracker != Tracker::regular && o.transmittance != Transmittance::regular),
          "regular tracking and regular transmittance have closed forms for nearest and trilinear "
          "interpolation only; choose another tracker, transmittance or interpolation");
  require(volume.density.map == nullptr ||
              (o.tracker != Tracker::regular && o.transmittance != Transmittance::regular),
          "regular tracking and regular transmittance have no closed form for a mapped density; "
          "choose another tracker or transmittance");
  require(volume.density.scale == float(volume.medium.extinction) &&
              volume.density.look_up == o.look_up &&
              (o.tracker != Tracker::delta_global || volume.density.octree.depth == 0),
          "the volume was made for another extinction, interpolation or tracker than the scene's; "
          "make it again for this scene");
  if (volume.fire != nullptr) check_places(*volume.fire, volume);
}

/// A layer for each object takes a film's memory for each.
void check_objects(std::span<const Volume> volumes, const Scene& scene) {
  constexpr std::size_t kMostObjects = 64;
  if (!scene.options.aovs.has(Aov::objects)) return;
  const std::size_t objects = count_places(volumes) + scene.surfaces.size();
  require(objects <= kMostObjects,
          "the layer objects tells " + std::to_string(objects) +
              " volumes, places of volumes and surfaces apart, expected at most " +
              std::to_string(kMostObjects) + "; render the others in another picture");
}

/// Deep pictures are made of samples that collide or do not, and of memory.
void check_deep(std::span<const Volume> volumes, const Scene& scene) {
  const RenderOptions& o = scene.options;
  require(std::ranges::none_of(scene.lights, camera_meets),
          "deep pictures consist of collisions, but paths meet lights with an extent (area, point "
          "with a radius) on their way; set visible_camera = false for them, or leave out the deep "
          "picture");
  require(
      std::ranges::none_of(volumes, [](const Volume& v) { return v.fire != nullptr; }) &&
          o.line_emission != LineEmission::on && o.line_lamps != LineLamps::on,
      "deep pictures consist of collisions, but fires, emission and lamps along flights add light "
      "all along a ray; leave out the fire or the deep picture, and leave line emission and line "
      "lamps at auto");
  require(!is_weighted(o.tracker),
          std::string("deep pictures count collisions, but those of the tracker ") +
              name(o.tracker) +
              " have weights; choose a tracker without weights, such as decomposition");
  const double pixels = double(o.crop_width ? o.crop_width : o.width - o.crop_x) *
                        double(o.crop_height ? o.crop_height : o.height - o.crop_y);
  constexpr double kUnlimited = std::numeric_limits<double>::infinity();
  const double bytes =
      most_deep_bytes(pixels, o.deep_bins, is_adaptive(o) ? kUnlimited : double(o.samples),
                      !scene.surfaces.empty());
  require(
      bytes <= kMostDeepBytes,
      "a deep picture of " + digits(pixels) + " pixels in " + std::to_string(o.deep_bins) +
          " bins of depth may need " + digits(bytes / 0x1p30) +
          " GiB of memory; expected at most 8: choose fewer bins, or render it in parts (crop)");
}

/// One tracker decides for several channels.
void check_chromatic(std::span<const Volume> volumes, const RenderOptions& o) {
  if (std::ranges::none_of(volumes, [](const Volume& v) { return is_chromatic(v.medium); })) return;
  require(!o.deep,
          "an extinction that differs by channel (extinction_color) can be combined only with flat "
          "pictures, since samples of deep ones have no weights");
  require(o.tracker != Tracker::regular,
          "regular tracking inverts one optical depth, but an extinction that differs by channel "
          "(extinction_color) has three; choose another tracker");
}

/// A black body glows in the colours of the space that its fire was made for.
void check_color_space(const Volume& v, ColorSpace space) {
  if (v.fire == nullptr || v.fire->fire.color_space == space) return;
  throw Error(std::string("a fire has colours in ") + name(v.fire->fire.color_space) +
              ", but the picture is to be in " + name(space) +
              "; make the fire with the color_space of the options");
}

}  // namespace

void check(std::span<const Volume> volumes, const Scene& scene) {
  check(scene);
  require(!volumes.empty(), "there is no volume to render; expected at least one");
  require(most_lights(scene) <= kMostLights, "the scene has " + std::to_string(most_lights(scene)) +
                                                 " lights; expected at most " +
                                                 std::to_string(kMostLights));
  check_chromatic(volumes, scene.options);
  check_objects(volumes, scene);
  if (scene.options.deep) check_deep(volumes, scene);
  for (const Volume& v : volumes) {
    check(v, scene.options);
    if (v.density.motion != nullptr) check_motion(v, scene);
    if (v.fire) check_shutter(v.fire->field, scene);
    check_color_space(v, scene.options.color_space);
    if (places_move(v)) check_moving_places(v, scene);
  }
}

}  // namespace pvol::detail
