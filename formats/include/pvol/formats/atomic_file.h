// Files that appear whole or not at all.
#pragma once

#include <filesystem>
#include <functional>
#include <string>

namespace pvol::formats {

/// Calls `write` with the name of a new file beside `file`, then syncs that file, gives it the mode
/// and the group of a file that was there, and renames it to `file`. Where `write` throws, or
/// syncing or renaming fails, the new file is removed and `file` is as before. A writer that is
/// killed leaves its new file behind; the next one to write `file` removes it. Of several at once
/// each writes a whole file, and the last one stays. Throws Error where the folder cannot be
/// written.
void write_atomically(const std::filesystem::path& file,
                      const std::function<void(const std::filesystem::path&)>& write);

/// Writes such a file of this text. Throws Error where the disk is full, too.
void write_text_atomically(const std::filesystem::path& file, const std::string& text);

/// Removes the new files of all writers of this process, which then fail or, where they are about
/// to be done, succeed: for a thread that ends the process meanwhile.
void abandon_writes() noexcept;

}  // namespace pvol::formats
