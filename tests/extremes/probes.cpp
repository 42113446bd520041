#include "extremes/probes.h"

#include <unistd.h>

#include <cmath>
#include <filesystem>
#include <map>
#include <mutex>
#include <sstream>

#include "pvol/error.h"
#include "pvol/formats/pvol_file.h"
#include "pvol/formats/vdb.h"
#include "pvol/shell/fit_shell.h"
#include "support/cloud_scene.h"
#include "support/fields.h"
#include "support/pictures.h"

namespace pvol::extremes {
namespace {

using test::CloudScene;
using test::Field;

double power_of_ten(int decade) { return std::pow(10.0, decade); }

/// The power of two next to a power of ten: scaling by it rounds nothing.
double power_of_two(int decade) { return std::exp2(std::round(decade * std::log2(10.0))); }

std::string words(double v) {
  std::ostringstream s;
  s.precision(3);
  s << v;
  return s.str();
}

/// Grids to be rendered as a setting says: a scene with its placed samples.
struct Clouds {
  CloudScene scene;
  VoxelGrid grid;
  const Shell* shell;  ///< of the samples, wherever they are placed

  [[nodiscard]] Film render(const Setting& s) {
    RenderOptions& o = scene.options;
    o.tracker = s.tracker, o.transmittance = s.transmittance, o.look_up = s.look_up;
    o.micro_bounds = s.micro_bounds, o.guide = s.guide;
    o.threads = 1;
    scene.medium.extinction /= s.volumes;
    const Pyramid pyramid = build_pyramid(grid, s.look_up);
    std::vector<Volume> volumes(std::size_t(s.volumes), test::make_volume(grid, pyramid, scene));
    if (s.shell) {
      volumes.front().shell = std::make_shared<const Shell>(*shell);
      o.shells = ShellUse::on;
    }
    return pvol::render(plan(volumes, scene.scene(), {.forecast = false})).film;
  }
};

Shell shell_of(const VoxelGrid& grid) {
  return fit_shell(make_support(grid, build_pyramid(grid)), {.perturbations = 2});
}

/// A blob with a hole in a small picture, in the sun and under a sky.
Clouds blob() {
  static const Field f = test::make_field("blob", {-8, -8, -8}, Vec3i(16), [](Vec3i p) {
    const double r2 = dot(Vec3d(p), Vec3d(p)) / 50;
    return r2 > 1 ? 0.0 : ((p.x >> 2 ^ p.y >> 2) & 1 ? 0.125 : 1.0) * (1 - 0.5 * r2);
  });
  static const Shell shell = shell_of(f.grid);
  Clouds c{.scene = {}, .grid = f.grid, .shell = &shell};
  c.scene.camera = {.position = {4, 6, 40}, .target = {0, 0, 0}};
  c.scene.camera.fov = 30;
  c.scene.medium.extinction = 0.5;
  c.scene.medium.albedo = Rgb(0.75f);
  c.scene.lights = {Sun{{0.6, 0.8, 0.35}, Rgb(2.0f), 0}};
  c.scene.options.width = c.scene.options.height = 8;
  c.scene.options.samples = 4;
  return c;
}

/// One pixel, so small that its rays are one, through the middle of 16^3 voxels of density 1. Every
/// interpolant makes the same optical depth of it: 16 times the extinction.
Clouds cube(double extinction) {
  static const Field f = test::make_field("cube", {0, 0, 0}, Vec3i(16), [](Vec3i) { return 1.0; });
  static const Shell shell = shell_of(f.grid);
  Clouds c{.scene = {}, .grid = f.grid, .shell = &shell};
  c.scene.camera = {.position = {7.4, 7.6, 100}, .target = {7.4, 7.6, 7.5}};
  c.scene.camera.fov = 1e-5;
  c.scene.medium.extinction = extinction;
  c.scene.medium.albedo = Rgb(0.0f);
  c.scene.environment = ConstantSky{Rgb(1.0f)};
  c.scene.options.width = c.scene.options.height = 1;
  c.scene.options.samples = 2000;
  return c;
}

bool all_finite(const Film& film) {
  for (const PixelSums& p : film.pixels) {
    if (!is_finite(p.sum) || !is_finite(p.sum_squares) || !std::isfinite(p.alpha)) return false;
  }
  return true;
}

/// The film against that of decade 0 times a factor.
Outcome against(const Film& film, const Film& reference, double factor = 1) {
  if (!all_finite(film)) return {Verdict::wrong, "a pixel is not finite"};
  Film scaled = reference;
  for (PixelSums& p : scaled.pixels) {
    p.sum *= factor, p.sum_squares *= factor * factor, p.group *= factor;
  }
  if (test::same_bytes(film, scaled)) return {};
  const test::Average a = test::average(film), b = test::average(scaled);
  const double off = std::abs(a.mean.y - b.mean.y),
               deviation = std::sqrt(a.variance.y + b.variance.y);
  const bool close = off <= 6 * deviation + 1e-6 * std::abs(b.mean.y);
  return {close ? Verdict::within : Verdict::wrong, "off by " + words(off / b.mean.y)};
}

/// Opacity, a mean of numbers in [0, 1], against its expectation.
Outcome opacity(const Film& film, double expected) {
  if (!all_finite(film)) return {Verdict::wrong, "a pixel is not finite"};
  const PixelSums& p = film.pixels.front();
  const double n = p.samples, found = p.alpha / n, off = std::abs(found - expected);
  if (off <= 1e-6) return {};
  const double deviation = std::sqrt(expected * (1 - expected) / n);
  const bool close = off <= 6 * deviation + 6 / n * (expected > 0 && expected < 1);
  return {close ? Verdict::within : Verdict::wrong,
          "opacity " + words(found) + " instead of " + words(expected)};
}

/// Radiance of every pixel against 1. A sample has a variance of `least` at least, also where no
/// sample shows it.
Outcome unit_radiance(const Film& film, double least = 0) {
  if (!all_finite(film)) return {Verdict::wrong, "a pixel is not finite"};
  const test::Average a = test::average(film);
  const double off = std::abs(a.mean.y - 1);
  if (off <= 1e-6) return {};
  const double samples = double(film.pixels.size()) * film.pixels.front().samples;
  const bool close = off <= 6 * std::sqrt(std::max(a.variance.y, least / samples)) + 1e-5;
  return {close ? Verdict::within : Verdict::wrong, "radiance " + words(a.mean.y)};
}

/// The blob of decade 0, made once for each setting.
Film reference(const Setting& s) {
  static std::mutex alone;
  static std::map<std::string, Film> made;
  const std::lock_guard lock(alone);
  const auto found = made.find(s.name);
  return found != made.end() ? found->second : made.emplace(s.name, blob().render(s)).first->second;
}

/// A cloud in a furnace: what it scatters and emits makes up for what it hides.
Clouds furnace() {
  Clouds c = blob();
  c.scene.lights.clear();
  c.scene.environment = ConstantSky{Rgb(1.0f)};
  c.scene.options.samples = 64;
  return c;
}

}  // namespace

Outcome world_unit(int decade, const Setting& s) {
  const double unit = power_of_two(decade);
  Clouds c = blob();
  c.grid.index_to_world = scaling(Vec3d(unit));
  c.scene.camera.position *= unit;
  c.scene.medium.extinction /= unit;
  return against(c.render(s), reference(s));
}

Outcome density_unit(int decade, const Setting& s) {
  const double unit = power_of_two(decade);
  Clouds c = blob();
  const Field scaled = test::make_field("blob", {-8, -8, -8}, Vec3i(16),
                                        [&](Vec3i p) { return unit * double(sample(c.grid, p)); });
  c.grid = scaled.grid;
  c.scene.medium.extinction /= unit;
  return against(c.render(s), reference(s));
}

Outcome brightness(int decade, const Setting& s) {
  const double unit = power_of_two(decade);
  Clouds c = blob();
  std::get<Sun>(c.scene.lights.front()).irradiance *= float(unit);
  GradientSky& sky = std::get<GradientSky>(c.scene.environment);
  for (Rgb* part : {&sky.zenith, &sky.horizon, &sky.ground}) *part *= float(unit);
  return against(c.render(s), reference(s), unit);
}

Outcome offset(int decade, const Setting& s) {
  const Vec3d away = Vec3d(1, -0.75, 0.5) * power_of_ten(decade);
  Clouds c = blob();
  c.grid.index_to_world = translation(away);
  c.scene.camera.position += away;
  c.scene.camera.target += away;
  return against(c.render(s), reference(s));
}

Outcome voxel_depth(int decade, const Setting& s) {
  const double extinction = power_of_ten(decade);
  Clouds c = cube(extinction);
  return opacity(c.render(s), -std::expm1(-16 * extinction));
}

Outcome camera_distance(int decade, const Setting& s) {
  Clouds c = cube(0.125);
  const double distance = power_of_ten(decade);
  c.scene.camera.position.z = 16.5 + distance;
  c.scene.camera.target.z = std::min(7.5, 16.5 + distance / 2);
  c.scene.camera.fov = std::min(1e-5, 1e-5 / distance);
  return opacity(c.render(s), -std::expm1(-2));
}

Outcome flatness(int decade, const Setting& s) {
  Clouds c = cube(0.125);
  c.grid.index_to_world = scaling({1, power_of_ten(decade), 1});
  c.scene.camera.position.y = c.scene.camera.target.y = 7.6 * power_of_ten(decade);
  c.scene.camera.fov = std::min(1e-5, 1e-5 * power_of_ten(decade));
  return opacity(c.render(s), -std::expm1(-2));
}

namespace {

/// 10^decade, 1 - 10^-decade above 0, 1/2 at 0.
double fraction(int decade) {
  if (decade == 0) return 0.5;
  return decade < 0 ? power_of_ten(decade) : 1 - power_of_ten(-decade);
}

std::string fraction_text(int decade) {
  if (decade == 0) return "1/2";
  return (decade < 0 ? "1e" : "1 - 1e-") + std::to_string(decade);
}

}  // namespace

Outcome cosine(int decade, const Setting& s) {
  Outcome worst;
  for (const double sign : {-1.0, 1.0}) {
    Clouds c = furnace();
    c.scene.medium.albedo = Rgb(1.0f);
    c.scene.medium.g = sign * fraction(decade);
    const Outcome o = unit_radiance(c.render(s));
    if (o.verdict > worst.verdict) worst = o;
  }
  return worst;
}

std::string cosine_text(int decade) { return "+-(" + fraction_text(decade) + ")"; }

Outcome albedo(int decade, const Setting& s) {
  Clouds c = furnace();
  c.scene.medium.albedo = Rgb(float(fraction(decade)));
  c.scene.medium.emission = Rgb(1.0f);
  // Of faint paths a roulette lets few through, with a throughput of 1/16.
  constexpr double kFaint = 1.0 / 16;
  return unit_radiance(c.render(s), fraction(decade) < kFaint ? fraction(decade) * kFaint : 0);
}

std::string albedo_text(int decade) { return fraction_text(decade); }

namespace {

/// A grid of voxels of this edge, turned and away from the origin.
VoxelGrid placed(double voxel) {
  VoxelGrid grid = blob().grid;
  Affine turn;
  turn.m = {Vec3d{0.6, -0.8, 0}, Vec3d{0.8, 0.6, 0}, Vec3d{0, 0, 1}};
  grid.index_to_world = translation(Vec3d(3, -5, 7) * voxel) * turn * scaling(Vec3d(voxel));
  return grid;
}

/// A file of the test's own, removed at the end.
struct ScratchName {
  std::filesystem::path file;
  explicit ScratchName(const std::string& ending)
      : file(std::filesystem::temp_directory_path() /
             ("pvol_extremes_" + std::to_string(getpid()) + ending)) {}
  ~ScratchName() {
    std::error_code ignored;
    std::filesystem::remove(file, ignored);
  }
  ScratchName(const ScratchName&) = delete;
  ScratchName& operator=(const ScratchName&) = delete;
};

Outcome same_map(const Affine& found, const Affine& expected) {
  if (found == expected) return {};
  double off = 0;
  for (std::size_t r = 0; r < 3; ++r) off = std::max(off, length(found.m[r] - expected.m[r]));
  const double relative = off / length(expected.m[2]);
  return {relative < 1e-12 ? Verdict::within : Verdict::wrong, "off by " + words(relative)};
}

}  // namespace

Outcome pvol_voxel(int decade, const Setting&) {
  const ScratchName name(".pvol");
  formats::PvolFile content;
  content.density = placed(power_of_ten(decade));
  content.metadata.grid_name = content.density->name;
  content.metadata.index_to_world = content.density->index_to_world;
  content.pyramid = build_pyramid(*content.density);
  formats::write_pvol(name.file, content);
  return same_map(formats::read_pvol(name.file).metadata.index_to_world,
                  content.metadata.index_to_world);
}

Outcome vdb_voxel(int decade, const Setting&) {
  const ScratchName name(".vdb");
  const VoxelGrid grid = placed(power_of_ten(decade));
  try {
    formats::write_vdb(name.file, {&grid});
  } catch (const Error& e) {  // the file's name is another one each time
    const std::string text = e.what();
    throw Error(text.substr(text.find(": ") + 2));
  }
  return same_map(formats::read_vdb(name.file).grid.index_to_world, grid.index_to_world);
}

Outcome random_scene(std::uint64_t number, const Setting& s) {
  Rng rng(0x65787472656d65, number, 0);
  const auto decades = [&](double from, double to) {
    return std::pow(10.0, from + (to - from) * to_uniform_double(rng.block().lo));
  };
  const double unit = decades(-15, 15), stretch = decades(-3, 3), away = decades(-15, 12);
  const double depth = decades(-15, 15);  // of the cube
  Clouds c = cube(depth / 16 / unit);
  const Vec3d move = Vec3d(away) * unit;
  c.grid.index_to_world = translation(move) * scaling(Vec3d(unit, unit * stretch, unit));
  const Vec3d to_world(unit, unit * stretch, unit);
  c.scene.camera.position = c.scene.camera.position * to_world + move;
  c.scene.camera.target = c.scene.camera.target * to_world + move;
  c.scene.camera.fov *= std::min(1.0, stretch);
  c.scene.environment = ConstantSky{Rgb(float(decades(-15, 15)))};
  c.scene.lights = {Sun{{0.3, 1, 0.2}, Rgb(float(decades(-15, 15))), 0}};
  c.scene.medium.g = (rng.uniform() < 0.5f ? -1 : 1) * std::min(0.9999, decades(-30, 0));
  c.scene.medium.albedo = Rgb(0.5f);
  c.scene.options.samples = 200;
  c.scene.options.max_bounces = 8;
  Setting unguided = s;  // bounces are limited
  unguided.guide = GuideUse::off;
  return opacity(c.render(unguided), -std::expm1(-depth));
}

}  // namespace pvol::extremes
