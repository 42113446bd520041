#include "cli/picture_output.h"

#include "cli/cli.h"

namespace pvol::cli {

void check(const PictureOutput& o) {
  check_output(o.exr, {".exr"});
  if (!o.png.empty()) check_output(o.png, {".png"});
  if (o.no_png && !o.png.empty()) throw UsageError("--png and --no-png exclude each other");
}

void save_png(const PictureOutput& o, const Film& film, bool background) {
  if (o.no_png) return;
  const std::filesystem::path file =
      o.png.empty() ? std::filesystem::path(o.exr).replace_extension(".png") : o.png;
  formats::write_png(file, film, o.display, !background);
}

}  // namespace pvol::cli
