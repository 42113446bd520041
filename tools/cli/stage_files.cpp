#include "cli/stage_files.h"

#include <fmt/format.h>
#include <unistd.h>

#include <cstdlib>
#include <functional>

#include "cli/cli.h"
#include "cli/scene_files.h"
#include "pvol/error.h"
#include "pvol/formats/atomic_file.h"
#include "pvol/formats/cloud.h"
#include "pvol/formats/pvol_file.h"

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

bool is_copy(const fs::path& copy, const fs::path& file) {
  std::error_code none;
  return fs::exists(copy, none) && fs::file_size(copy, none) == fs::file_size(file, none) &&
         fs::last_write_time(copy, none) == fs::last_write_time(file, none);
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

fs::path local_folder(const fs::path& given) {
  if (given != "auto") return given;
  fs::path base = "/tmp";
  for (const char* name : {"SLURM_TMPDIR", "TMPDIR"}) {
    const char* const value = std::getenv(name);
    if (value == nullptr || *value == 0) continue;
    base = value;
    break;
  }
  const char* const user = std::getenv("USER");
  return base / fmt::format("pvol-{}", user ? std::string(user) : std::to_string(getuid()));
}

fs::path copy_to(const fs::path& folder, const fs::path& file) {
  const fs::path copy = folder / fs::absolute(file).lexically_normal().relative_path();
  try {
    if (is_copy(copy, file)) return copy;
    fs::create_directories(copy.parent_path());
    formats::write_atomically(copy, [&](const fs::path& aside) {
      fs::copy_file(file, aside, fs::copy_options::overwrite_existing);
      fs::last_write_time(aside, fs::last_write_time(file));
    });
  } catch (const fs::filesystem_error& e) {
    throw Error(fmt::format("{}: cannot be copied to {}: {}", file.string(), folder.string(),
                            e.code().message()));
  }
  return copy;
}

std::vector<std::string> use_local_copies(const std::string& tool, const fs::path& folder,
                                          formats::SceneFile& scene) {
  std::vector<std::string> own;
  if (folder.empty()) return own;
  visit_names(scene, [&](const fs::path& file) {
    own.push_back(file.string());
    if (!fs::exists(file)) return file;  // it is missed where it is loaded
    try {
      if (const auto source = source_beside(file)) (void)copy_to(folder, *source);
      return copy_to(folder, file);
    } catch (const Error& e) {
      print_warnings(tool, {std::string(e.what()) + "; the original is read instead"});
      return file;
    }
  });
  return own;
}

void restore_names(const std::vector<std::string>& own, formats::SceneFile& scene) {
  if (own.empty()) return;
  std::size_t i = 0;
  visit_names(scene, [&](const fs::path&) { return fs::path(own.at(i++)); });
}

}  // namespace pvol::cli
