// EXR pictures, as skies, as films and with exact sums, and deep ones as films; Radiance pictures
// as skies.
#include "fuzz.h"
#include "pvol/formats/film_file.h"
#include "pvol/formats/image.h"

namespace {

using namespace pvol::fuzz;

void check(const pvol::ImageSky& sky) {
  require(sky.pixels.size() == std::size_t(sky.width) * std::size_t(sky.height),
          "a sky has other pixels than its size says");
}

void check(const pvol::Film& film) {
  const std::size_t pixels = std::size_t(film.crop_width) * std::size_t(film.crop_height);
  require(film.pixels.size() == pixels, "a film has other pixels than its size says");
  for (const pvol::Layer& layer : film.layers) {
    require(layer.sums.size() == pixels, "a layer has other pixels than its film");
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::filesystem::path file = scratch_file("input.exr", {data, size});
  accepts([&] { check(pvol::formats::read_sky(file)); });
  accepts([&] { check(pvol::formats::read_film(file).film); });
  accepts([&] { check(pvol::formats::flatten_exr(file).film); });
  accepts([&] { check(pvol::formats::read_film_file(file).film); });
  return 0;
}
