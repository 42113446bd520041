#include "cli/missing_file.h"

#include <string>

#include "pvol/formats/cloud.h"
#include "pvol/formats/scene_files.h"

namespace pvol::cli {

void rethrow_with_place(const Error& e, const std::filesystem::path& input,
                        const formats::SceneFile& scene) {
  const std::string what = e.what();
  if (formats::ending(input) != ".toml") throw;
  for (const std::filesystem::path& file : formats::files_of(scene)) {
    std::error_code ignored;
    if (std::filesystem::is_regular_file(file, ignored)) continue;
    if (what.find(file.string()) == what.npos) continue;
    const std::string where = formats::where_named(input, file);
    if (!where.empty()) throw Error(where + ": " + what);
  }
  throw;
}

}  // namespace pvol::cli
