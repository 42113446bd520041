// In place of the import of pbrt-v4's scenes, where pvol is built without it.
#include "pvol/error.h"
#include "pvol/formats/pbrt_scene.h"

namespace pvol::formats {

PbrtScene read_pbrt(const std::filesystem::path& file, const std::string& /*stem*/) {
  throw Error(file.string() +
              ": this pvol was built without the import of pbrt scenes; configure it with "
              "-DPVOL_WITH_PBRT=ON");
}

}  // namespace pvol::formats
