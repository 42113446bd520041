// Scenes: what is read is written as TOML again and read back the same.
#include "fuzz.h"
#include "pvol/formats/scene_file.h"

namespace {

using namespace pvol::fuzz;

pvol::formats::SceneFile read(const std::string& name, Input text) {
  return pvol::formats::read_scene(scratch_file(name, text));
}

/// The text of a scene is that of the scene it makes; some values do not change the picture and are
/// in no text.
void write_and_read_again(const pvol::formats::SceneFile& scene) {
  const std::string text = to_toml(scene);
  const Input bytes{reinterpret_cast<const std::uint8_t*>(text.data()), text.size()};
  require(to_toml(read("again.toml", bytes)) == text, "a scene reads back differently:\n" + text);
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  pvol::formats::SceneFile scene;
  if (!accepts([&] { scene = read("scene.toml", {data, size}); })) return 0;
  const bool written = accepts([&] { write_and_read_again(scene); });
  require(written, "what was read cannot be written or read again");
  return 0;
}
