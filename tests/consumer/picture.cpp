// A whole picture: the manual is pvol/render/plan.h.
#include "consumer.h"
#include "pvol/render/render.h"

double mean_of_picture(const pvol::Volume& cloud) {
  pvol::Volume white = cloud;
  for (pvol::Component& c : white.medium.components) c.albedo = pvol::Rgb(1);
  pvol::Scene scene;
  scene.options.width = scene.options.height = 16;
  scene.options.samples = 16;
  scene.environment = pvol::ConstantSky{pvol::Rgb(1)};
  scene.camera = pvol::frame(white.density.world_box, /*aspect=*/1);
  const pvol::Film film = pvol::render(white, scene).film;
  double sum = 0;
  for (const pvol::PixelSums& p : film.pixels) sum += pvol::mean(p).y;
  return sum / double(film.pixels.size());
}
