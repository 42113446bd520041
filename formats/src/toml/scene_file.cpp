#include "pvol/formats/scene_file.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "pvol/error.h"
#include "toml/toml_table.h"

namespace pvol::formats {
namespace {

constexpr std::int64_t kLargestEdge = 1 << 20;  // of an image; far above any picture
constexpr int kDeepest = 16;                    // octree depth, as in RenderOptions
constexpr int kCoarsest = 8;                    // times that a preview halves the samples
constexpr double kLeastSine = 1e-6;  // of the angle between up and the view; the cross product of
                                     // two unit vectors is accurate to about 1e-16

// Sums of squares of radiance over all samples stay far inside double, and radiance inside float.
const Range kRadiance = Range::closed(0, 1e30);

template <class Enum>
Enum parse_name(const std::string& text, const char* what) {
  if (const auto value = find_named<Enum>(text)) return *value;
  std::string known;
  for (const std::string_view n : all_names<Enum>()) {
    known += (known.empty() ? "" : ", ") + std::string(n);
  }
  throw Error(std::string(what) + " " + toml_string(text) + " is unknown; expected one of " +
              known);
}

/// The value whose name a key has, if it is there.
template <class Enum>
std::optional<Enum> read_name(const TomlTable& table, std::string_view key) {
  const auto word = table.word(key, all_names<Enum>());
  return word ? find_named<Enum>(*word) : std::nullopt;
}

/// Puts the value of a key, where it has one, into `target`.
template <class T, class U>
void assign(T& target, const std::optional<U>& value) {
  if (value) target = T(*value);
}

/// Makes a relative file name of the scene relative to the current folder.
void resolve_file(TomlTable& root, std::string_view section, std::string_view key,
                  const std::filesystem::path& folder) {
  const auto resolve = [&](TomlTable& table) {
    for (TomlValue& value : table.members) {
      auto* text = std::get_if<std::string>(&value.value);
      if (value.key == key && text && !text->empty()) *text = (folder / *text).string();
    }
  };
  for (TomlValue& member : root.members) {
    if (member.key != section) continue;
    if (auto* table = std::get_if<TomlTable>(&member.value)) resolve(*table);
    if (auto* array = std::get_if<TomlArray>(&member.value)) {
      for (TomlValue& item : *array) {
        if (auto* table = std::get_if<TomlTable>(&item.value)) resolve(*table);
      }
    }
  }
}

std::filesystem::path read_file_name(const TomlTable& table) {
  const std::string file = table.string("file").value_or("");
  if (file.empty()) table.fail("file", "the name of a file");
  return file;
}

Camera read_camera(const TomlTable& table) {
  table.allow_only({"position", "target", "up", "fov"});
  table.require({"position", "target"});
  Camera camera;
  camera.position = *table.vector("position");
  camera.target = *table.vector("target");
  assign(camera.up, table.direction("up"));
  assign(camera.fov, table.number("fov", Range::open(0, 180)));
  const Vec3d view = camera.target - camera.position;
  if (view == Vec3d{}) table.fail("target", "another point than position");
  const double sine = length(cross(normalize(view), normalize(camera.up)));
  if (!(sine > kLeastSine)) {
    table.fail(table.has("up") ? "up" : "target",
               "up, by default [0, 1, 0], not along the line from position to target");
  }
  return camera;
}

/// Rotation by `degrees` about an axis through the origin (Rodrigues' formula).
Affine rotation(Vec3d axis, double degrees) {
  const double angle = degrees * (std::numbers::pi / 180);
  const double c = std::cos(angle), s = std::sin(angle);
  const Vec3d a = normalize(axis);
  Affine r;
  r.m[0] = Vec3d{c, -s * a.z, s * a.y} + a * (a.x * (1 - c));
  r.m[1] = Vec3d{s * a.z, c, -s * a.x} + a * (a.y * (1 - c));
  r.m[2] = Vec3d{-s * a.y, s * a.x, c} + a * (a.z * (1 - c));
  return r;
}

Affine read_matrix(const TomlTable& table) {
  for (const char* other : {"scale", "rotate", "translate"}) {
    if (table.has(other)) table.fail(other, "either matrix, or scale, rotate and translate");
  }
  const std::vector<double> v = *table.numbers("matrix", {12, 16});
  if (v.size() == 16 && !(v[12] == 0 && v[13] == 0 && v[14] == 0 && v[15] == 1)) {
    table.fail("matrix", "a last row of 0, 0, 0, 1; the translation stands in the last column");
  }
  Affine map;
  for (std::size_t row = 0; row < 3; ++row) {
    map.m[row] = {v[row * 4], v[row * 4 + 1], v[row * 4 + 2]};
    map.t[int(row)] = v[row * 4 + 3];
  }
  return map;
}

Affine read_placement(const TomlTable& table) {
  const bool matrix = table.has("matrix");
  Affine map;
  if (matrix) {
    map = read_matrix(table);
  } else {
    if (const auto scale = table.number_or_vector("scale")) map = scaling(*scale);
    if (const auto turns = table.rows("rotate", 4)) {
      for (const std::vector<double>& turn : *turns) {
        const Vec3d axis{turn[0], turn[1], turn[2]};
        if (!is_finite(normalize(axis))) table.fail("rotate", "an axis that is not zero");
        map = rotation(axis, turn[3]) * map;
      }
    }
    if (const auto move = table.vector("translate")) map = translation(*move) * map;
  }
  const Affine back = inverse(map);
  if (!is_finite(back.m[0]) || !is_finite(back.m[1]) || !is_finite(back.m[2])) {
    table.fail(matrix ? "matrix" : "scale", "a placement that can be undone, with no scale of 0");
  }
  return map;
}

/// What a medium and each of its further components have in common.
void read_matter(const TomlTable& table, Component& matter) {
  assign(matter.albedo, table.rgb("albedo", Range::closed(0, 1)));
  const Range g = Range::closed(-kLargestMeanCosine, kLargestMeanCosine);
  if (const auto cosine = table.number("g", g)) matter.phase = HenyeyGreenstein(*cosine);
  assign(matter.emission, table.rgb("emission", kRadiance));
}

/// The component that the table itself describes, with the share that the others leave, and those.
std::vector<Component> read_components(const TomlTable& table) {
  std::vector<Component> components{Component{}};
  read_matter(table, components.front());
  double left = 1;
  for (const TomlTable* t : table.tables("component")) {
    t->allow_only({"share", "albedo", "g", "emission"});
    t->require({"share"});
    Component c;
    c.share = *t->number("share", Range::closed(0, 1));
    left -= c.share;
    if (left < -kShareSlack) t->fail("share", "shares of components that sum up to at most 1");
    read_matter(*t, c);
    components.push_back(c);
  }
  components.front().share = std::max(0.0, left);
  return components;
}

/// The medium and the placement of a volume.
void read_medium(const TomlTable& table, SceneVolume& volume) {
  table.allow_only({"extinction", "albedo", "g", "emission", "component", "scale", "rotate",
                    "translate", "matrix"});
  assign(volume.medium.extinction, table.number("extinction", Range::at_least(0)));
  volume.has_extinction = table.has("extinction");
  volume.medium.components = read_components(table);
  volume.object_to_world = read_placement(table);
}

/// The volumes of a scene: the first has the scene's [medium], the others one of their own.
std::vector<SceneVolume> read_volumes(const std::vector<const TomlTable*>& tables,
                                      const TomlTable* medium_of_first) {
  std::vector<SceneVolume> volumes;
  for (const TomlTable* t : tables) {
    const bool first = volumes.empty();
    if (first) {
      t->allow_only({"file", "grid"});
    } else {
      t->allow_only({"file", "grid", "medium"});
    }
    SceneVolume& v = volumes.emplace_back();
    v.file = read_file_name(*t);
    v.grid = t->string("grid").value_or("");
    const TomlTable* medium = first ? medium_of_first : t->table("medium");
    if (medium) read_medium(*medium, v);
  }
  return volumes;
}

/// The type as given, else the one whose keys are there.
std::string environment_type(const TomlTable& table) {
  const auto type = table.word("type", {"constant", "gradient", "image"});
  return type                    ? *type
         : table.has("radiance") ? "constant"
         : table.has("file")     ? "image"
                                 : "gradient";
}

void read_environment(const TomlTable& table, SceneFile& result) {
  const std::string type = environment_type(table);
  if (type == "constant") {
    table.allow_only({"type", "radiance"});
    ConstantSky sky;
    assign(sky.radiance, table.rgb("radiance", kRadiance));
    result.scene.environment = sky;
  } else if (type == "gradient") {
    table.allow_only({"type", "zenith", "horizon", "ground", "up"});
    GradientSky sky;
    assign(sky.zenith, table.rgb("zenith", kRadiance));
    assign(sky.horizon, table.rgb("horizon", kRadiance));
    assign(sky.ground, table.rgb("ground", kRadiance));
    assign(sky.up, table.direction("up"));
    result.scene.environment = sky;
  } else {
    table.allow_only({"type", "file", "scale", "rotation"});
    ImageSky sky;
    assign(sky.scale, table.rgb("scale", kRadiance));
    assign(sky.rotation, table.number("rotation"));
    result.sky = read_file_name(table);
    result.scene.environment = sky;
  }
}

Sun read_sun(const TomlTable& table) {
  table.allow_only({"direction", "irradiance", "angle"});
  Sun sun;
  assign(sun.direction, table.direction("direction"));
  assign(sun.irradiance, table.rgb("irradiance", kRadiance));
  assign(sun.angle, table.number("angle", Range::half_open(0, 180)));
  if (sun.angle > 0 && sun.angle < 0.01) table.fail("angle", "0 or a number in [0.01, 180)");
  return sun;
}

/// A whole number in [lo, hi], or nothing where the key is absent or has the word for nothing.
std::optional<std::int64_t> read_limit(const TomlTable& table, std::string_view key,
                                       std::int64_t hi, const std::string& nothing) {
  const TomlValue* value = table.find(key);
  if (!value) return std::nullopt;
  if (const auto* text = std::get_if<std::string>(&value->value); text && *text == nothing) {
    return std::nullopt;
  }
  const auto* whole = std::get_if<std::int64_t>(&value->value);
  if (whole && *whole >= 0 && *whole <= hi) return *whole;
  table.fail(key, "a whole number in 0.." + std::to_string(hi) + " or " + toml_string(nothing));
}

/// A number that is not negative, or nothing where the key is absent or "off".
std::optional<double> read_tolerance(const TomlTable& table, std::string_view key) {
  const TomlValue* value = table.find(key);
  if (!value) return std::nullopt;
  if (const auto* text = std::get_if<std::string>(&value->value); text && *text == "off") {
    return std::nullopt;
  }
  return table.number(key, Range::at_least(0));
}

void read_crop(const TomlTable& table, RenderOptions& options) {
  const auto crop = table.integers("crop", {4}, 0, kLargestEdge);
  if (!crop) return;
  const auto& c = *crop;
  if (c[0] >= options.width || c[1] >= options.height || c[0] + c[2] > options.width ||
      c[1] + c[3] > options.height) {
    table.fail("crop", "[x, y, width, height] inside the image of " +
                           std::to_string(options.width) + " x " + std::to_string(options.height) +
                           " pixels");
  }
  options.crop_x = int(c[0]);
  options.crop_y = int(c[1]);
  options.crop_width = int(c[2]);
  options.crop_height = int(c[3]);
}

RenderOptions read_render(const TomlTable& table) {
  table.allow_only({"size", "crop", "spp", "seed", "tracker", "transmittance", "micro_bounds",
                    "interpolation", "shells", "guide", "depth", "max_bounces", "background",
                    "density", "density_tolerance", "majorant_scale", "homogenise", "preview"});
  constexpr auto kLargestCount = std::numeric_limits<std::uint32_t>::max();
  RenderOptions options;
  if (const auto size = table.integers("size", {2}, 1, kLargestEdge)) {
    options.width = int((*size)[0]);
    options.height = int((*size)[1]);
  }
  read_crop(table, options);
  assign(options.samples, table.integer("spp", 1, kLargestCount));
  assign(options.seed, table.integer("seed", 0, std::numeric_limits<std::int64_t>::max()));
  assign(options.tracker, read_name<Tracker>(table, "tracker"));
  assign(options.transmittance, read_name<Transmittance>(table, "transmittance"));
  assign(options.micro_bounds, read_name<MicroBoundsUse>(table, "micro_bounds"));
  assign(options.look_up, read_name<LookUp>(table, "interpolation"));
  assign(options.shells, read_name<ShellUse>(table, "shells"));
  assign(options.guide, read_name<GuideUse>(table, "guide"));
  if (const auto depth = read_limit(table, "depth", kDeepest, "auto")) options.depth = int(*depth);
  if (const auto limit = read_limit(table, "max_bounces", kLargestCount, "none")) {
    options.max_bounces = std::uint32_t(*limit);
  }
  assign(options.background, table.boolean("background"));
  assign(options.majorant_scale,
         table.number("majorant_scale", Range::closed(1 / kMostBoundsExcess, 1000)));
  options.homogenise = read_tolerance(table, "homogenise");
  assign(options.preview, table.integer("preview", 0, kCoarsest));
  return options;
}

std::optional<Quantisation> read_density(const TomlTable& table) {
  const auto word = table.word("density", {"stored", "fp32", "fp16", "fp8", "fpn"});
  const auto tolerance =
      table.number("density_tolerance", Range::closed(kLeastTolerance, kLargestTolerance));
  if (tolerance && word != "fpn") {
    table.fail("density_tolerance", "density = \"fpn\", with which it goes");
  }
  if (!word || *word == "stored") return std::nullopt;
  Quantisation density{parse_precision(*word)};
  assign(density.tolerance, tolerance);
  return density;
}

SceneFile read(const TomlTable& root) {
  if (root.has("recipe")) {
    throw Error(root.where + ": is a recipe of a cloud; expected a scene, with the recipe as the " +
                "file of its [volume]");
  }
  root.allow_only({"volume", "camera", "medium", "environment", "sun", "render"});
  root.require({"volume"});
  SceneFile result;
  const auto tables = root.tables("volume");
  const TomlTable* medium = root.table("medium");
  if (const TomlTable* camera = root.table("camera")) {
    result.scene.camera = read_camera(*camera);
    result.has_camera = true;
  }
  result.volumes = read_volumes(tables, medium);
  if (const TomlTable* sky = root.table("environment")) read_environment(*sky, result);
  for (const TomlTable* sun : root.tables("sun")) result.scene.lights.push_back(read_sun(*sun));
  if (const TomlTable* render = root.table("render")) {
    result.scene.options = read_render(*render);
    result.density = read_density(*render);
  }
  return result;
}

}  // namespace

SceneFile read_scene(const std::filesystem::path& file, const std::vector<std::string>& sets) {
  TomlTable root = parse_toml_file(file);
  resolve_file(root, "volume", "file", file.parent_path());
  resolve_file(root, "environment", "file", file.parent_path());
  for (const std::string& set : sets) apply_set(root, set);
  return read(root);
}

SceneFile default_scene(const std::filesystem::path& volume, const std::vector<std::string>& sets) {
  const std::string text = "[volume]\nfile = " + toml_string(volume.string()) + R"(
[[sun]]
direction = [-0.75, 0.62, 0.35]
irradiance = [3.3, 3.0, 2.6]
angle = 0.53
)";
  TomlTable root = parse_toml(text, "default scene");
  for (const std::string& set : sets) apply_set(root, set);
  return read(root);
}

Tracker parse_tracker(const std::string& name) { return parse_name<Tracker>(name, "tracker"); }
Transmittance parse_transmittance(const std::string& name) {
  return parse_name<Transmittance>(name, "transmittance");
}
MicroBoundsUse parse_micro_bounds(const std::string& name) {
  return parse_name<MicroBoundsUse>(name, "micro-bounds");
}
LookUp parse_interpolation(const std::string& name) {
  return parse_name<LookUp>(name, "interpolation");
}
ShellUse parse_shell_use(const std::string& name) { return parse_name<ShellUse>(name, "shells"); }
GuideUse parse_guide_use(const std::string& name) { return parse_name<GuideUse>(name, "guide"); }

}  // namespace pvol::formats
