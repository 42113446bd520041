// .vdb files: our checks, then OpenVDB's reader with what they let through.
#include "fuzz.h"
#include "pvol/formats/color.h"
#include "pvol/formats/field_names.h"
#include "pvol/formats/vdb.h"
#include "pvol/formats/velocity.h"
#include "use_cloud.h"

// OpenVDB loses a node where compressed values of it turn out to be damaged.
extern "C" const char* __lsan_default_suppressions();
extern "C" [[gnu::used]] const char* __lsan_default_suppressions() { return "leak:libopenvdb"; }

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace pvol::fuzz;
  const std::filesystem::path file = scratch_file("input.vdb", {data, size});
  accepts([&] { use_grid(pvol::formats::read_vdb(file).grid); });
  accepts([&] { (void)pvol::formats::read_velocity(file, ""); });
  accepts([&] {
    const std::string name = pvol::formats::usual_color_grid(pvol::formats::grids_of(file));
    if (!name.empty()) (void)pvol::formats::read_color(file, name);
  });
  return 0;
}
