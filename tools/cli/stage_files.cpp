#include "cli/stage_files.h"

#include <functional>
#include <optional>

#include "cli/cli.h"
#include "pvol/error.h"
#include "pvol/formats/cloud.h"
#include "pvol/formats/pvol_file.h"
#include "pvol/formats/scene_files.h"

namespace pvol::cli {
namespace {

namespace fs = std::filesystem;

/// visit(name) for each file that a scene names, in an order that loading does not change. Recipes
/// are short.
void visit_names(formats::SceneFile& scene,
                 const std::function<fs::path(const fs::path&)>& rename) {
  const auto visit = [&](auto& name) {
    const fs::path file = name;
    if (file.empty() || formats::ending(file) == ".toml") return;
    if constexpr (std::is_same_v<std::remove_reference_t<decltype(name)>, fs::path>) {
      name = rename(file);
    } else {
      name = rename(file).string();
    }
  };
  visit_files(scene, visit);
}

/// The file that a .pvol takes its density from, by its place beside it; else nothing.
std::optional<fs::path> source_beside(const fs::path& file) {
  if (formats::ending(file) != ".pvol" || formats::measure_pvol(file).density > 0) return {};
  const fs::path source = formats::read_pvol_grid(file, "").metadata.source.file;
  std::error_code none;
  const fs::path there = file.parent_path() / source;
  if (source.empty() || source.is_absolute() || !fs::exists(there, none)) return {};
  return there;
}

}  // namespace

StagedFiles use_local_copies(const std::string& tool, const fs::path& folder,
                             formats::SceneFile& scene) {
  StagedFiles staged;
  if (folder.empty()) return staged;
  const auto warn = [&](const Error& e) {
    print_warnings(tool, {std::string(e.what()) + "; originals are read instead"});
  };
  try {
    staged.copies = std::make_unique<LocalCopies>(folder);
  } catch (const Error& e) {
    warn(e);
    return staged;
  }
  visit_names(scene, [&](const fs::path& file) {
    staged.own.push_back(file.string());
    if (!fs::exists(file)) return file;  // it is missed where it is loaded
    try {
      if (const auto source = source_beside(file)) (void)staged.copies->copy(*source);
      return staged.copies->copy(file);
    } catch (const Error& e) {
      warn(e);
      return file;
    }
  });
  return staged;
}

void restore_names(const StagedFiles& staged, formats::SceneFile& scene) {
  if (staged.own.empty()) return;
  std::size_t i = 0;
  visit_names(scene, [&](const fs::path&) { return fs::path(staged.own.at(i++)); });
}

}  // namespace pvol::cli
