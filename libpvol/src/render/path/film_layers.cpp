#include "render/path/film_layers.h"

#include <algorithm>

#include "pvol/volume/motion.h"
#include "pvol/volume/moving_places.h"
#include "render/path/camera_rays.h"
#include "render/path/local_medium.h"
#include "volume/cell_look_up.h"

namespace pvol::detail {
namespace {

/// Layers of first collisions.
struct FirstCollisionLayer {
  Aov aov;
  const char* components;
  Vec3d (*value)(const PathSetup&, const PathResult&);
};

double depth_of(const PathSetup& s, Vec3d place) { return s.view.projection.depth(place); }

Vec3d depth_of(const PathSetup& s, const PathResult& r) {
  return Vec3d(depth_of(s, r.first.place));
}

/// Direction of steepest descent of the extinction, by differences over a voxel; 0 where that is
/// even. Of many clouds, those whose boxes end within half a voxel of the place may go unseen.
Vec3d normal_of(const PathSetup& s, const PathResult& r) {
  if (r.first_material) return r.first_normal;
  Vec3d sum;
  s.instances->tree.visit_at(r.first.place, [&](std::uint32_t i) {
    const Instance instance = s.instances->at_time(i, double(r.time));
    const Volume& v = s.volumes[instance.volume].volume;
    const Affine& to_cells = instance.world_to_cells;
    const Vec3d at = to_cells.point(r.first.place);
    Vec3d cells;  // the gradient in cells
    for (int axis = 0; axis < 3; ++axis) {
      constexpr double kHalf = 0.5;
      Vec3d step;
      step[axis] = kHalf;
      cells[axis] = double(extinction_in_cells(v, at + step, r.time)) -
                    double(extinction_in_cells(v, at - step, r.time));
    }
    // A gradient goes to the world by the transpose of the map to cells.
    for (int axis = 0; axis < 3; ++axis) {
      Vec3d unit;
      unit[axis] = 1;
      sum[axis] -= dot(to_cells.vector(unit), cells);
    }
  });
  const double size = length(sum);
  return size > 0 ? sum / size : Vec3d{};
}

Vec3d albedo_of(const PathSetup& s, const PathResult& r) {
  if (r.first_material) return Vec3d(r.first_material->albedo);
  const Instance hit = s.instances->at_time(r.first.instance, double(r.time));
  const VolumeSetup& v = s.volumes[hit.volume];
  const Rgb color = local_color({&v, hit.world_to_cells.point(r.first.place)}, r.time);
  Vec3d sum;
  for (const Component& c : v.volume.medium.components) sum += Vec3d(c.albedo * color) * c.share;
  return sum;
}

Vec3d velocity_of(const PathSetup& s, const PathResult& r) {
  if (r.first_material) {
    if (r.first_moves == nullptr) return {};
    const Vec3d own = inverse(r.first_moves->at(double(r.time))).point(r.first.place);
    return r.first_moves->velocity(own, double(r.time));
  }
  const Instance hit = s.instances->at_time(r.first.instance, double(r.time));
  const Vec3d cells = hit.world_to_cells.point(r.first.place);
  return velocity_at(s.volumes[hit.volume].volume, hit.place, hit.world_to_cells, cells,
                     double(r.time));
}

/// Adds the light of each source to its layer, as one term for each layer: there may be no more
/// terms than samples (kMostPacked).
void add_lights(const PathSetup& s, const PathResult& r, ExactSums::OfLayer* layers) {
  if (r.layers.size() <= s.layers.names.size()) {  // each has its own
    for (std::size_t k = 0; k < r.layers.size(); ++k) {
      add(layers[s.layers.of[k]].sum, Vec3d(r.layers[k]));
    }
    return;
  }
  std::vector<Vec3d> terms(s.layers.names.size());
  for (std::size_t k = 0; k < r.layers.size(); ++k) terms[s.layers.of[k]] += Vec3d(r.layers[k]);
  for (std::size_t l = 0; l < terms.size(); ++l) add(layers[l].sum, terms[l]);
}

/// Adds a first collision to the layer of what it hit.
void add_to_objects(const PathSetup& s, const PathResult& r, ExactSums::OfLayer* layers) {
  std::size_t object = r.first.instance;
  if (r.first_material) {
    const std::size_t number = s.surfaces->camera->number_of(*r.first_material);
    object = s.objects->first_surface + s.surfaces->seen[number];
  }
  add(layers[object].sum, Vec3d(double(r.first_weight)));
}

constexpr std::array kFirstCollisionLayers = std::to_array<FirstCollisionLayer>({
    {Aov::depth, "Z", &depth_of},
    {Aov::nearest, "Z", &depth_of},
    {Aov::position, "XYZ", [](const PathSetup&, const PathResult& r) { return r.first.place; }},
    {Aov::normal, "XYZ", &normal_of},
    {Aov::albedo, "RGB", &albedo_of},
    {Aov::velocity, "XYZ", &velocity_of},
});

}  // namespace

Film make_film(const RenderOptions& o) {
  Film f;
  f.width = o.width, f.height = o.height;
  const ImagePart part = image_part(o);
  f.x = part.x, f.y = part.y;
  f.crop_width = part.width, f.crop_height = part.height;
  f.pixels.resize(std::size_t(f.crop_width) * std::size_t(f.crop_height));
  f.first_sample = o.first_sample + o.part_begin;
  f.color_space = o.color_space;
  return f;
}

std::uint64_t count_samples(const Film& film, const ImagePart& part) {
  std::uint64_t n = 0;
  for (int y = part.y; y != part.y + part.height; ++y) {
    for (int x = part.x; x != part.x + part.width; ++x) n += film.at(x, y).samples;
  }
  return n;
}

std::vector<Layer> make_layers(const PathSetup& s, std::size_t pixels) {
  const AovSet& aovs = s.options.aovs;
  std::vector<Layer> layers;
  const auto add = [&](const std::string& name, const char* components = "RGB") -> Layer& {
    layers.push_back({name, std::vector<Vec3d>(pixels), components});
    return layers.back();
  };
  if (aovs.has(Aov::lights)) {
    for (const std::string& name : s.layers.names) add(name);
  }
  if (aovs.has(Aov::scattering)) {
    for (const char* name : kOrderLayers) add(name);
  }
  if (aovs.has(Aov::halves)) {
    for (const char* name : kHalfLayers) add(name).weights.resize(pixels);
  }
  if (aovs.has(Aov::transmittance_rgb)) add(row(Aov::transmittance_rgb).name);
  if (s.objects) {
    for (const std::string& name : s.objects->names) add(kObjectLayer + name, "Y");
  }
  for (const FirstCollisionLayer& of : kFirstCollisionLayers) {
    if (!aovs.has(of.aov)) continue;
    Layer& layer = add(row(of.aov).name, of.components);
    layer.least = of.aov == Aov::nearest;
    if (layer.least) {
      layer.sums.assign(pixels, Vec3d(kNothingMet));
    } else {
      layer.weights.resize(pixels);
    }
  }
  return layers;
}

namespace {

/// From the least to the largest depth in a box, also for a camera that moves: at times in between
/// at most as far from those of the next one as these are from each other.
Span depths_of(const PathSetup& s, const Affine& to_world, const Box& box) {
  if (!s.view.motion) return s.view.projection.depths(to_world, box);
  constexpr int kTimes = 16;
  Span all{}, last{};
  double margin = 0;
  for (int k = 0; k <= kTimes; ++k) {
    const double time = s.view.camera.shutter.at(double(k) / kTimes);
    const Affine seen = s.view.motion->to_middle(time) * to_world;
    const Span now = s.view.projection.depths(seen, box);
    if (k == 0) all = last = now;
    margin = std::max({margin, std::abs(now.t0 - last.t0), std::abs(now.t1 - last.t1)});
    all = {std::min(all.t0, now.t0), std::max(all.t1, now.t1)};
    last = now;
  }
  return {all.t0 - margin, all.t1 + margin};
}

}  // namespace

DeepFilm make_deep(const PathSetup& s, std::size_t pixels) {
  if (!s.options.deep) return {};
  double front = std::numeric_limits<double>::infinity(), back = -front;
  const auto add = [&](const Affine& to_world, const Box& box) {
    const Span depths = depths_of(s, to_world, box);
    front = std::min(front, depths.t0), back = std::max(back, depths.t1);
  };
  for (const Instance& at : s.instances->all) {
    const Volume& v = s.volumes[at.volume].volume;
    const Octree& tree = v.density.octree;
    if (tree.empty()) continue;
    if (place_moves(v, at.place)) {
      add({}, world_box(v.density, v, at.place));
    } else {
      add(inverse(at.world_to_cells), tree.support());
    }
  }
  front = std::max(front, 0.0);              // nothing behind the camera is seen
  if (!(front < back)) front = 0, back = 1;  // nor anything at all
  DeepFilm film{front, back, s.options.deep_bins, std::vector<std::vector<DeepBin>>(pixels)};
  if (s.surfaces) film.surfaces.resize(pixels);
  return film;
}

Film make_film(const PathSetup& setup) {
  Film film = make_film(setup.options);
  film.layers = make_layers(setup, film.pixels.size());
  film.deep = make_deep(setup, film.pixels.size());
  keep_exact_sums(film);
  if (setup.count) keep_counts(film);
  return film;
}

namespace {

/// The sample that a pixel is given next.
PixelSample next_sample(const Film& film, std::size_t pixel) {
  const auto width = std::size_t(film.crop_width);
  return {film.x + int(pixel % width), film.y + int(pixel / width),
          film.first_sample + film.pixels[pixel].samples};
}

}  // namespace

void add_to_deep(const PathSetup& s, const PathResult& r, std::size_t pixel, Film& film) {
  Vec3d place = r.first.place;
  if (s.view.motion) {
    place = s.view.motion->to_middle(double(sample_time(s, next_sample(film, pixel)))).point(place);
  }
  const double depth = depth_of(s, place);
  if (r.first_material) {
    film.deep.add_surface(pixel, depth, Vec3d(r.radiance - r.background), double(r.alpha));
  } else {
    film.deep.add(pixel, depth, Vec3d(r.radiance));
  }
}

void add_to_layers(const PathSetup& s, const PathResult& r, std::size_t pixel, ExactSums& sums,
                   Film& film) {
  auto next = sums.layers.begin();
  add_lights(s, r, &*next);
  if (r.in_layers()) next += std::ptrdiff_t(s.layers.names.size());
  for (const Rgb& part : r.orders) add((next++)->sum, Vec3d(part));
  if (s.options.aovs.has(Aov::halves)) {
    // By the sample's number in the picture, whatever part of it this film is.
    auto& half = next[next_sample(film, pixel).number % 2];
    add(half.sum, Vec3d(r.radiance));
    add(half.weight, 1);
    next += 2;
  }
  if (s.options.aovs.has(Aov::transmittance_rgb)) {
    add((next++)->sum, Vec3d(1.0 - double(r.alpha)) + Vec3d(r.tint));
  }
  if (s.objects) {
    if (r.first_weight != 0) add_to_objects(s, r, &*next);
    next += std::ptrdiff_t(s.objects->names.size());
  }
  if (r.first_weight == 0) return;
  for (const FirstCollisionLayer& of : kFirstCollisionLayers) {
    if (!s.options.aovs.has(of.aov)) continue;
    Layer& layer = film.layers[std::size_t(next - sums.layers.begin())];
    auto& [sum, weight] = *next++;
    const Vec3d value = of.value(s, r);
    if (layer.least) {
      layer.sums[pixel] = min(layer.sums[pixel], value);
    } else {
      add(sum, value * double(r.first_weight));
      add(weight, double(r.first_weight));
    }
  }
}

}  // namespace pvol::detail
