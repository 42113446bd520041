#include "render/check_scene.h"

#include <cmath>
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
  const RenderOptions& o = scene.options;
  require(o.width > 0 && o.height > 0, "image size: both sides must be at least 1 pixel");
  require(o.crop_x >= 0 && o.crop_y >= 0 && o.crop_width >= 0 && o.crop_height >= 0 &&
              o.crop_x < o.width && o.crop_y < o.height && o.crop_width <= o.width - o.crop_x &&
              o.crop_height <= o.height - o.crop_y,
          "crop: the rectangle must lie inside the image of " + std::to_string(o.width) + "x" +
              std::to_string(o.height));
  require(o.samples > 0, "samples per pixel: at least 1 is needed");
  const Camera& c = scene.camera;
  require(c.fov > 0 && c.fov < 180, "camera: the field of view must lie between 0 and 180 degrees");
  require(is_finite(c.position) && is_finite(c.target) && is_finite(c.up),
          "camera: position, target and up must be finite");
  const Vec3d forward = c.target - c.position;
  require(length(cross(forward, c.up)) > 1e-12 * length(forward) * length(c.up),
          "camera: target must differ from position, and up must not point along the view");
}

void check(const Volume& volume, const RenderOptions& o) {
  validate(volume.medium);
  require(volume.density.majorant_excess == 1 || is_weighted(o.tracker),
          "the volume's majorants do not hold, which takes a tracker with weights");
  const bool cells = o.look_up == LookUp::nearest || o.look_up == LookUp::trilinear;
  require(cells || (o.tracker != Tracker::regular && o.transmittance != Transmittance::regular),
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
