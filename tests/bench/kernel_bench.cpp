// One small picture by one SIMD kernel, over the library alone, so that emulators of processors
// that this machine is not can count what it costs: kernel_instructions.py.
//
//   kernel_bench KERNEL SCENE SAMPLES     KERNEL as in pvol-render --kernel; SCENE as in kScenes
//
// Prints how many camera samples were traced, and the picture's mean luminance.
#include <array>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

#include <tbb/global_control.h>

#include "pvol/bounds/pyramid.h"
#include "pvol/density/cumulus.h"
#include "pvol/render/render.h"
#include "pvol/render/scene_volume.h"
#include "pvol/volume/make_volume.h"

namespace {

using namespace pvol;

constexpr int kSize = 24;         // pixels along a side
constexpr int kResolution = 128;  // samples along the cloud's longest side

/// A scene, and what becomes of the one cloud in it.
struct Picture {
  Scene scene;
  Medium medium{.extinction = 40, .components = {{1, Rgb(0.999f), HenyeyGreenstein(0.85)}}};
  std::vector<Affine> places{Affine{}};  // one volume each
};

void add_ground(Picture& p) {
  PlaneSurface ground{.point = {0, -0.6, 0}};
  ground.material.albedo = Rgb(0.3f);
  p.scene.surfaces.emplace_back(ground);
}

void add_second_cloud(Picture& p) { p.places.push_back(translation({0.9, 0.4, -0.8})); }

void add_lamps(Picture& p) {
  for (int i = 0; i < 20; ++i) {
    p.scene.lights.emplace_back(
        PointLight{.position = {-2 + 0.2 * i, 1.2, 1}, .intensity = Rgb(0.5f)});
  }
}

void take_tricubic_look_ups(Picture& p) { p.scene.options.look_up = LookUp::tricubic; }

void differ_by_channel(Picture& p) { p.medium.extinction_color = Rgb(0.5f, 0.75f, 1.0f); }

struct NamedScene {
  std::string_view name;
  void (*add)(Picture&);
};
constexpr auto kScenes = std::to_array<NamedScene>({{"cloud", [](Picture&) {}},
                                                    {"ground", add_ground},
                                                    {"clouds", add_second_cloud},
                                                    {"lamps", add_lamps},
                                                    {"tricubic", take_tricubic_look_ups},
                                                    {"channels", differ_by_channel}});

Picture make_picture(std::string_view name) {
  for (const NamedScene& known : kScenes) {
    if (known.name != name) continue;
    Picture p;
    p.scene.lights.emplace_back(Sun{.direction = {-0.5, 0.75, 0.6}, .angle = 0.53});
    p.scene.options.width = p.scene.options.height = kSize;
    p.scene.options.threads = 1;
    p.scene.options.guide = GuideUse::off;
    known.add(p);
    return p;
  }
  throw std::runtime_error("no scene is called " + std::string(name));
}

void run(std::string_view kernel, std::string_view scene, std::uint32_t samples) {
  const std::optional<KernelKind> kind = find_named<KernelKind>(kernel);
  if (!kind) throw std::runtime_error("no kernel is called " + std::string(kernel));
  Picture p = make_picture(scene);
  p.scene.options.kernel = *kind;
  p.scene.options.samples = samples;

  Recipe recipe = make_recipe(Cumulus{.seed = 3});
  recipe.voxel = voxel_for(recipe, kResolution);
  const VoxelGrid grid = make_grid(recipe);
  const Pyramid pyramid = build_pyramid(grid, p.scene.options.look_up);
  std::vector<Volume> volumes;
  for (const Affine& place : p.places) {
    VolumeOptions options = volume_options(p.scene.options);
    options.object_to_world = place;
    volumes.push_back(make_volume(grid, pyramid, p.medium, options));
  }
  p.scene.camera = frame(volumes.front().density.world_box, /*aspect=*/1);

  const Film film = render(volumes, p.scene).film;
  double sum = 0;
  for (const PixelSums& pixel : film.pixels) sum += luminance(mean(pixel));
  std::printf("%d %.6g\n", kSize * kSize * int(samples), sum / double(film.pixels.size()));
}

}  // namespace

int main(int argc, char** argv) {
  const tbb::global_control alone(tbb::global_control::max_allowed_parallelism, 1);
  try {
    const int samples = argc == 4 ? std::atoi(argv[3]) : 0;
    if (samples < 1) throw std::runtime_error("usage: kernel_bench KERNEL SCENE SAMPLES");
    run(argv[1], argv[2], std::uint32_t(samples));
    return 0;
  } catch (const std::exception& e) {
    std::fprintf(stderr, "kernel_bench: error: %s\n", e.what());
    return 2;
  }
}
