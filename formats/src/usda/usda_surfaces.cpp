// Spheres, and triangles: those that stand still in the world, of one colour in one file; what
// moves in a file of its own.
#include <fmt/format.h>

#include <algorithm>

#include "file/append_mesh.h"
#include "usda/usda_mesh.h"
#include "usda/usda_world.h"

namespace pvol::formats::detail {
namespace {

/// In all files: references could ask for more than any machine holds.
constexpr std::size_t kMostMeshVertices = std::size_t(1) << 27;

/// Triangles of one colour.
struct UsdBatch {
  Rgb albedo{};
  TriangleMesh mesh{};
};

/// Stretched spheres are named.
void add_ball(const UsdItem& item, const UsdView& view, Rgb albedo, const UsdMaking& making) {
  const std::optional<double> scale = uniform_scale(item.place.now);
  if (!scale) {
    making.note(view.where(), "stretched spheres are left out");
    return;
  }
  BallSurface ball;
  ball.centre = item.place.now.t;
  ball.radius = view.number("radius", 1) * *scale;
  ball.material.albedo = albedo;
  if (item.place.moves()) ball.to = BallPlace{item.place.later.t};
  check_made(view.where(), Surface{ball});
  making.scene->file.scene.surfaces.emplace_back(ball);
}

void add_mesh(TriangleMesh mesh, Rgb albedo, const std::optional<MovingPlacement>& moving,
              const UsdMaking& making) {
  MeshSurface surface;
  surface.file = fmt::format("{}_mesh{}.ply", making.stem, making.scene->meshes.size() + 1);
  surface.material.albedo = albedo;
  if (moving) surface.place = moving->from, surface.to = moving->to;
  making.scene->file.scene.surfaces.emplace_back(surface);
  making.scene->meshes.push_back({surface.file, std::move(mesh)});
}

void make_triangles(const UsdItem& item, const UsdView& view, Rgb albedo,
                    std::vector<UsdBatch>& batches, std::size_t& vertices,
                    const UsdMaking& making) {
  TriangleMesh mesh = triangles_of(view, making);
  if (mesh.triangles.empty()) return;
  vertices += mesh.vertices.size();
  if (vertices > kMostMeshVertices) {
    fail_at(view.where(), "meshes of more than 134 million vertices", "fewer");
  }
  if (const auto moving = motion_of(item.place, item, making)) {
    add_mesh(std::move(mesh), albedo, moving, making);
    return;
  }
  auto batch = std::ranges::find(batches, albedo, &UsdBatch::albedo);
  if (batch == batches.end()) batch = batches.insert(batch, UsdBatch{albedo, {}});
  append(batch->mesh, mesh, item.place.now);
}

void note_parts(const UsdPrim& mesh, const UsdMaking& making) {
  for (const UsdPrim& child : mesh.children) {
    if (child.type != "GeomSubset") continue;
    making.note(child.where, "materials of parts of a mesh are left out");
  }
}

/// What says nothing about the shape of triangles: colours, which were read before, derived data,
/// and what is for smooth or textured surfaces.
void ignore_details(const UsdView& view) {
  for (const char* name :
       {"extent", "doubleSided", "orientation", "normals", "primvars:normals", "primvars:st",
        "primvars:st:indices", "interpolateBoundary", "faceVaryingLinearInterpolation",
        "triangleSubdivisionRule", "primvars:displayColor", "primvars:displayColor:indices",
        "subdivisionScheme"}) {
    view.ignore(name);
  }
}

}  // namespace

void make_surfaces(const UsdMaking& making) {
  std::vector<UsdBatch> batches;
  std::size_t vertices = 0;
  for (const UsdItem& item : making.stage.surfaces) {
    const UsdView view = making.stage.view(*item.prim);
    const Rgb albedo = albedo_of(item, making);
    if (item.prim->type == "Sphere") {
      add_ball(item, view, albedo, making);
    } else {
      make_triangles(item, view, albedo, batches, vertices, making);
    }
    note_parts(*item.prim, making);
    ignore_details(view);
    view.note_unused(*making.notes);
  }
  for (UsdBatch& batch : batches) add_mesh(std::move(batch.mesh), batch.albedo, {}, making);
}

}  // namespace pvol::formats::detail
