#include "cli/filter_picture.h"

#include <fmt/format.h>

#include "cli/cli.h"
#include "cli/instructions.h"

namespace pvol::cli {
namespace {

/// Whether a layer was asked for, or belongs to every filtered film.
bool is_wanted(const Layer& layer, AovSet asked) {
  for (const Aov aov : {Aov::halves, Aov::depth, Aov::normal, Aov::albedo}) {
    const bool of_aov =
        aov == Aov::halves ? layer.name.starts_with("half_") : layer.name == row(aov).name;
    if (of_aov) return asked.has(aov);
  }
  return true;
}

}  // namespace

AovSet layers_for_filter() {
  AovSet all = denoising_aovs();
  all.add(Aov::transmittance);  // before a background, files have it nowhere else
  return all;
}

AovSet layers_for_sequence() {
  AovSet all = layers_for_filter();
  all.add(Aov::velocity);
  return all;
}

Scene with_needs_of_filter(const Scene& scene) {
  if (!is_adaptive(scene.options) && scene.options.samples < 2) {
    throw UsageError(
        "--denoise needs --spp 2 or more, since one sample gives no estimate of its noise");
  }
  Scene changed = scene;
  changed.options.aovs.add(denoising_aovs());
  return changed;
}

FilteredPicture filtered_picture(const Film& film, const Denoised& d) {
  return {with_colour(film, d), d.relative_error, d.relative_error_deviation, d.fireflies};
}

std::string error_text(const FilteredPicture& filtered) {
  return fmt::format("estimated error {} +- {:.2g} % of the mean",
                     readable(100 * filtered.relative_error),
                     100 * filtered.relative_error_deviation);
}

FilteredPicture filter_picture(const Film& film, const RenderOptions& asked,
                               const std::function<bool()>& stop) {
  Stopwatch watch;
  const double before = cpu_seconds();
  const Denoised d = denoise(film, {.threads = asked.threads, .stop = stop});
  FilteredPicture p = filtered_picture(film, d);
  std::erase_if(p.film.layers, [&](const Layer& l) { return !is_wanted(l, asked.aovs); });
  p.cpu_seconds = cpu_seconds() - before, p.wall_seconds = watch.lap();
  return p;
}

}  // namespace pvol::cli
