// A folder on a disk of this machine with copies of files from slow ones, shared by all renders of a
// user.
#pragma once

#include <cstdint>
#include <filesystem>
#include <vector>

namespace pvol::cli {

/// The folder that --local-copies means: "auto" is pvol-USER in $SLURM_TMPDIR, $TMPDIR or /tmp.
[[nodiscard]] std::filesystem::path local_folder(const std::filesystem::path& given);

/// Copies of files in one folder. None of those in use is removed while this lives.
///
/// A copy lies under the whole name of its file, beside a record NAME.origin of what the system says
/// of both: inode, size, and the times of the last change of contents and of anything, to the
/// nanosecond. A copy whose record does not hold any more is made again, so that what was rewritten
/// is noticed without being read.
class LocalCopies {
 public:
  /// Creates the folder, for this user alone, where there is none. Throws Error for one that is
  /// reached by a link, belongs to another user, or can be written by others: what lies there may be
  /// anybody's.
  explicit LocalCopies(std::filesystem::path folder);
  ~LocalCopies();
  LocalCopies(const LocalCopies&) = delete;
  LocalCopies& operator=(const LocalCopies&) = delete;

  /// The name of the file's copy, which is made unless it is there; several processes may ask at
  /// once. Where the disk is full, copies go that were not used for longest. Throws Error.
  [[nodiscard]] std::filesystem::path copy(const std::filesystem::path& file);

 private:
  std::filesystem::path folder_;
  std::vector<int> locks_;  // descriptors of records, each locked
};

/// Removes copies that no process uses, those first that were not used for longest, until the disk
/// has so many bytes free; whether it has.
bool make_room(const std::filesystem::path& folder, std::uint64_t bytes);

}  // namespace pvol::cli
