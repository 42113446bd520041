// Files of phase functions, read by a scene that names one: what is read is a phase function, whose
// samples are directions and whose values are finite.
#include <cmath>
#include <variant>

#include "fuzz.h"
#include "pvol/formats/scene_file.h"
#include "pvol/math/rng.h"
#include "pvol/volume/phase_table.h"

namespace {

using namespace pvol::fuzz;

void check(const pvol::PhaseTable& table) {
  const double mean = mean_cosine(table);
  require(mean >= -1 && mean <= 1, "a mean cosine is " + std::to_string(mean));
  pvol::Rng rng(1, 0, 0);
  const pvol::Vec3f from(0, 0.6f, 0.8f);
  for (int i = 0; i < 64; ++i) {
    const auto [u, azimuth] = rng.uniform2();
    const pvol::PhaseSample sample = sample_phase(table, from, float(u), float(azimuth));
    require(std::abs(pvol::length(sample.direction) - 1) < 1e-3f,
            "a sampled direction is no unit vector");
    const float pdf = pdf_phase(table, from, sample.direction);
    require(pdf >= 0 && std::isfinite(pdf) && std::isfinite(sample.pdf),
            "a phase function has no finite value");
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  scratch_file("phase.txt", {data, size});
  static const std::string text = "[medium]\nphase_table = \"phase.txt\"\n";
  static const auto scene_file =
      scratch_file("scene.toml", {reinterpret_cast<const std::uint8_t*>(text.data()), text.size()});
  pvol::formats::SceneFile scene;
  if (!accepts([&] { scene = pvol::formats::read_scene(scene_file); })) return 0;
  check(std::get<pvol::PhaseTable>(scene.volumes.at(0).medium.components.at(0).phase));
  return 0;
}
