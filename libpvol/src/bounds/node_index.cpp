#include "pvol/bounds/node_index.h"

#include <algorithm>
#include <bit>

namespace pvol {

NodeIndex::NodeIndex(std::span<const PyramidNode> level) : level_(level) {
  std::uint64_t last = 0;  // not level.back(), where codes are out of order
  for (const PyramidNode& node : level) last = std::max(last, node.code);
  if (level.empty()) return;
  shift_ = std::max(0, int(std::bit_width(last)) - int(std::bit_width(level.size())));
  begin_.resize((last >> shift_) + 2, std::uint32_t(level.size()));
  for (std::size_t i = level.size(); i-- > 0;) {
    begin_[level[i].code >> shift_] = std::uint32_t(i);
  }
  // Parts without nodes begin where the next one does.
  for (std::size_t part = begin_.size() - 1; part-- > 0;) {
    begin_[part] = std::min(begin_[part], begin_[part + 1]);
  }
}

NodeIndex::NodeIndex(const Pyramid& pyramid)
    : NodeIndex(pyramid.empty() ? std::span<const PyramidNode>() : pyramid.levels[0]) {}

std::optional<std::size_t> NodeIndex::find(std::uint64_t code) const {
  const std::uint64_t part = code >> shift_;
  if (begin_.empty() || part >= begin_.size() - 1) return std::nullopt;
  const auto end = level_.begin() + begin_[part + 1];
  const auto at = std::lower_bound(
      level_.begin() + begin_[part], end, code,
      [](const PyramidNode& node, std::uint64_t wanted) { return node.code < wanted; });
  if (at == end || at->code != code) return std::nullopt;
  return std::size_t(at - level_.begin());
}

}  // namespace pvol
