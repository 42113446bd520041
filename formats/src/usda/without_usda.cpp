// In place of the import of USD scenes, where pvol is built without it.
#include "pvol/error.h"
#include "pvol/formats/usda_scene.h"

namespace pvol::formats {

ImportedScene read_usda(const std::filesystem::path& file, const std::string& /*stem*/,
                        std::optional<int> /*frame*/) {
  throw Error(file.string() +
              ": this pvol was built without the import of USD scenes; configure it with "
              "-DPVOL_WITH_USDA=ON");
}

}  // namespace pvol::formats
