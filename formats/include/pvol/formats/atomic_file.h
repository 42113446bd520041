// Files that appear whole or not at all.
#pragma once

#include <filesystem>
#include <functional>

namespace pvol::formats {

/// Calls `write` with the name of a new file beside `file`, then syncs that file and renames it to
/// `file`. Where `write` throws, or syncing or renaming fails, the new file is removed and `file`
/// is as before. Throws Error where the folder cannot be written.
void write_atomically(const std::filesystem::path& file,
                      const std::function<void(const std::filesystem::path&)>& write);

}  // namespace pvol::formats
