#include "use_cloud.h"

#include <cmath>

#include "fuzz.h"
#include "pvol/embed.h"
#include "pvol/shell/ray_shell.h"
#include "pvol/volume/make_volume.h"

namespace pvol::fuzz {
namespace {

constexpr std::size_t kMostLeaves = 4096;
constexpr std::uint64_t kMostSamples = kMostLeaves * kBrickSamples;

std::uint64_t count_samples(const VoxelGrid& grid) {
  std::uint64_t samples = grid.bricks.size() * kBrickSamples;
  for (const Tile& t : grid.tiles) {
    const auto edge = std::uint64_t(t.edge);
    samples += edge * edge * edge;
  }
  return samples;
}

std::size_t count_nodes(const Pyramid& pyramid) {
  std::size_t nodes = 0;
  for (const auto& level : pyramid.levels) nodes += level.size();
  return nodes;
}

/// Rays along the axes and the diagonal of the box, through its middle.
void send_rays(const Volume& volume) {
  const Box& box = volume.density.world_box;
  const Vec3d middle = 0.5 * (box.lo + box.hi), size = box.hi - box.lo;
  if (!is_finite(middle) || !is_finite(size)) return;
  Rng rng(1, 2, 3);
  for (const Vec3d d : {Vec3d{size.x, 0, 0}, Vec3d{0, size.y, 0}, Vec3d{0, 0, size.z}, size}) {
    const Ray ray{middle - d, d};
    if (!(length(d) > 0) || !std::isfinite(length(d))) continue;
    const Flight flight = sample_flight(volume, ray, 2 * length(d), rng);
    require(flight.t >= 0, "a flight ends before it begins");
    const float through = sample_transmittance(volume, ray, 2 * length(d), rng);
    require(through >= 0 && through <= 1.001f, "a transmittance is outside [0, 1]");
  }
}

}  // namespace

void use_cloud(const Density& density, const Pyramid& pyramid, const LeafMicroBounds* micro) {
  if (count_nodes(pyramid) > kMostLeaves) return;
  VolumeOptions options;
  options.look_up = is_sampled(density) && pyramid.look_up == LookUp::procedural ? LookUp::trilinear
                                                                                 : pyramid.look_up;
  options.micro_bounds = MicroBoundsUse::edge_2;
  // An optical depth of about 10 across the cloud: rays that cross it take few steps.
  const Affine to_world = index_to_object(density);
  const double across = length(to_world.vector(pyramid.support().hi - pyramid.support().lo));
  const double extinction = 10 / (across * double(pyramid.scale));
  const bool usual = std::isfinite(extinction) && extinction > 0;
  const Volume volume =
      make_volume(density, pyramid, {.extinction = usual ? extinction : 1}, options, micro);
  if (usual) send_rays(volume);
}

void use_shell(const Shell& shell) {
  const RayShell ready(shell);
  const Vec3d middle = 0.5 * (Vec3d(shell.lo) + Vec3d(shell.hi));
  std::vector<Span> inside;
  for (const Vec3d d : {Vec3d{1, 0, 0}, Vec3d{0, -1, 0}, Vec3d{0, 0, 1e-3}, Vec3d{3, 2, 1}}) {
    const Ray ray{middle - 5.0 * d, d};
    ready.intersect(ray, 0, 10, inside);
    double end = 0;
    for (const Span& span : inside) {
      require(span.t0 >= end && span.t1 >= span.t0 && span.t1 <= 10, "spans are out of order");
      end = span.t1;
    }
    require(inside.empty() || !ready.misses(ray, 0, 10), "a ray misses a shell that it meets");
  }
}

void use_grid(const VoxelGrid& grid) {
  if (count_samples(grid) > kMostSamples) return;
  use_cloud(grid, build_pyramid(grid));
}

}  // namespace pvol::fuzz
