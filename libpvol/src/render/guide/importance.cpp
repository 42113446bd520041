#include "render/guide/importance.h"

#include <cmath>
#include <numbers>

#include "pvol/math/direction.h"
#include "pvol/math/parallel.h"
#include "render/guide/mixture.h"
#include "render/path/camera_rays.h"
#include "render/path/first_collision.h"

namespace pvol::detail {
namespace {

constexpr int kLeastPhotons = 20'000, kMostPhotons = 200'000, kMostOfMany = 1'000'000;
constexpr double kUnit = 0.25;   // of the mean importance where camera rays meet the cloud
constexpr double kFloor = 0.02;  // of the mean importance of the cloud

[[nodiscard]] bool is_one(const PathSetup& setup) { return setup.is_one_still(); }
[[nodiscard]] bool is_empty(const VolumeSetup& v) { return v.volume.density.octree.empty(); }

[[nodiscard]] CoarseCells make_cells(const PathSetup& setup) {
  if (is_one(setup)) return make_coarse_cells(setup.volumes.front().volume);
  return make_world_cells(setup.scene_volumes, *setup.instances);
}

using Nodes = std::array<double, kDirectionNodes>;

/// Solid angle of the directions nearest to a node.
double solid_angle(int node) {
  constexpr double kStep = 1.0 / (kDirectionNodes - 1);
  const double lo = std::max(0.0, (node - 0.5) * kStep), hi = std::min(1.0, (node + 0.5) * kStep);
  return 4 * std::numbers::pi * (hi * hi - lo * lo);
}

/// Mean phase function between light that comes from a node of `IncidentLight` and directions of
/// flight nearest to a node, around the axis.
using Kernel = std::array<Nodes, kLightNodes>;

void add_phase(const PhaseFunction& phase, double weight, Kernel& kernel) {
  // Evenly over the shares of what is scattered and over half the circle, by symmetry.
  constexpr int kShares = 256, kTurns = 16;
  for (int i = 0; i < kLightNodes; ++i) {
    const double u = double(i) / (kLightNodes - 1);
    const Vec3f light(Vec3d(2 * u * std::sqrt(1 - u * u), 0, 1 - 2 * u * u));
    for (int share = 0; share < kShares; ++share) {
      const float u_share = (float(share) + 0.5f) / kShares;
      for (int k = 0; k < kTurns; ++k) {
        const float azimuth = (float(k) + 0.5f) / (2 * kTurns);
        const Vec3f d = sample_phase(phase, light, u_share, azimuth).direction;
        const float at = half_sine(d, Vec3f(0, 0, 1)) * float(kDirectionNodes - 1) + 0.5f;
        const int node = std::min(int(at), kDirectionNodes - 1);
        kernel[std::size_t(i)][std::size_t(node)] +=
            weight / (kShares * kTurns * solid_angle(node));
      }
    }
  }
}

/// What all components together make of incident light.
Kernel scattering_kernel(const std::vector<Share>& components) {
  Kernel kernel{};
  for (const auto& [m, share] : components) {
    add_phase(m->phase, double(share * luminance(m->albedo)), kernel);
  }
  return kernel;
}

/// The lobe of directions from which the axis' light scatters, for all components together.
HenyeyGreenstein mean_lobe(const std::vector<Share>& components) {
  float sum = 0;
  for (const auto& [m, share] : components) sum += share * float(mean_cosine(m->phase));
  return HenyeyGreenstein(std::clamp(double(sum), 0.0, kLargestMeanCosine));
}

/// Power scattered per steradian of each cell, by direction of flight.
std::vector<Nodes> scattered_power(const IncidentLight& light, const Kernel& kernel) {
  std::vector<Nodes> all(light.collided.size());
  parallel_for(0, all.size(), [&](std::size_t row) {
    for (std::size_t i = 0; i < kLightNodes; ++i) {
      const double power = double(light.collided[row][i]);
      if (power == 0) continue;
      for (std::size_t j = 0; j < kDirectionNodes; ++j) all[row][j] += power * kernel[i][j];
    }
  });
  return all;
}

/// Calls visit(row, weight) for a row and those of its neighbours that hold density, with the
/// weights of a blur by 1-2-1 along each axis.
template <class Visit>
void visit_neighbours(const CoarseCells& cells, std::size_t row, const Visit& visit) {
  for (int neighbour = 0; neighbour < 27; ++neighbour) {
    const Vec3i step(neighbour / 9 - 1, neighbour / 3 % 3 - 1, neighbour % 3 - 1);
    const Vec3i c = cells.places[row] + step;
    if (min(c, Vec3i(0)) != Vec3i(0) || max(c + Vec3i(1), cells.size) != cells.size) continue;
    const std::uint32_t other = cells.rows[cells.index(c)];
    if (other == 0) continue;
    visit(other, (step.x ? 1 : 2) * (step.y ? 1 : 2) * (step.z ? 1 : 2));
  }
}

/// Power over mass, both blurred.
std::vector<Nodes> blurred_radiance(const CoarseCells& cells, const std::vector<Nodes>& power) {
  std::vector<Nodes> all(cells.count());
  parallel_for(1, cells.count(), [&](std::size_t row) {
    double mass = 0;
    visit_neighbours(cells, row, [&](std::uint32_t other, int weight) {
      mass += weight * cells.mass[other];
      for (std::size_t j = 0; j < kDirectionNodes; ++j) all[row][j] += weight * power[other][j];
    });
    for (double& v : all[row]) v /= mass;
  });
  return all;
}

/// Draws the radiance of cells that few photons reached towards the mean of all: so many photons
/// stand for it. Many clouds share the photons, and paths that are ended for want of them come back
/// too bright.
void draw_to_mean(const IncidentLight& light, const CoarseCells& cells, int photons,
                  std::vector<Nodes>& radiance) {
  constexpr double kPrior = 32;
  Nodes mean{};
  double mass = 0;
  for (std::size_t row = 1; row < cells.count(); ++row) {
    mass += cells.mass[row];
    for (std::size_t j = 0; j < kDirectionNodes; ++j) {
      mean[j] += cells.mass[row] * radiance[row][j];
    }
  }
  for (double& v : mean) v /= mass;
  const double unit = light.power / photons;
  parallel_for(1, cells.count(), [&](std::size_t row) {
    double sum = 0;
    visit_neighbours(cells, row, [&](std::uint32_t other, int weight) {
      for (const float power : light.collided[other]) sum += weight * double(power);
    });
    const double count = sum / unit / 8;  // as of the cell itself, which has the weight 8
    for (std::size_t j = 0; j < kDirectionNodes; ++j) {
      radiance[row][j] = (count * radiance[row][j] + kPrior * mean[j]) / (count + kPrior);
    }
  });
}

/// Irradiance of a light in a coarse cell.
Rgb irradiance_in(const PathSetup& setup, const CoarseCells& cells, std::size_t light,
                  std::size_t row) {
  const Box box = cells.world_cube(row);
  return std::visit([&](const auto& l) { return l.irradiance_on(box); },
                    setup.light.sources[light]);
}

/// In proportion to the spread of an analog shadow ray, nearly: the root of the mean transmittance
/// T, which is the power that collides straight from the light over mass and irradiance, and of
/// a little besides, because T is not the same all over a cell. Rough near a point light, whose
/// irradiance varies from cell to cell.
std::vector<float> shadow_importances(const PathSetup& setup, const CoarseCells& cells,
                                      const IncidentLight& light) {
  constexpr double kGain = 7.5;  // over the plain tracer, where light arrives for certain
  constexpr double kLeast = 0.02;
  const std::size_t lights = setup.light.sources.size();
  std::vector<float> all(cells.count() * (lights + 1), 1.0f);
  parallel_for(1, cells.count(), [&](std::size_t row) {
    for (std::size_t i = 0; i < lights && !setup.stopped(); ++i) {
      double power = 0, mass = 0;
      visit_neighbours(cells, row, [&](std::uint32_t other, int weight) {
        power += weight * double(light.direct[other * lights + i]);
        mass += weight * cells.mass[other];
      });
      const double full = mass * double(luminance(irradiance_in(setup, cells, i, row)));
      const double t = full > 0 ? power / full : 0;
      all[row * (lights + 1) + i] = float(kGain * std::sqrt(std::min(1.0, t + kLeast)));
    }
  });
  return all;
}

double mean_over_directions(const Nodes& v) {
  double sum = 0;
  for (int j = 0; j < kDirectionNodes; ++j) sum += v[std::size_t(j)] * solid_angle(j);
  return sum / (4 * std::numbers::pi);
}

/// Rows of the sum of the radiance and a floor under it; row 0, of no density, holds the mean.
PagedVector<Importance::Row> make_rows(const CoarseCells& cells,
                                       const std::vector<Nodes>& radiance) {
  double sum = 0, mass = 0;
  for (std::size_t row = 1; row < cells.count(); ++row) {
    sum += cells.mass[row] * mean_over_directions(radiance[row]);
    mass += cells.mass[row];
  }
  const double mean = mass > 0 ? sum / mass : 0;
  PagedVector<Importance::Row> rows(cells.count());
  rows[0].at.fill(float(mean));
  for (std::size_t row = 1; row < cells.count(); ++row) {
    for (std::size_t j = 0; j < kDirectionNodes; ++j) {
      rows[row].at[j] = float(radiance[row][j] + kFloor * mean);
    }
  }
  return rows;
}

/// Mean importance where camera rays of the whole image first collide; 0 where none does.
double mean_seen(const PathSetup& setup, const Importance& importance) {
  constexpr int kRays = 4096;
  constexpr std::uint64_t kKey = 0x63616d657261;
  double sum = 0;
  int hits = 0;
  for (int i = 0; i < kRays && !setup.stopped(); ++i) {
    Rng rng(kKey, 0, std::uint64_t(i));
    const auto [x, y] = rng.uniform2();
    const Ray ray = setup.view.projection.ray(double(x) * setup.options.width,
                                              double(y) * setup.options.height);
    const float time = setup.moving ? sample_time(setup, {0, 0, std::uint32_t(i)}) : 0;
    const auto place = first_collision(setup, ray, time, rng);
    if (!place) continue;
    const Importance::Row& row = importance.row(*place);
    sum += double(row.of(importance.half_sine(row, Vec3f(ray.d))));
    ++hits;
  }
  return hits > 0 ? sum / hits : 0;
}

/// The value that half of the sky lies below, by channel.
Rgb median_radiance(const SkyLight& sky) {
  constexpr int kDirections = 4096;
  std::vector<Rgb> samples;
  for (int i = 0; i < kDirections; ++i) {
    samples.push_back(sky.radiance(Vec3f(direction_on_spiral(i, kDirections))));
  }
  Rgb median;
  for (int c = 0; c < 3; ++c) {
    const auto middle = samples.begin() + kDirections / 2;
    std::nth_element(samples.begin(), middle, samples.end(),
                     [&](const Rgb& a, const Rgb& b) { return a[c] < b[c]; });
    median[c] = (*middle)[c];
  }
  return median;
}

/// The radiance that is best left out of guided paths: what most of the sky has.
Rgb constant_part(const Environment& environment, const SkyLight& light) {
  if (const auto* sky = std::get_if<ConstantSky>(&environment)) return sky->radiance;
  if (const auto* sky = std::get_if<GradientSky>(&environment)) {
    return sky->horizon * 0.5f + (sky->zenith + sky->ground) * 0.25f;  // the mean
  }
  return median_radiance(light);
}

/// More photons make less noise, as long as they take little of the picture's time: one for 80
/// samples in lanes, for 40 of many volumes, which share them.
int count_photons(const PathSetup& setup) {
  const bool many = !is_one(setup);
  const RenderOptions& o = setup.options;
  const double samples = double(o.width) * o.height * expected_samples(o);
  return int(std::clamp(samples / (many ? 40 : 80), double(kLeastPhotons),
                        double(many ? kMostOfMany : kMostPhotons)));
}

}  // namespace

std::optional<Importance> make_importance(const PathSetup& setup) {
  if (std::ranges::all_of(setup.volumes, is_empty)) return std::nullopt;
  CoarseCells cells = make_cells(setup);
  if (cells.count() < 2)
    return std::nullopt;  // density lies between the points that were looked at
  const int photons = count_photons(setup);
  const IncidentLight light = trace_photons(setup, cells, photons);
  if (!(light.power > 0) || setup.stopped()) return std::nullopt;
  const std::vector<Share> components = mixture(setup, cells);
  const auto power = scattered_power(light, scattering_kernel(components));
  std::vector<Nodes> radiance = blurred_radiance(cells, power);
  draw_to_mean(light, cells, photons, radiance);
  PagedVector<Importance::Row> rows = make_rows(cells, radiance);
  const HenyeyGreenstein lobe = mean_lobe(components);
  std::vector<float> importances = shadow_importances(setup, cells, light);
  const Importance unscaled(cells, light.axes, lobe, rows, importances);
  const double seen = mean_seen(setup, unscaled);
  if (!(seen > 0) || setup.stopped()) return std::nullopt;
  for (Importance::Row& row : rows) {
    for (float& v : row.at) v = float(double(v) / (kUnit * seen));
  }
  return Importance(std::move(cells), light.axes, lobe, std::move(rows), std::move(importances));
}

void guide_paths(const RenderPlan& plan, PathSetup& setup) {
  // What is constant is of no order of scattering, and paths that are cut short get less of it.
  const RenderOptions& o = plan.scene.options;
  const bool none = o.aovs.has(Aov::scattering) || o.max_bounces ||
                    (plan.surfaces != nullptr && !plan.surfaces->are_even());
  PathSetup guided(plan, none ? Rgb(0.0f) : constant_part(plan.scene.environment, setup.light.sky),
                   setup.dense);
  guided.stop = setup.stop;
  std::optional<Importance> importance = make_importance(guided);
  if (!importance) return;
  guided.importance = std::make_shared<const Importance>(std::move(*importance));
  setup = std::move(guided);
}

}  // namespace pvol::detail
