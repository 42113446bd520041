#include "report/film_pictures.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "pvol/formats/image.h"
#include "pvol/measure/pixel_maps.h"
#include "report/colour_map.h"
#include "report/html.h"

namespace pvol::cli {

std::string film_image(const Film& film, double exposure, const std::string& description) {
  return html::image(formats::encode_png(formats::to_picture(film, {.exposure = exposure})),
                     description, true);
}

std::string difference_image(const Film& a, const Film& b, double full,
                             const std::string& description) {
  constexpr int kBlock = 4;
  const formats::Picture p = map_colours(measure::block_differences(a, b, kBlock), a.crop_width,
                                         ColourMap::diverging, -full, full);
  return html::image(formats::encode_png(p), description, true);
}

LookupMaps lookup_maps(std::span<const NamedFilm> films) {
  std::vector<std::vector<double>> lookups;
  std::vector<double> most;
  for (const NamedFilm& f : films) {
    lookups.push_back(measure::lookups_per_sample(*f.film));
    most.push_back(*std::max_element(lookups.back().begin(), lookups.back().end()));
  }
  LookupMaps maps;
  for (const double m : most) maps.most = std::max(maps.most, m);
  for (std::size_t i = 0; i < films.size(); ++i) {
    for (double& v : lookups[i]) v = std::log1p(v);
    const formats::Picture p =
        map_colours(lookups[i], films[i].film->crop_width, ColourMap::sequential, 0,
                    std::log1p(std::max(maps.most, 1.0)));
    maps.figures.push_back(
        {html::image(formats::encode_png(p), "look-ups of " + films[i].name, true),
         fmt::format("{}: {:.4g} look-ups a sample at most", films[i].name, most[i])});
  }
  return maps;
}

}  // namespace pvol::cli
