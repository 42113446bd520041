// .vdb files with every compression, precision, map and kind of grid. An upper node alone takes 8
// kB, so that each file has one or none.
#include <openvdb/io/Stream.h>
#include <openvdb/openvdb.h>
#include <openvdb/tools/ChangeBackground.h>

#include <cmath>
#include <fstream>

#include "make_corpus/make_corpus.h"

namespace pvol::fuzz {
namespace {

namespace fs = std::filesystem;
namespace io = openvdb::io;
namespace om = openvdb::math;
using openvdb::FloatGrid;

template <class Grid = FloatGrid>
typename Grid::Ptr named(const std::string& name) {
  const auto grid = Grid::create();
  grid->setName(name);
  return grid;
}

/// One leaf with a few voxels.
FloatGrid::Ptr leaf_grid(const std::string& name = "density") {
  const auto grid = named(name);
  grid->setGridClass(openvdb::GRID_FOG_VOLUME);
  for (int i = 0; i < 40; ++i) {
    grid->tree().setValue({i * 5 % 8, i * 3 % 8, i % 8}, float(i + 1) / 16);
  }
  return grid;
}

/// Entries of the root alone: a file of a few hundred bytes.
FloatGrid::Ptr root_grid(const std::string& name = "density") {
  const auto grid = named(name);
  grid->tree().addTile(3, {4096, 0, -4096}, 0.5f, true);
  grid->tree().addTile(3, {8192, 0, 0}, 0.25f, false);
  return grid;
}

FloatGrid::Ptr with_map(const om::MapBase::Ptr& map) {
  const auto grid = root_grid();
  grid->setTransform(std::make_shared<om::Transform>(map));
  return grid;
}

void write(const fs::path& file, const openvdb::GridPtrVec& grids,
           std::uint32_t compression = io::COMPRESS_ACTIVE_MASK) {
  io::File out(file.string());
  out.setCompression(compression);
  out.write(grids);
  out.close();
}

void write_compressions(const fs::path& folder) {
  const auto grid = leaf_grid();
  grid->tree().addTile(1, {16, 0, 0}, 0.75f, true);
  grid->tree().addTile(2, {128, 0, 0}, 0.75f, true);
  write(folder / "masked.vdb", {grid});
  grid->setGridClass(openvdb::GRID_UNKNOWN);  // OpenVDB does not zip fog volumes
  write(folder / "zip.vdb", {grid}, io::COMPRESS_ZIP);
  write(folder / "zip_masked.vdb", {grid}, io::COMPRESS_ZIP | io::COMPRESS_ACTIVE_MASK);
  write(folder / "blosc.vdb", {grid}, io::COMPRESS_BLOSC);
  write(folder / "blosc_masked.vdb", {grid}, io::COMPRESS_BLOSC | io::COMPRESS_ACTIVE_MASK);
  grid->setSaveFloatAsHalf(true);
  write(folder / "half.vdb", {grid});
  write(folder / "half_blosc.vdb", {grid}, io::COMPRESS_BLOSC | io::COMPRESS_ACTIVE_MASK);
}

/// Every way in which inactive values are left out: none, one, two, with a mask, and all stored.
void write_inactive_values(const fs::path& folder) {
  for (int distinct = 0; distinct < 4; ++distinct) {
    const auto grid = leaf_grid();
    for (int i = 0; i < distinct; ++i) grid->tree().setValueOff({7, 7, i}, float(3 + i));
    if (distinct == 2) openvdb::tools::changeBackground(grid->tree(), 9.0f);
    write(folder / ("inactive_" + std::to_string(distinct) + ".vdb"), {grid});
  }
}

void write_kinds(const fs::path& folder) {
  const auto doubles = named<openvdb::DoubleGrid>("density");
  doubles->tree().setValue({1, 2, 3}, 1e300);
  doubles->tree().setValue({1, 2, 4}, 0.1);
  write(folder / "double.vdb", {doubles});
  const auto odd = root_grid();
  odd->tree().addTile(3, {0, 0, 0}, NAN, true);
  odd->tree().addTile(3, {0, 4096, 0}, -1, true);
  write(folder / "odd_values.vdb", {odd});
  const auto surface = root_grid("surface");
  surface->setGridClass(openvdb::GRID_LEVEL_SET);
  write(folder / "several.vdb",
        {surface, named<openvdb::Vec3SGrid>("v"), named<openvdb::Int32Grid>("i"),
         named<openvdb::BoolGrid>("b"), named<openvdb::MaskGrid>("m"), root_grid(), root_grid()});
  write(folder / "empty.vdb", {named("density")});
}

/// Colours and velocities, as vectors of either precision and as three numbers.
void write_vectors(const fs::path& folder) {
  const auto color = named<openvdb::Vec3SGrid>("Cd");
  color->tree().setValueOn({1, 2, 3}, {0.5f, 2, -1});
  color->tree().addTile(1, {8, 0, 0}, {1, 0, 0}, true);
  const auto velocity = named<openvdb::Vec3DGrid>("vel");
  velocity->tree().setValueOn({1, 2, 3}, {1, -2, NAN});
  velocity->tree().addTile(2, {128, 0, 0}, {0, 0, 7}, true);
  write(folder / "vectors.vdb", {leaf_grid(), color, velocity});
  openvdb::GridPtrVec parts{leaf_grid()};
  for (const char* name : {"v.x", "v.y", "v.z"}) {
    const auto part = leaf_grid();
    part->setName(name);
    parts.push_back(part);
  }
  write(folder / "components.vdb", parts);
}

void write_maps(const fs::path& folder) {
  using Matrix = openvdb::Mat4d;
  Matrix sheared = Matrix::identity();
  sheared(0, 1) = 0.5;
  sheared(3, 2) = -7;
  const openvdb::Vec3d v(0.5, 2, -1);
  write(folder / "map_uniform.vdb", {with_map(std::make_shared<om::UniformScaleMap>(0.5))});
  write(folder / "map_scale.vdb", {with_map(std::make_shared<om::ScaleMap>(v))});
  write(folder / "map_uniform_moved.vdb",
        {with_map(std::make_shared<om::UniformScaleTranslateMap>(0.5, v))});
  write(folder / "map_scale_moved.vdb", {with_map(std::make_shared<om::ScaleTranslateMap>(v, v))});
  write(folder / "map_moved.vdb", {with_map(std::make_shared<om::TranslationMap>(v))});
  write(folder / "map_affine.vdb", {with_map(std::make_shared<om::AffineMap>(sheared))});
  write(folder / "map_unitary.vdb", {with_map(std::make_shared<om::UnitaryMap>(om::X_AXIS, 0.5))});
  const auto frustum =
      om::Transform::createFrustumTransform(openvdb::BBoxd({0, 0, 0}, {9, 9, 9}), 0.5, 1, 1.0);
  write(folder / "map_frustum.vdb", {with_map(frustum->baseMap()->copy())});
}

/// Grids that share a tree, with and without offsets to them in the file.
void write_streams(const fs::path& folder) {
  const auto first = leaf_grid();
  const auto second = FloatGrid::create(first->treePtr());
  second->setName("shared");
  write(folder / "shared.vdb", {first, second});
  std::ofstream out(folder / "stream.vdb", std::ios::binary);
  io::Stream(out).write(openvdb::GridPtrVec{root_grid("other"), first, second});
}

/// The same file as older libraries wrote it.
void write_versions(const fs::path& folder) {
  for (const char version : {char(222), char(223)}) {
    const fs::path file = folder / ("version_" + std::to_string(std::uint8_t(version)) + ".vdb");
    write(file, {root_grid()});
    std::fstream stream(file, std::ios::in | std::ios::out | std::ios::binary);
    stream.seekp(8);
    stream.put(version);
  }
}

}  // namespace

void make_vdb_corpus(const fs::path& folder) {
  openvdb::initialize();
  write_compressions(folder);
  write_inactive_values(folder);
  write_kinds(folder);
  write_vectors(folder);
  write_maps(folder);
  write_streams(folder);
  write_versions(folder);
}

}  // namespace pvol::fuzz
