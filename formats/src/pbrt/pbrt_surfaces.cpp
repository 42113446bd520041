// pbrt's shapes as surfaces: balls where they are, all others as triangles in the world, those of
// one colour in one file.
#include <fmt/format.h>

#include <algorithm>

#include "file/append_mesh.h"
#include "file/mesh_read.h"
#include "pbrt/pbrt_bounds.h"
#include "pbrt/pbrt_color.h"
#include "pbrt/pbrt_shapes.h"
#include "pbrt/pbrt_world.h"
#include "pvol/formats/cloud.h"

namespace pvol::formats::detail {
namespace {

/// Triangles of one colour.
struct Batch {
  Rgb albedo;
  TriangleMesh mesh;
};

/// Of textures that are even.
std::optional<Rgb> of_texture(const PbrtDescription& from, const std::string& name,
                              ImportNotes& notes) {
  const auto found = from.textures.find(name);
  if (found == from.textures.end() || found->second.type != "constant") return std::nullopt;
  return color_of(found->second, "value", PbrtSpectrum::reflectance, notes);
}

Rgb albedo_of(const PbrtDescription& from, const PbrtShape& shape, const PbrtMaking& making) {
  constexpr float kUsual = 0.5f;
  const PbrtThing& material = shape.material;
  if (material.type != "diffuse") {
    making.note(material.where,
                fmt::format("the material \"{}\" is taken as diffuse, with its reflectance or 0.5",
                            shown(material.type)));
  }
  std::optional<Rgb> color;
  const PbrtParameter* p = material.parameters.find("reflectance");
  if (p != nullptr && p->type == "texture") {
    const std::string name = p->strings.empty() ? "" : p->strings.front();
    color = of_texture(from, name, *making.notes);
    if (!color) {
      making.note(p->where, fmt::format("the texture \"{}\" is taken as 0.5", shown(name)));
    }
  } else {
    color = color_of(material, "reflectance", PbrtSpectrum::reflectance, *making.notes);
  }
  material.parameters.note_unused(*making.notes,
                                  fmt::format("material \"{}\"", shown(material.type)));
  const Rgb c = color.value_or(Rgb(kUsual));
  return {std::min(c.x, 1.0f), std::min(c.y, 1.0f), std::min(c.z, 1.0f)};
}

bool make_ball(const PbrtShape& shape, const Affine& place, Rgb albedo, const PbrtMaking& making) {
  const std::optional<double> scale = even_scale(place);
  if (shape.type != "sphere" || !scale || !is_whole_sphere(shape)) return false;
  BallSurface ball;
  ball.centre = place.t;
  ball.radius = shape.parameters.number("radius", 1) * *scale;
  ball.material.albedo = albedo;
  if (!(ball.radius > 0))
    fail_at(shape.where, "a sphere with a radius of 0 or less", "a radius above 0");
  making.scene->file.scene.surfaces.emplace_back(ball);
  return true;
}

/// A file of triangles stays where it is.
bool make_file(const PbrtShape& shape, const Affine& place, Rgb albedo, const PbrtMaking& making) {
  if (shape.type != "plymesh") return false;
  const std::string name = shape.parameters.word("filename", "");
  const std::filesystem::path file =
      std::filesystem::absolute(making.folder / name).lexically_normal();
  if (ending(file) != ".ply" || !std::filesystem::exists(file)) {
    making.note(shape.where, fmt::format("the mesh {} is left out: {}", shown(name),
                                         ending(file) == ".gz"
                                             ? "unpack it with gunzip, and use the unpacked name"
                                         : ending(file) != ".ply" ? "expected a .ply"
                                                                  : "there is no such file"));
    return true;
  }
  MeshSurface mesh;
  mesh.file = file.string();
  if (!(place == Affine{})) mesh.place.matrix = place;
  mesh.material.albedo = albedo;
  making.scene->file.scene.surfaces.emplace_back(mesh);
  return true;
}

void make_surface(const PbrtDescription& from, const PbrtShape& shape, const PbrtMaking& making,
                  std::vector<Batch>& batches) {
  const Affine place = making.world * shape.place;
  if (make_area_light(shape, place, making)) return;
  const Rgb albedo = albedo_of(from, shape, making);
  if (make_ball(shape, place, albedo, making) || make_file(shape, place, albedo, making)) return;
  const TriangleMesh mesh = triangles_of(shape, *making.notes);
  if (mesh.triangles.empty()) return;
  auto batch = std::ranges::find(batches, albedo, &Batch::albedo);
  if (batch == batches.end()) batch = batches.insert(batch, Batch{albedo, {}});
  append(batch->mesh, mesh, place);
}

}  // namespace

void make_surfaces(const PbrtDescription& from, const PbrtMaking& making) {
  std::vector<Batch> batches;
  for (const PbrtShape& shape : from.shapes) {
    if (is_interface(shape)) {
      (void)hull_of(shape);
      if (shape.area_light) making.note(shape.where, "light of interfaces is left out");
    } else {
      make_surface(from, shape, making, batches);
      shape.parameters.note_unused(*making.notes, fmt::format("shape \"{}\"", shown(shape.type)));
    }
  }
  for (std::size_t i = 0; i < batches.size(); ++i) {
    MeshSurface mesh;
    mesh.file = fmt::format("{}_mesh{}.ply", making.stem, i + 1);
    mesh.material.albedo = batches[i].albedo;
    making.scene->file.scene.surfaces.emplace_back(mesh);
    making.scene->meshes.push_back({mesh.file, std::move(batches[i].mesh)});
  }
}

}  // namespace pvol::formats::detail
