// Scenes as text.
#include <limits>

#include "pvol/error.h"
#include "pvol/formats/scene_file.h"
#include "toml/toml_table.h"

namespace pvol::formats {
namespace {

std::string array_text(const std::vector<std::string>& items) {
  std::string text = "[";
  for (const std::string& item : items) {
    if (text.size() > 1) text += ", ";
    text += item;
  }
  return text + "]";
}

template <class T>
std::string vector_text(Vec3<T> v) {
  return array_text({toml_number(v.x), toml_number(v.y), toml_number(v.z)});
}

std::string line(const char* key, const std::string& value) {
  return std::string(key) + " = " + value + "\n";
}

std::string camera_text(const Camera& camera) {
  return "\n[camera]\n" + line("position", vector_text(camera.position)) +
         line("target", vector_text(camera.target)) + line("up", vector_text(camera.up)) +
         line("fov", toml_number(camera.fov));
}

std::string matrix_text(const Affine& map) {
  std::vector<std::string> numbers;
  for (int row = 0; row < 3; ++row) {
    const Vec3d r = map.m[std::size_t(row)];
    for (const double v : {r.x, r.y, r.z, map.t[row]}) numbers.push_back(toml_number(v));
  }
  return array_text(numbers);
}

std::string matter_text(const Component& c) {
  return line("albedo", vector_text(c.albedo)) +
         line("g", toml_number(std::get<HenyeyGreenstein>(c.phase).mean_cosine)) +
         line("emission", vector_text(c.emission));
}

/// The first component is what the medium's table itself describes; its share follows from theirs.
std::string medium_text(const SceneVolume& v, const std::string& name) {
  const std::vector<Component>& all = v.medium.components;
  std::string text =
      "\n[" + name + "]\n" +
      (v.has_extinction ? line("extinction", toml_number(v.medium.extinction)) : "") +
      matter_text(all.front()) + line("matrix", matrix_text(v.object_to_world));
  for (std::size_t i = 1; i < all.size(); ++i) {
    text += "\n[[" + name + ".component]]\n" + line("share", toml_number(all[i].share)) +
            matter_text(all[i]);
  }
  return text;
}

std::string volume_text(const SceneVolume& v) {
  return line("file", toml_string(v.file.string())) + line("grid", toml_string(v.grid));
}

std::string environment_text(const Environment& environment, const std::filesystem::path& file) {
  const std::string head = "\n[environment]\n";
  if (const auto* sky = std::get_if<ConstantSky>(&environment)) {
    return head + line("type", "\"constant\"") + line("radiance", vector_text(sky->radiance));
  }
  if (const auto* sky = std::get_if<GradientSky>(&environment)) {
    return head + line("type", "\"gradient\"") + line("zenith", vector_text(sky->zenith)) +
           line("horizon", vector_text(sky->horizon)) + line("ground", vector_text(sky->ground)) +
           line("up", vector_text(sky->up));
  }
  const auto& sky = std::get<ImageSky>(environment);
  return head + line("type", "\"image\"") + line("file", toml_string(file.string())) +
         line("scale", vector_text(sky.scale)) + line("rotation", toml_number(sky.rotation));
}

struct LightText {
  std::string operator()(const Sun& sun) const {
    return "\n[[sun]]\n" + line("direction", vector_text(sun.direction)) +
           line("irradiance", vector_text(sun.irradiance)) + line("angle", toml_number(sun.angle));
  }
};

std::string render_text(const RenderOptions& o) {
  const auto whole = [](auto v) { return std::to_string(v); };
  return "\n[render]\n" + line("size", array_text({whole(o.width), whole(o.height)})) +
         line("crop", array_text({whole(o.crop_x), whole(o.crop_y), whole(o.crop_width),
                                  whole(o.crop_height)})) +
         line("spp", whole(o.samples)) + line("seed", whole(o.seed)) +
         line("tracker", toml_string(name(o.tracker))) +
         line("transmittance", toml_string(name(o.transmittance))) +
         line("micro_bounds", toml_string(name(o.micro_bounds))) +
         line("interpolation", toml_string(name(o.look_up))) +
         line("shells", toml_string(name(o.shells))) + line("guide", toml_string(name(o.guide))) +
         line("depth", o.depth ? whole(*o.depth) : "\"auto\"") +
         line("max_bounces", o.max_bounces ? whole(*o.max_bounces) : "\"none\"") +
         line("background", o.background ? "true" : "false") +
         line("majorant_scale", toml_number(o.majorant_scale)) +
         line("homogenise", o.homogenise ? toml_number(*o.homogenise) : "\"off\"") +
         line("preview", whole(o.preview));
}

std::string density_text(const std::optional<Quantisation>& density) {
  if (!density) return "";
  const std::string word = line("density", toml_string(name(density->precision)));
  if (density->precision != Precision::fpn) return word;
  return word + line("density_tolerance", toml_number(density->tolerance));
}

}  // namespace

std::string to_toml(const SceneFile& file) {
  const Scene& scene = file.scene;
  if (scene.options.seed > std::uint64_t(std::numeric_limits<std::int64_t>::max())) {
    throw Error("seed " + std::to_string(scene.options.seed) +
                " cannot be written to a scene; use one below 2^63");
  }
  const SceneVolume& first = file.volumes.front();
  std::string text = file.volumes.size() == 1 ? "[volume]\n" : "[[volume]]\n";
  text += volume_text(first);
  for (std::size_t i = 1; i < file.volumes.size(); ++i) {
    const SceneVolume& v = file.volumes[i];
    text += "\n[[volume]]\n" + volume_text(v) + medium_text(v, "volume.medium");
  }
  if (file.has_camera) text += camera_text(scene.camera);
  text += medium_text(first, "medium");
  text += environment_text(scene.environment, file.sky);
  for (const Light& light : scene.lights) text += std::visit(LightText{}, light);
  return text + render_text(scene.options) + density_text(file.density);
}

}  // namespace pvol::formats
