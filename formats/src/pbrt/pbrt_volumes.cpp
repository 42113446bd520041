// pbrt's media as volumes.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <set>

#include "file/mesh_read.h"
#include "pbrt/pbrt_bounds.h"
#include "pbrt/pbrt_color.h"
#include "pbrt/pbrt_presets.h"
#include "pbrt/pbrt_world.h"
#include "pvol/error.h"
#include "pvol/formats/vdb.h"

namespace pvol::formats::detail {
namespace {

constexpr const char* kDensity = "density";
constexpr const char* kTemperature = "temperature";
constexpr const char* kGlow = "glow";

/// What a medium of pbrt has of its own to make a volume of.
struct Making {
  const PbrtPlaced& medium;
  const std::string& name;
  const PbrtMaking& scene;
  const PbrtDescription& from;
  SceneVolume volume{};
  Rgb absorption{};  ///< per unit of length and density

  void note(const std::string& text) const {
    scene.note(medium.where, fmt::format("medium \"{}\": {}", shown(name), text));
  }
};

/// Scattering and absorption by the name of a preset, which goes before cross sections, or by
/// these. Nothing, and a note, where the preset is not known.
std::optional<PbrtPreset> matter_of(const Making& m) {
  const auto color = [&](const char* name) {
    const auto c = color_of(m.medium, name, PbrtSpectrum::reflectance, *m.scene.notes);
    return c.value_or(Rgb(1.0f));
  };
  const PbrtPreset own{.name = "", .scattering = color("sigma_s"), .absorption = color("sigma_a")};
  if (m.medium.type != "homogeneous") return own;
  const std::string name = m.medium.parameters.word("preset", "");
  if (name.empty()) return own;
  const std::optional<PbrtPreset> preset = preset_of(name);
  if (!preset) {
    m.note(
        fmt::format("is left out: its preset \"{}\" is none of {}; give sigma_a and sigma_s "
                    "instead",
                    shown(name), preset_names()));
  }
  return preset;
}

/// Extinction, albedo and phase function.
void set_matter(Making& m, const PbrtPreset& matter) {
  const double scale = m.medium.parameters.number("scale", 1);
  const Vec3d a = Vec3d(matter.absorption) * scale;
  const Vec3d s = Vec3d(matter.scattering) * scale, all = a + s;
  const double most = max_component(all);
  if (!(min_component(all) >= 0) || !is_finite(all)) {
    fail_at(m.medium.where, "a medium of negative extinction",
            "sigma_a, sigma_s and scale above 0");
  }
  Medium& medium = m.volume.medium;
  Component& component = medium.components.front();
  medium.extinction = most;
  m.volume.has_extinction = true;
  for (int c = 0; c < 3; ++c) {
    medium.extinction_color[c] = most > 0 ? float(all[c] / most) : 1;
    component.albedo[c] = all[c] > 0 ? float(s[c] / all[c]) : 0;
  }
  m.absorption = Rgb(a);
  const double g = m.medium.parameters.number("g", 0);
  const double kept = std::clamp(g, -kLargestMeanCosine, kLargestMeanCosine);
  if (g != kept) m.note(fmt::format("g = {} is taken as {}", g, kept));
  component.phase = HenyeyGreenstein(kept);
}

/// The radiance by a temperature, as pbrt has it, in points along a grid's values: none below 100
/// K.
ColorRamp glow_of(double offset, double scale, double most) {
  constexpr int kPoints = 64;
  ColorRamp ramp;
  const double coldest = 100 / scale + offset;
  const double hottest = std::max(most, coldest * 1.001 + 1);
  for (int i = 0; i <= kPoints; ++i) {
    const double value = coldest + (hottest - coldest) * i / kPoints;
    const Rgb light = i == 0 ? Rgb(0.0f) : peak_normalised_blackbody((value - offset) * scale);
    for (std::size_t c = 0; c < 3; ++c) {
      ramp.channels[c].points.push_back({float(value), light[int(c)]});
    }
  }
  return ramp;
}

/// A medium that emits by its temperature: density times absorption times the radiance.
void set_temperature(Making& m, double most, double strength) {
  const PbrtParameters& p = m.medium.parameters;
  const double offset = p.number("temperatureoffset", p.number("temperaturecutoff", 0));
  const double scale = p.number("temperaturescale", 1);
  if (!(scale > 0)) fail_at(m.medium.where, "temperaturescale", "a number above 0");
  if (!(strength > 0) || (most - offset) * scale <= 100) return;
  Fire& fire = m.volume.fire.emplace();
  fire.field = kDensity, fire.color_by = kTemperature;
  fire.intensity = strength, fire.color = m.absorption;
  fire.colors = glow_of(offset, scale, most);
  m.volume.has_intensity = true;
}

/// Names the file that the volume's grids are written to.
std::string grids_file(const Making& m) {
  std::string name = m.scene.stem + "_";
  for (const char c : m.name) name += std::isalnum(static_cast<unsigned char>(c)) ? c : '_';
  std::set<std::string> taken;
  for (const PbrtScene::Grids& g : m.scene.scene->volumes) taken.insert(g.name);
  std::string file = name + ".vdb";
  for (int i = 2; taken.contains(file); ++i) file = fmt::format("{}_{}.vdb", name, i);
  return file;
}

struct Lattice {
  Vec3i size;
  Affine to_medium;  ///< samples at the centres of cells between p0 and p1
  Box box;
};

Lattice lattice_of(const Making& m, std::size_t count) {
  const PbrtParameters& p = m.medium.parameters;
  const Vec3i n{p.whole("nx", 1), p.whole("ny", 1), p.whole("nz", 1)};
  const bool fits =
      n.x >= 1 && n.y >= 1 && n.z >= 1 && double(n.x) * double(n.y) * double(n.z) == double(count);
  if (!fits) {
    fail_at(m.medium.where, fmt::format("{} samples for {} x {} x {}", count, n.x, n.y, n.z),
            "nx ny nz samples");
  }
  const Vec3d a = p.point("p0", {0, 0, 0}), b = p.point("p1", {1, 1, 1});
  const Box box = extend(extend(Box{}, a), b);
  const Vec3d size = box.extent(), cell{size.x / n.x, size.y / n.y, size.z / n.z};
  if (!(min_component(cell) > 0)) fail_at(m.medium.where, "p0 and p1 that span no volume", "a box");
  return {n, translation(box.lo + cell * 0.5) * scaling(cell), box};
}

VoxelGrid grid_of(const Making& m, const Lattice& at, const char* name,
                  const std::vector<double>& values) {
  const std::vector<float> samples(values.begin(), values.end());
  const DenseArray array{.values = samples.data(),
                         .size = at.size,
                         .stride = Vec3l{1, at.size.x, std::int64_t(at.size.x) * at.size.y}};
  try {
    VoxelGrid grid = make_grid(array, at.to_medium);
    grid.name = name;
    return grid;
  } catch (const Error& e) {
    throw Error(fmt::format("{}: \"{}\": {}", m.medium.where.text(), name, e.what()));
  }
}

/// What pbrt multiplies emission by at a place of [0, 1]^3 without Lescale: one sample in the
/// middle of the box, half of which is left at the middle of a face and 1/8 in a corner.
double fading(Vec3d at) {
  double product = 1;
  for (int axis = 0; axis < 3; ++axis) product *= 1 - std::abs(at[axis] - 0.5);
  return product;
}

/// Lescale of each sample.
std::vector<double> scales_of(const Making& m, const Lattice& at, std::size_t count) {
  std::vector<double> scales = m.medium.parameters.numbers("Lescale");
  if (!scales.empty() && scales.size() != count) {
    fail_at(m.medium.where, fmt::format("{} numbers in Lescale", scales.size()), "one per sample");
  }
  if (!scales.empty()) return scales;
  m.note("without Lescale its emission fades to 1/8 in the corners of p0 and p1, as pbrt has it");
  for (int z = 0; z < at.size.z; ++z) {
    for (int y = 0; y < at.size.y; ++y) {
      for (int x = 0; x < at.size.x; ++x) {
        scales.push_back(
            fading({(x + 0.5) / at.size.x, (y + 0.5) / at.size.y, (z + 0.5) / at.size.z}));
      }
    }
  }
  return scales;
}

/// The fire's strength by place: Lescale times density.
VoxelGrid glow_grid(const Making& m, const Lattice& at, const std::vector<double>& density) {
  std::vector<double> glow = scales_of(m, at, density.size());
  for (std::size_t i = 0; i < glow.size(); ++i) glow[i] *= density[i];
  m.note("Lescale times density is taken as linear between samples");
  return grid_of(m, at, kGlow, glow);
}

/// Emission of a uniformgrid by Le or by temperatures.
void set_glow(Making& m, const Lattice& at, const std::vector<double>& density,
              std::vector<VoxelGrid>& grids) {
  const PbrtParameters& p = m.medium.parameters;
  const auto le = color_of(m.medium, "Le", PbrtSpectrum::light, *m.scene.notes);
  const std::vector<double> temperature = p.numbers(kTemperature);
  if (!temperature.empty()) {
    if (le) fail_at(m.medium.where, "Le and temperature in one medium", "one of them");
    if (temperature.size() != density.size()) {
      fail_at(m.medium.where, fmt::format("{} temperatures", temperature.size()), "one per sample");
    }
    grids.push_back(grid_of(m, at, kTemperature, temperature));
    set_temperature(m, *std::ranges::max_element(temperature), 1);
  } else if (le && max_component(*le) > 0) {
    m.volume.fire.emplace().color = *le * m.absorption;
    m.volume.has_intensity = true;
  } else if (p.find("Lescale") != nullptr) {
    m.note("Lescale without Le and temperature is left out");
  }
  if (!m.volume.fire) return;
  m.volume.fire->field = kGlow;
  grids.push_back(glow_grid(m, at, density));
}

std::optional<Box> make_uniform(Making& m) {
  const std::vector<double> density = m.medium.parameters.numbers(kDensity);
  if (density.empty()) fail_at(m.medium.where, "a uniformgrid without density", "its samples");
  const Lattice at = lattice_of(m, density.size());
  std::vector<VoxelGrid> grids{grid_of(m, at, kDensity, density)};
  set_glow(m, at, density, grids);
  m.note("its density fades over half a voxel beyond p0 and p1, while pbrt cuts it off");
  m.volume.file = grids_file(m);
  m.volume.grid = kDensity;
  m.scene.scene->volumes.push_back({m.volume.file.string(), std::move(grids)});
  return at.box;
}

/// The box around the samples of a grid that are not 0, in the grid's world.
Box samples_of(const VoxelGrid& grid) {
  Box box;  // in index space
  for (const Brick& b : grid.bricks) {
    for (int i = 0; i < kBrickSamples; ++i) {
      if (b.values[i] > 0) box = extend(box, Vec3d(b.origin + Vec3i{i / 64, i / 8 % 8, i % 8}));
    }
  }
  for (const Tile& t : grid.tiles) {
    const Vec3d lo(t.origin);
    box = join(box, Box{lo, lo + Vec3d(double(t.edge - 1))});
  }
  return transform(grid.index_to_world, box);
}

std::optional<Box> make_nanovdb(Making& m) {
  const PbrtParameters& p = m.medium.parameters;
  const std::string name = p.word("filename", "");
  if (name.empty()) fail_at(m.medium.where, "a nanovdb medium without filename", "its .nvdb file");
  m.volume.file = std::filesystem::absolute(m.scene.folder / name).lexically_normal();
  m.volume.grid = p.word("gridname", kDensity);
  const LoadedGrid density = read_nvdb(m.volume.file, {m.volume.grid, false});
  const double strength = p.number("LeScale", p.number("Lescale", 1));
  const std::vector<GridEntry> grids = list_nvdb(m.volume.file);
  const std::string temperature = p.word("temperaturename", kTemperature);
  const bool glows = std::ranges::any_of(
      grids, [&](const GridEntry& g) { return g.name == temperature && g.usable; });
  if (glows) {
    const LoadedGrid hot = read_nvdb(m.volume.file, {temperature, false});
    set_temperature(m, double(hot.report.largest), strength);
    if (m.volume.fire) m.volume.fire->field = m.volume.grid, m.volume.fire->color_by = temperature;
  }
  return samples_of(density.grid);
}

/// Whether what enters the shape enters the medium. A shape with it on both sides changes nothing.
bool lets_in(const PbrtShape& shape, const std::string& medium) {
  return shape.inside == medium && shape.outside != medium;
}

/// From the cube [0, 1]^3 to what a shape fills, in pbrt's world.
struct Filled {
  Affine from_cube;
  bool is_ball = false;
};

/// What a homogeneous medium fills: whole spheres and boxes. Others are named, and boxes where the
/// first is a ball or the other way round.
std::vector<Filled> filled_by(const Making& m) {
  std::vector<Filled> all;
  for (const PbrtShape& shape : m.from.shapes) {
    if (!lets_in(shape, m.name)) continue;
    const std::optional<PbrtHull> hull = hull_of(shape);
    if (hull && (all.empty() || all.front().is_ball == hull->is_ball)) {
      const Affine to_box = translation(hull->box.lo) * scaling(hull->box.extent());
      all.push_back({shape.place * to_box, hull->is_ball});
      continue;
    }
    m.scene.note(shape.where, fmt::format("medium \"{}\" inside this {} is left out: only whole "
                                          "spheres, or else boxes of triangles, are filled",
                                          shown(m.name), shown(shape.type)));
  }
  return all;
}

/// A grid of ones in a cube or the ball in it, once for each shape that the medium fills.
std::optional<Box> make_homogeneous(Making& m) {
  constexpr int kSamples = 64;
  const std::vector<Filled> filled = filled_by(m);
  if (filled.empty()) return std::nullopt;
  const Affine to_cube = translation(Vec3d(0.5 / kSamples)) * scaling(Vec3d(1.0 / kSamples));
  std::vector<float> values(std::size_t(kSamples) * kSamples * kSamples, 1.0f);
  for (std::size_t i = 0; filled.front().is_ball && i < values.size(); ++i) {
    const Vec3d at{double(i / (kSamples * kSamples)), double(i / kSamples % kSamples),
                   double(i % kSamples)};
    const double inside = (0.5 - length(to_cube.point(at) - Vec3d(0.5))) * kSamples;
    values[i] = float(std::clamp(inside + 0.5, 0.0, 1.0));
  }
  // The medium's transform does not move what fills a shape: the grid stands where the first does.
  const Affine first = filled.front().from_cube;
  VoxelGrid grid = make_grid({.values = values.data(), .size = Vec3i(kSamples)},
                             inverse(m.medium.place) * first * to_cube);
  for (const Filled& f : filled) {
    const Affine moved = f.from_cube * inverse(first);
    if (filled.size() > 1) {
      m.volume.instances.push_back(m.scene.world * moved * inverse(m.scene.world));
    }
  }
  m.note(fmt::format("becomes a grid of {}^3 samples that fills its {}, with edges one sample wide",
                     kSamples, filled.front().is_ball ? "sphere" : "box"));
  const auto le = color_of(m.medium, "Le", PbrtSpectrum::light, *m.scene.notes);
  const double strength = m.medium.parameters.number("Lescale", 1);
  if (le) m.volume.medium.components.front().emission = Rgb(Vec3d(*le) * strength);
  m.volume.file = grids_file(m);
  m.volume.grid = kDensity;
  m.scene.scene->volumes.push_back({m.volume.file.string(), {std::move(grid)}});
  return std::nullopt;  // it ends where the shape does
}

/// To add a kind of medium: its row. Makes the grids, and says which part of the medium's space
/// they fill, if shapes may cut it off.
struct MediumKind {
  const char* type;
  std::optional<Box> (*make)(Making&);
};
constexpr std::array<MediumKind, 3> kMediumKinds{
    {{"uniformgrid", make_uniform}, {"nanovdb", make_nanovdb}, {"homogeneous", make_homogeneous}}};

/// Names shapes that let the medium in and do not hold all of it.
void check_hulls(const Making& m, const Box& box) {
  for (const PbrtShape& shape : m.from.shapes) {
    if (!lets_in(shape, m.name)) continue;
    const std::optional<PbrtHull> hull = hull_of(shape);
    if (hull && contains(*hull, inverse(shape.place) * m.medium.place, box)) continue;
    m.scene.note(
        shape.where,
        fmt::format("the {} {} medium \"{}\", but pvol renders all of it", shown(shape.type),
                    hull ? "cuts off part of" : "may cut off part of", shown(m.name)));
  }
}

/// Names shapes within a medium that was made, inside which pbrt has another one or none: volumes
/// have no holes, and add up where they overlap. Surfaces hide what is inside.
void note_nested(const PbrtDescription& from, const PbrtMaking& making, const std::string& name) {
  for (const PbrtShape& shape : from.shapes) {
    if (shape.outside != name || shape.inside == name || !is_interface(shape)) continue;
    making.note(
        shape.where,
        fmt::format("medium \"{}\" is rendered inside this {}, too, where pbrt has {} instead",
                    shown(name), shown(shape.type),
                    shape.inside.empty() ? "none" : fmt::format("\"{}\"", shown(shape.inside))));
  }
}

void make_volume(const PbrtDescription& from, const PbrtMaking& making, const std::string& name,
                 const PbrtPlaced& medium) {
  const auto any = [&](auto condition) { return std::ranges::any_of(from.shapes, condition); };
  Making m{.medium = medium, .name = name, .scene = making, .from = from};
  if (!any([&](const PbrtShape& s) { return lets_in(s, name); })) {
    const bool on_both_sides = any([&](const PbrtShape& s) { return s.inside == name; });
    return m.note(on_both_sides
                      ? "is left out: its shapes have it on both sides (MediumInterface with "
                        "one name), which lets nothing in, as in pbrt"
                      : "is left out: no shape contains it");
  }
  const auto* kind = std::ranges::find(
      kMediumKinds, medium.type, [](const MediumKind& k) { return std::string_view(k.type); });
  if (kind == kMediumKinds.end()) {
    return m.note(
        fmt::format("is left out: media of type \"{}\" are not supported", shown(medium.type)));
  }
  const std::optional<PbrtPreset> matter = matter_of(m);
  if (!matter) return;
  set_matter(m, *matter);
  const std::optional<Box> box = kind->make(m);
  medium.parameters.note_unused(*making.notes, fmt::format("medium \"{}\"", shown(name)));
  if (m.volume.file.empty()) return;
  if (box) check_hulls(m, *box);
  note_nested(from, making, name);
  m.volume.object_to_world = making.world * medium.place;
  making.scene->file.volumes.push_back(std::move(m.volume));
}

}  // namespace

void make_volumes(const PbrtDescription& from, const PbrtMaking& making) {
  for (const auto& [name, medium] : from.media) make_volume(from, making, name, medium);
  for (const PbrtShape& shape : from.shapes) {
    for (const std::string& name : {shape.inside, shape.outside}) {
      const bool known =
          std::ranges::any_of(from.media, [&](const auto& m) { return m.first == name; });
      if (name.empty() || known) continue;
      fail_at(shape.where, fmt::format("medium \"{}\"", shown(name)),
              "one that MakeNamedMedium defines");
    }
  }
}

}  // namespace pvol::formats::detail
