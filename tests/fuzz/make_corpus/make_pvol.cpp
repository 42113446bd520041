// .pvol files with every chunk, codec and precision.
#include <fmt/format.h>

#include "make_corpus/make_corpus.h"
#include "pvol/bounds/recipe_bounds.h"
#include "pvol/formats/pvol_file.h"
#include "pvol/formats/recipe_file.h"
#include "support/pvol_content.h"

namespace pvol::fuzz {
namespace {

using formats::Compression;
using formats::PvolFile;

/// The source alone, with bounds in closed form.
PvolFile procedural_file() {
  const Recipe recipe = formats::parse_recipe(
      "[recipe]\nresolution = 16\n[[form]]\nshape = \"ellipsoid\"\ncentre = [0, 0, 0]\nradii = 1\n",
      "ball.toml");
  return {{}, build_pyramid(recipe), std::nullopt, std::nullopt};
}

PvolFile empty_file() {
  const VoxelGrid none;
  return {{}, build_pyramid(none), none, std::nullopt};
}

/// A file of few bricks, where a renderer can place it.
PvolFile small_file() {
  PvolFile file = test::some_file(2, false);
  file.metadata.index_to_world = scaling(Vec3d(0.5));
  return file;
}

PvolFile tricubic_file() {
  PvolFile file = small_file();
  file.pyramid = build_pyramid(*file.density, LookUp::tricubic);
  file.shell.reset();
  return file;
}

PvolFile named(PvolFile file, const std::string& name) {
  file.metadata.grid_name = name;
  return file;
}

/// A fire, a colour and a velocity in their parts; one of them in few bits.
PvolFile file_with_fields() {
  PvolFile file = test::tiny_file();
  const PvolFile plain = file;
  const PvolFile few = test::with_codes(plain, {.precision = Precision::fp8});
  file.fields = {named(few, "flames")};
  for (const char* part : {"Cd.x", "Cd.y", "Cd.z", "Cd.black", "v.x+", "v.x-", "v.z-"}) {
    file.fields.push_back(named(plain, part));
  }
  return file;
}

}  // namespace

void make_pvol_corpus(const std::filesystem::path& folder) {
  const auto write = [&](const char* name, const PvolFile& file) {
    write_pvol(folder / fmt::format("{}_raw.pvol", name), file, Compression::none);
    write_pvol(folder / fmt::format("{}_zstd.pvol", name), file, Compression::zstd);
  };
  write("tiny", test::tiny_file());
  write("empty", empty_file());
  write("tiles", test::some_file(0));
  write("shell", test::some_file(3));
  write("procedural", procedural_file());
  write("fields", file_with_fields());
  write("tricubic", tricubic_file());
  const PvolFile small = small_file();
  write("micro", test::with_micro_bounds(small));
  for (const Precision p : {Precision::fp16, Precision::fp8, Precision::fpn}) {
    write(name(p), test::with_micro_bounds(test::with_codes(small, {.precision = p})));
  }
}

}  // namespace pvol::fuzz
