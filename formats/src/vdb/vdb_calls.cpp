#include "vdb/vdb_calls.h"

#include <dlfcn.h>
#include <fmt/format.h>
#include <link.h>

#include <array>

#include "file/grid_choice.h"
#include "pvol/error.h"
#include "pvol/formats/atomic_file.h"
#include "pvol/formats/memory.h"
#include "vdb/vdb_inspect.h"

namespace pvol::formats {
namespace {

constexpr const char* kModule = "pvol_vdb.so";

/// Where it may lie, from the folder of the program or library that holds this code: a wheel has it
/// in the same folder, an installation and a build in lib/pvol.
constexpr std::array kFolders = {
    ".",
    "../lib/pvol",     // of bin; of tools and tests in a build
    "../../lib/pvol",  // of python/pvol in a build
    "../../../pvol",   // of lib/python3/dist-packages/pvol
};

/// The address space that OpenVDB and its libraries take.
constexpr std::uint64_t kMemory = std::uint64_t{100} << 20;

/// The folder of the program or library that holds this code.
std::filesystem::path own_folder() {
  Dl_info info{};
  link_map* map = nullptr;
  const auto here = reinterpret_cast<const void*>(&own_folder);
  const bool found =
      dladdr1(here, &info, reinterpret_cast<void**>(&map), RTLD_DL_LINKMAP) != 0 && map != nullptr;
  const bool library = found && map->l_name[0] != '\0';  // programs have no name
  const std::filesystem::path self = library ? map->l_name : "/proc/self/exe";
  return std::filesystem::canonical(self).parent_path();
}

std::vector<std::filesystem::path> module_folders() {
  const std::filesystem::path own = own_folder();
  std::vector<std::filesystem::path> all;
  for (const char* folder : kFolders) {
    all.push_back((own / folder / kModule).lexically_normal().parent_path());
  }
  return all;
}

const detail::VdbCalls* load_module() {
  const std::optional<std::filesystem::path> folder = vdb_module_folder();
  if (!folder) {
    std::string looked_in;
    for (const std::filesystem::path& f : module_folders()) {
      looked_in += (looked_in.empty() ? "" : ", ") + f.string();
    }
    throw Error(fmt::format(
        "there is no module for OpenVDB: {} is in none of {}; install it (Debian: pvol-vdb), or "
        "use .pvol or .nvdb files",
        kModule, looked_in));
  }
  // Where memory ends while OpenVDB starts, it may abort or hang.
  require_memory(kMemory, "OpenVDB");
  void* const module = dlopen((*folder / kModule).c_str(),
                              RTLD_NOW | RTLD_LOCAL);  // for as long as the process runs
  const void* const calls = module != nullptr ? dlsym(module, "pvol_vdb_calls") : nullptr;
  if (calls == nullptr)
    throw Error(
        fmt::format("OpenVDB could not be loaded: {}; install the one that pvol was built with "
                    "(Debian: pvol-vdb), or use .pvol or .nvdb files",
                    dlerror()));
  return static_cast<const detail::VdbCalls*>(calls);
}

}  // namespace

std::optional<std::filesystem::path> vdb_module_folder() {
  for (const std::filesystem::path& folder : module_folders()) {
    if (std::filesystem::exists(folder / kModule)) return folder;
  }
  return std::nullopt;
}

const detail::VdbCalls& detail::vdb_calls(const std::filesystem::path& file) try {
  static const VdbCalls* const calls = load_module();
  return *calls;
} catch (const std::exception& e) {
  throw Error(file.string() + ": " + e.what());
}

std::vector<GridEntry> list_vdb(const std::filesystem::path& path) {
  detail::ByteSource source(path);
  return detail::entries_of(choices(detail::inspect_vdb(source)));
}

LoadedGrid read_vdb(const std::filesystem::path& file, const GridOptions& options) {
  return detail::vdb_calls(file).read_density(file, options);
}

void write_vdb(const std::filesystem::path& file, const std::vector<const VoxelGrid*>& grids,
               const std::vector<const ColorGrid*>& colors,
               const std::vector<const VelocityGrid*>& velocities) {
  const auto write = detail::vdb_calls(file).writer(file.string(), grids, colors, velocities);
  try {
    write_atomically(file, write);
  } catch (const std::exception& e) {
    throw Error("cannot write " + file.string() + ": " + e.what());
  }
}

}  // namespace pvol::formats
