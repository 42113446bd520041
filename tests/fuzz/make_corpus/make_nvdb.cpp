// .nvdb files of every precision and codec.
#include <openvdb/openvdb.h>
#define NANOVDB_USE_BLOSC
#define NANOVDB_USE_ZIP
#include <nanovdb/util/IO.h>
#include <nanovdb/util/OpenToNanoVDB.h>

#include "make_corpus/make_corpus.h"

namespace pvol::fuzz {
namespace {

namespace fs = std::filesystem;
using nanovdb::io::Codec;

openvdb::FloatGrid::Ptr named(const std::string& name) {
  const auto grid = openvdb::FloatGrid::create();
  grid->setName(name);
  grid->setGridClass(openvdb::GRID_FOG_VOLUME);
  return grid;
}

/// Entries of the root alone: small without compression.
openvdb::FloatGrid::Ptr root_grid(const std::string& name = "density") {
  const auto grid = named(name);
  grid->tree().addTile(3, {4096, 0, -4096}, 0.5f, true);
  grid->tree().addTile(3, {8192, 0, 0}, 0.25f, false);
  return grid;
}

openvdb::FloatGrid::Ptr leaf_grid() {
  const auto grid = named("density");
  for (int i = 0; i < 99; ++i) {
    grid->tree().setValue({i * 5 % 8, i * 3 % 8, i % 15}, float(i + 1) / 16);
  }
  grid->tree().addTile(1, {16, 0, 0}, 0.5f, true);
  grid->tree().addTile(2, {128, 0, 0}, 0.5f, true);
  return grid;
}

// Without checksums, which would refuse nearly all that the fuzzer makes of a file.
constexpr auto kStats = nanovdb::StatsMode::Default;
constexpr auto kUnchecked = nanovdb::ChecksumMode::Disable;

template <class T>
void write_precision(const fs::path& file) {
  using nanovdb::HostBuffer, openvdb::FloatTree;
  const auto handle =
      nanovdb::openToNanoVDB<HostBuffer, FloatTree, T>(*leaf_grid(), kStats, kUnchecked);
  nanovdb::io::writeGrid(file.string(), handle, Codec::ZIP);
}

}  // namespace

void make_nvdb_corpus(const fs::path& folder) {
  openvdb::initialize();
  const auto write = [&](const std::string& name, const openvdb::GridBase::Ptr& grid, Codec codec) {
    const auto handle = nanovdb::openToNanoVDB(grid, kStats, kUnchecked);
    nanovdb::io::writeGrid((folder / name).string(), handle, codec);
  };
  write("root_plain.nvdb", root_grid(), Codec::NONE);
  write("root_zip.nvdb", root_grid(), Codec::ZIP);
  write("root_blosc.nvdb", root_grid(), Codec::BLOSC);
  write("float_zip.nvdb", leaf_grid(), Codec::ZIP);
  write("float_blosc.nvdb", leaf_grid(), Codec::BLOSC);
  write("empty.nvdb", named("density"), Codec::NONE);
  nanovdb::io::writeGrid((folder / "checked.nvdb").string(),
                         nanovdb::openToNanoVDB(*leaf_grid(), kStats, nanovdb::ChecksumMode::Full),
                         Codec::ZIP);

  const auto doubles = openvdb::DoubleGrid::create();
  doubles->tree().setValue({1, 2, 3}, 1e300);
  write("double_zip.nvdb", doubles, Codec::ZIP);
  write_precision<nanovdb::Fp4>(folder / "fp4_zip.nvdb");
  write_precision<nanovdb::Fp8>(folder / "fp8_zip.nvdb");
  write_precision<nanovdb::Fp16>(folder / "fp16_zip.nvdb");
  write_precision<nanovdb::FpN>(folder / "fpn_zip.nvdb");

  const auto surface = root_grid("surface");
  surface->setGridClass(openvdb::GRID_LEVEL_SET);
  std::vector<nanovdb::GridHandle<>> several;
  several.push_back(nanovdb::openToNanoVDB(*surface));
  several.push_back(nanovdb::openToNanoVDB(*openvdb::Vec3SGrid::create()));
  several.push_back(nanovdb::openToNanoVDB(*root_grid()));
  several.push_back(nanovdb::openToNanoVDB(*root_grid()));
  nanovdb::io::writeGrids((folder / "several.nvdb").string(), several, Codec::NONE);
}

}  // namespace pvol::fuzz
