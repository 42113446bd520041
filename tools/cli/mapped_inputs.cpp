#include "cli/mapped_inputs.h"

#include <sys/stat.h>

#include "pvol/error.h"

namespace pvol::cli {
namespace {

bool was_written(const FileState& then, const FileState& now) {
  const bool same_file = then.device == now.device && then.inode == now.inode;
  return same_file && (then.bytes != now.bytes || then.written.tv_sec != now.written.tv_sec ||
                       then.written.tv_nsec != now.written.tv_nsec);
}

}  // namespace

FileState state_of(const std::filesystem::path& file) {
  struct stat info {};
  if (::stat(file.c_str(), &info) != 0) return {.file = file};
  return {file, info.st_dev, info.st_ino, info.st_size, info.st_mtim};
}

void require_unchanged(const std::vector<FileState>& files) {
  for (const FileState& then : files) {
    if (!was_written(then, state_of(then.file))) continue;
    throw Error(then.file.string() +
                ": was written over while it was in use, so the picture is not saved. Render "
                "again; to replace a file that is in use, write the new one aside and rename it");
  }
}

}  // namespace pvol::cli
