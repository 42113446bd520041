// Scenes of pbrt: what is made of them is written as TOML and read.
#include "fuzz.h"
#include "pvol/formats/pbrt_scene.h"

namespace {

using namespace pvol::fuzz;

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  pvol::formats::PbrtScene scene;
  const std::filesystem::path file = scratch_file("scene.pbrt", {data, size});
  if (!accepts([&] { scene = pvol::formats::read_pbrt(file, "scene"); })) return 0;
  const bool readable =
      accepts([&] { (void)pvol::formats::parse_scene(to_toml(scene.file), "scene.toml"); });
  require(readable, "what was made of a scene cannot be read");
  return 0;
}
