// What the checksums of .nvdb files find, and which files have none.
#include <gtest/gtest.h>
#define NANOVDB_USE_BLOSC
#define NANOVDB_USE_ZIP
#include <nanovdb/util/GridChecksum.h>
#include <nanovdb/util/IO.h>
#include <nanovdb/util/OpenToNanoVDB.h>
#include <openvdb/openvdb.h>

#include <cstring>

#include "pvol/formats/vdb.h"
#include "support/error_of.h"
#include "support/messages.h"
#include "support/temporary_folder.h"

namespace pvol::formats {
namespace nvdb_checksum_test {

using nanovdb::ChecksumMode;
using test::error_of;

openvdb::FloatGrid::Ptr small_grid() {
  openvdb::initialize();
  auto grid = openvdb::FloatGrid::create(0);
  grid->setName("density");
  grid->setGridClass(openvdb::GRID_FOG_VOLUME);
  for (int i = 0; i < 3000; ++i) {
    grid->tree().setValue({i % 17, i * 7 % 200, i * 3 % 90}, float(i + 1) / 1024);
  }
  grid->tree().addTile(1, {-160, 0, 0}, 0.5f, true);
  return grid;
}

template <class T = float>
nanovdb::GridHandle<> handle_of(ChecksumMode mode) {
  using nanovdb::HostBuffer, openvdb::FloatTree;
  return nanovdb::openToNanoVDB<HostBuffer, FloatTree, T>(*small_grid(),
                                                          nanovdb::StatsMode::Default, mode);
}

nanovdb::GridData& head_of(nanovdb::GridHandle<>& handle) {
  return *reinterpret_cast<nanovdb::GridData*>(handle.data());
}

class NvdbChecksum : public ::testing::Test {
 protected:
  /// Why a file of this grid is refused; nothing where it is read.
  [[nodiscard]] std::string refusal(const nanovdb::GridHandle<>& handle) const {
    nanovdb::io::writeGrid(folder_.file("a.nvdb").string(), handle);
    return error_of([&] { (void)read_nvdb(folder_.file("a.nvdb")); });
  }

  TemporaryFolder folder_;
};

void damage_leaf(nanovdb::GridHandle<>& handle) {
  auto* leaf = handle.grid<float>()->tree().getFirstLeaf();
  leaf->data()->mValues[5] += 1;
}

TEST_F(NvdbChecksum, WholeFilesOfEveryPrecisionAreRead) {
  EXPECT_EQ(refusal(handle_of<float>(ChecksumMode::Full)), "");
  EXPECT_EQ(refusal(handle_of<nanovdb::Fp4>(ChecksumMode::Full)), "");
  EXPECT_EQ(refusal(handle_of<nanovdb::Fp8>(ChecksumMode::Full)), "");
  EXPECT_EQ(refusal(handle_of<nanovdb::Fp16>(ChecksumMode::Full)), "");
  EXPECT_EQ(refusal(handle_of<nanovdb::FpN>(ChecksumMode::Full)), "");
}

TEST_F(NvdbChecksum, ADamagedLeafIsRefusedWhereItIsCounted) {
  auto full = handle_of(ChecksumMode::Full);
  damage_leaf(full);
  EXPECT_TRUE(says(refusal(full), "vdb.checksum_of_nodes"));
  for (const ChecksumMode mode : {ChecksumMode::Partial, ChecksumMode::Disable}) {
    auto handle = handle_of(mode);
    damage_leaf(handle);
    EXPECT_EQ(refusal(handle), "");
  }
}

TEST_F(NvdbChecksum, ADamagedHeadIsRefusedWhereItIsCounted) {
  for (const ChecksumMode mode : {ChecksumMode::Partial, ChecksumMode::Full}) {
    auto handle = handle_of(mode);
    head_of(handle).mMap.mVecD[1] += 1;
    EXPECT_TRUE(says(refusal(handle), "vdb.checksum_of_head"));
  }
  auto handle = handle_of(ChecksumMode::Disable);
  head_of(handle).mMap.mVecD[1] += 1;
  EXPECT_EQ(refusal(handle), "");
  head_of(handle).mChecksum = 0;  // as of programs that never compute one
  EXPECT_EQ(refusal(handle), "");
}

/// The tail's checksum with words of 4 bytes, which is how other compilers make it.
std::uint32_t short_words(const nanovdb::NanoGrid<float>& grid) {
  std::vector<std::uint32_t> list;
  const auto add = [&](const auto* first, std::uint32_t count) {
    for (std::uint32_t i = 0; i < count; ++i) {
      list.push_back(std::uint32_t(nanovdb::crc32(first + i, sizeof *first)));
    }
  };
  const auto& tree = grid.tree();
  add(tree.getFirstUpper(), tree.nodeCount(2));
  add(tree.getFirstLower(), tree.nodeCount(1));
  add(tree.getFirstLeaf(), tree.nodeCount(0));
  return std::uint32_t(nanovdb::crc32(list.data(), 4 * list.size()));
}

TEST_F(NvdbChecksum, ListsOfShortWordsAreRead) {
  auto handle = handle_of(ChecksumMode::Full);
  auto& sum = head_of(handle).mChecksum;
  sum = std::uint64_t(short_words(*handle.grid<float>())) << 32 | std::uint32_t(sum);
  EXPECT_EQ(refusal(handle), "");
  damage_leaf(handle);
  EXPECT_TRUE(says(refusal(handle), "vdb.checksum_of_nodes"));
}

/// Head up to the tree, and all that follows in pieces of 4 KiB, the last with the rest.
void set_newer_checksum(nanovdb::GridHandle<>& handle) {
  nanovdb::GridData& head = head_of(handle);
  head.mVersion = nanovdb::Version(32, 7, 0);
  constexpr std::size_t kEnd = sizeof(nanovdb::GridData) + sizeof(nanovdb::TreeData<>);
  const char* bytes = reinterpret_cast<const char*>(&head);
  std::vector<std::uint32_t> list;
  for (std::size_t at = kEnd; head.mGridSize - at >= 4096; at += 4096) {
    const bool last = head.mGridSize - at < 2 * 4096;
    const std::size_t size = last ? head.mGridSize - at : 4096;
    list.push_back(std::uint32_t(nanovdb::crc32(bytes + at, size)));
  }
  const auto nodes = std::uint64_t(nanovdb::crc32(list.data(), 4 * list.size()));
  head.mChecksum = nodes << 32 | std::uint32_t(nanovdb::crc32(bytes + 16, kEnd - 16));
}

TEST_F(NvdbChecksum, FilesOfNewerVersionsAreCountedInPieces) {
  auto handle = handle_of(ChecksumMode::Disable);
  set_newer_checksum(handle);
  EXPECT_EQ(refusal(handle), "");
  damage_leaf(handle);
  EXPECT_TRUE(says(refusal(handle), "vdb.checksum_of_nodes"));
  head_of(handle).mMap.mVecD[1] += 1;
  EXPECT_TRUE(says(refusal(handle), "vdb.checksum_of_head"));
}

}  // namespace nvdb_checksum_test
}  // namespace pvol::formats
