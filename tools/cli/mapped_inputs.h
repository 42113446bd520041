// Files of clouds whose samples stay in them while a picture is rendered.
#pragma once

#include <sys/types.h>

#include <ctime>
#include <filesystem>
#include <vector>

namespace pvol::cli {

/// A file as it is at one time.
struct FileState {
  std::filesystem::path file;
  dev_t device = 0;
  ino_t inode = 0;
  off_t bytes = 0;
  timespec written{};  ///< last
};

/// Nothing but the name where there is no file.
[[nodiscard]] FileState state_of(const std::filesystem::path& file);

/// Throws Error for the first file that was written over since: a picture would show either state.
/// One that another has taken the name of is still there as it was.
void require_unchanged(const std::vector<FileState>& files);

}  // namespace pvol::cli
