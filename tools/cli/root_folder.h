// Keeps a tool within one folder, for services that render what others send.
#pragma once

#include <filesystem>

namespace pvol::cli {

/// From here on this process, its threads and its children open files below the folder only, to
/// read or to write; beside it, to read, the libraries of the system and what tells of memory and
/// processors. The kernel sees to it (Landlock), so neither names nor links in a scene, a cloud or
/// a mesh lead elsewhere. What is open stays open. Call it before there are threads. Throws Error
/// where there is no such folder, or the kernel has no Landlock (Linux 5.13 and later have it).
void keep_below(const std::filesystem::path& folder);

/// That folder, without links; empty where keep_below was not called.
[[nodiscard]] const std::filesystem::path& kept_below();

/// Whether a file of this name would lie below that folder, or there is none.
[[nodiscard]] bool is_kept(const std::filesystem::path& file);

}  // namespace pvol::cli
