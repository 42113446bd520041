// Both checksums are CRC32. Up to version 32.6.0 the head's reaches to the end of the root, and
// that of the nodes is one of a list of their own, level by level; since then the head ends with
// the tree, and the rest counts in pieces of 4 KiB.
#include "vdb/nvdb_checksum.h"

#include <fmt/format.h>

#include <zlib.h>

#include <algorithm>

#include "pvol/error.h"

namespace pvol::formats::detail {
namespace {

using Crc = std::uint32_t;
constexpr std::uint64_t kTreeEnd = sizeof(nanovdb::GridData) + sizeof(nanovdb::TreeData<>);

struct Stored {
  Crc head = 0, nodes = 0;
};

/// What the file says. All bits set means none; a file with 0 in both places never had them
/// computed.
Stored stored_in(const NvdbMemory& memory) {
  const std::uint64_t both = memory.at<nanovdb::GridData>(0).mChecksum;
  return {Crc(both), Crc(both >> 32)};
}

bool is_given(const NvdbMemory& memory, Crc part) {
  return part != ~Crc(0) && memory.at<nanovdb::GridData>(0).mChecksum != 0;
}

bool is_in_pieces(const NvdbMemory& memory) {
  const std::uint32_t version = memory.at<nanovdb::GridData>(0).mVersion.id();
  return version > (32u << 21 | 6u << 10);
}

Crc crc_of(const void* bytes, std::uint64_t size) {
  return Crc(::crc32_z(0, static_cast<const Bytef*>(bytes), size));
}

void expect_crc(const NvdbMemory& memory, const char* what, Crc found, Crc expected) {
  if (found == expected) return;
  throw Error(
      fmt::format("{}found {:08x} as checksum of {}, expected {:08x}, which the file "
                  "carries; the file is damaged: copy it again, or convert the original "
                  "once more",
                  memory.where, found, what, expected));
}

/// Of pieces, the last of which has the rest as well.
Crc crc_of_pieces(const char* bytes, std::uint64_t size) {
  constexpr std::uint64_t kPiece = 4096;
  std::vector<Crc> list(size / kPiece);
  for (std::size_t i = 0; i < list.size(); ++i) {
    const bool last = i + 1 == list.size();
    list[i] = crc_of(bytes + i * kPiece, last ? size - i * kPiece : kPiece);
  }
  return crc_of(list.data(), list.size() * sizeof(Crc));
}

/// Of each node, level by level, in the order of memory.
std::vector<Crc> crcs_of(const NvdbMemory& memory, const NvdbLevels& levels,
                         std::uint64_t NvdbNode::*size) {
  std::vector<Crc> list;
  for (std::vector<NvdbNode> nodes : levels) {
    std::ranges::sort(nodes, {}, &NvdbNode::offset);
    for (const NvdbNode& n : nodes) list.push_back(crc_of(memory.data() + n.offset, n.*size));
  }
  return list;
}

/// Of a list of checksums, each as a word of a type that differs between compilers.
template <class Word>
Crc crc_of_list(const std::vector<Crc>& list) {
  const std::vector<Word> words(list.begin(), list.end());
  return crc_of(words.data(), words.size() * sizeof(Word));
}

}  // namespace

void check_head(const NvdbMemory& memory, std::uint64_t root_end) {
  constexpr std::uint64_t kUnchecked = 16;  // magic and checksum themselves
  const Crc expected = stored_in(memory).head;
  if (!is_given(memory, expected)) return;
  const std::uint64_t end = is_in_pieces(memory) ? kTreeEnd : root_end;
  expect_crc(memory, "its head", crc_of(memory.data() + kUnchecked, end - kUnchecked), expected);
}

void check_nodes(const NvdbMemory& memory, const NvdbLevels& levels) {
  const Crc expected = stored_in(memory).nodes;
  if (!is_given(memory, expected)) return;
  const std::uint64_t end = memory.at<nanovdb::GridData>(0).mGridSize;
  if (is_in_pieces(memory)) {
    const Crc found = crc_of_pieces(memory.data() + kTreeEnd, std::max(end, kTreeEnd) - kTreeEnd);
    return expect_crc(memory, "its nodes", found, expected);
  }
  // Some versions leave out the values of leaves whose size differs.
  Crc found = 0;
  for (const auto size : {&NvdbNode::size, &NvdbNode::fixed_size}) {
    const std::vector<Crc> list = crcs_of(memory, levels, size);
    found = crc_of_list<std::uint64_t>(list);
    if (found == expected || crc_of_list<std::uint32_t>(list) == expected) return;
  }
  expect_crc(memory, "its nodes", found, expected);
}

}  // namespace pvol::formats::detail
