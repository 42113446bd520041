// Copies of files on a disk of this machine: which of them go where it is full. That they are read,
// and where they are not sought, is in tests/cli/split_test.cpp.
#include "cli/local_copies.h"

#include <gtest/gtest.h>

#include <chrono>
#include <fstream>
#include <vector>

#include "support/temporary_folder.h"

namespace pvol::cli {
namespace local_copies_test {

namespace fs = std::filesystem;

TEST(LocalCopies, GoWhereTheDiskIsFullThoseInUseExcepted) {
  const TemporaryFolder folder;
  const fs::path there = folder.file("there");
  const auto copy_of = [&](const fs::path& file) { return there / file.relative_path(); };
  const std::vector<fs::path> names{folder.file("a"), folder.file("b"), folder.file("c")};
  for (const fs::path& name : names) std::ofstream(name) << name.string();
  cli::LocalCopies used(there);
  (void)used.copy(names[0]);
  {
    cli::LocalCopies unused(there);
    (void)unused.copy(names[1]), (void)unused.copy(names[2]);
  }
  const auto long_ago = fs::file_time_type::clock::now() - std::chrono::hours(24);
  fs::last_write_time(copy_of(names[2]).string() + ".origin", long_ago);
  EXPECT_TRUE(cli::make_room(there, 1));
  EXPECT_TRUE(fs::exists(copy_of(names[2])));
  EXPECT_FALSE(cli::make_room(there, std::uint64_t{1} << 62)) << "more than any disk has";
  EXPECT_TRUE(fs::exists(copy_of(names[0])));
  EXPECT_FALSE(fs::exists(copy_of(names[1])));
  EXPECT_FALSE(fs::exists(copy_of(names[2])));
  EXPECT_EQ(fs::file_size(used.copy(names[1])), names[1].string().size()) << "made again";
}

}  // namespace local_copies_test
}  // namespace pvol::cli
