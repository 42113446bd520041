#include "pvol/render/shell_choice.h"

#include "pvol/bounds/homogenise.h"
#include "pvol/bounds/walk.h"
#include "pvol/shell/costs.h"
#include "render/path/camera_rays.h"
#include "render/path/instances.h"
#include "render/path/volume_setup.h"

namespace pvol {
namespace {

/// Nanoseconds that a ray spends in the octree if it meets no density: every tentative collision on
/// its way is null.
double empty_walk_cost(const Volume& volume, const Cursor& start, Float4 direction) {
  const WalkCosts costs;
  double cost = 0;
  Walk walk(volume.density.octree, start, direction);
  while (const auto s = walk.next([&] { cost += costs.skip; })) {
    const double length = s->t1 - s->t0;
    cost += costs.segment +
            length * (double(s->hi) * costs.tentative + double(s->hi - s->lo) * costs.lookup);
  }
  return cost;
}

}  // namespace

ShellEstimate estimate_shell(const Volume& volume, const Shell& shell, const Scene& scene) {
  ShellEstimate e;
  if (volume.density.octree.empty()) return e;
  constexpr int kRaysAlong = 64;
  const RayShell rays(shell, volume.density.octree.origin);
  const detail::Projection projection(scene.camera, scene.options.width, scene.options.height);
  const Box box = volume.density.octree.support();
  const detail::Instances instances(std::span(&volume, 1));
  const detail::ImagePart image{0, 0, scene.options.width, scene.options.height};
  detail::visit_coarse_rays(projection, image, kRaysAlong, [&](const Ray& world, int) {
    ++e.rays;
    instances.tree.visit(world, detail::kEndless, [&](std::uint32_t i, double limit) {
      const Ray ray = instances.all[i].in_cells(world);
      const auto span = intersect(box, ray, 0, detail::kEndless);
      if (!span) return limit;
      ++e.boxed;
      if (!rays.misses(ray, span->t0, span->t1)) return limit;
      ++e.rejected;
      e.saved += empty_walk_cost(volume, make_cursor(volume.density.octree, ray.at(span->t0)),
                                 widen(Vec3f(ray.d)));
      return limit;
    });
  });
  if (e.boxed > 0) e.saved /= e.boxed;
  e.spent = test_cost(shell);
  return e;
}

ShellChoice choose_shell(const Volume& volume, const Scene& scene) {
  ShellChoice choice;
  if (!volume.shell) return choice;
  choice.estimate = estimate_shell(volume, *volume.shell, scene);
  // Homogeneous parts reach beyond the cells that the shell was proven for.
  const auto& homogeneous = volume.density.homogeneous;
  const bool fits = !homogeneous || homogeneous->nodes == 0;
  const ShellUse use = fits ? scene.options.shells : ShellUse::off;
  choice.kept = use == ShellUse::on || (use == ShellUse::automatic && choice.estimate.pays());
  return choice;
}

}  // namespace pvol
