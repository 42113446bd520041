#include "render/check_scene.h"

#include <string>

#include "pvol/error.h"
#include "pvol/render/lights.h"

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
}

void check(const Volume& volume, const RenderOptions& o) {
  validate(volume.medium);
  require(volume.density.majorant_excess == 1 || is_weighted(o.tracker),
          "the volume's majorants do not hold, which takes a tracker with weights");
  require(has_closed_form(o.look_up) ||
              (o.tracker != Tracker::regular && o.transmittance != Transmittance::regular),
          "regular tracking and regular transmittance have closed forms for nearest and trilinear "
          "interpolation only; choose another tracker, transmittance or interpolation");
  require(volume.density.scale == float(volume.medium.extinction) &&
              volume.density.look_up == o.look_up &&
              (o.tracker != Tracker::delta_global || volume.density.octree.depth == 0),
          "the volume was made for another extinction, interpolation or tracker than the scene's");
}

}  // namespace

void check(std::span<const Volume> volumes, const Scene& scene) {
  check(scene);
  require(!volumes.empty(), "there is no volume to render");
  require(volumes.size() == 1 || !is_weighted(scene.options.tracker),
          "weighted trackers take one volume; choose another tracker for several");
  for (const Volume& v : volumes) check(v, scene.options);
}

}  // namespace pvol::detail
