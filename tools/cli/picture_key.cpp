#include "cli/picture_key.h"

#include <string_view>

#include "pvol/formats/cloud.h"
#include "pvol/formats/content_hash.h"
#include "pvol/formats/pvol_file.h"
#include "pvol/formats/scene_files.h"
#include "pvol/formats/screen.h"

namespace pvol::cli {
namespace {

/// Options that bear on cost alone get their defaults.
void forget_costs(RenderOptions& options) {
  RenderOptions defaults;
  const Entries usual = entries(defaults);
  for (const Entry& e : entries(options)) {
    const bool forgotten =
        e.about.effect == Effect::cost || std::string_view(e.about.key) == "crop";
    if (forgotten) (void)e.set(find_key(usual, e.about.key)->value());
  }
}

}  // namespace

std::string picture_key(const formats::SceneFile& scene) {
  formats::SceneFile file = scene;
  forget_costs(file.scene.options);
  // Names of spaces mean what the configuration says.
  if (auto* sky = std::get_if<ImageSky>(&file.scene.environment);
      sky && !sky->color_space.empty() && !find_named<ColorSpace>(sky->color_space)) {
    sky->color_space += ' ' + formats::color_config_id();
  }
  visit_files(file, [](auto& name) {
    if (name.empty()) return;
    name = formats::ending(name) == ".pvol" ? formats::text_hash(formats::read_pvol_head(name))
                                            : formats::content_hash(name);
  });
  return formats::text_hash(formats::to_toml(file));
}

}  // namespace pvol::cli
