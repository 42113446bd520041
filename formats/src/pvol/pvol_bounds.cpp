// The BNDS chunk: the pyramid as wide nodes with masks, and the bounds of its terminals.
#include <fmt/format.h>

#include <bit>
#include <cstring>

#include "pvol/error.h"
#include "pvol/pvol_chunks.h"

namespace pvol::formats::detail {
namespace {

/// The children of a wide node of height h and code c are the cubes of level 2h with codes 64 c +
/// b, its groups those of level 2h + 1 with codes 8 c + g.
struct WideNodes {
  std::vector<std::uint64_t> children;  // bit b: the child is not empty
  std::vector<std::uint64_t> stops;     // of upper nodes: the child is uniform
  std::vector<std::uint8_t> groups;     // bit g: the group is one uniform cube
};

/// The height of the top node, whose child 0 or group 0 is the root.
int top_height(std::size_t levels) { return int(levels - 1) / 2; }

using Codes = std::vector<std::uint64_t>;

/// Calls terminal(level, code) for every leaf and uniform cube of a node in order, and collects the
/// codes of the children to descend into.
template <class Terminal>
void visit_terminals(std::uint64_t code, int height, std::uint64_t children, std::uint64_t stops,
                     std::uint32_t groups, Codes& inner, const Terminal& terminal) {
  for (std::uint32_t g = 0; g < 8; ++g) {
    if (groups >> g & 1) {
      terminal(2 * height + 1, 8 * code + g);
      continue;
    }
    for (std::uint64_t left = children >> 8 * g & 0xff; left != 0; left &= left - 1) {
      const std::uint32_t b = 8 * g + std::uint32_t(std::countr_zero(left));
      if (stops >> b & 1) {
        terminal(2 * height, 64 * code + b);
      } else {
        inner.push_back(64 * code + b);
      }
    }
  }
}

class Encoder {
 public:
  explicit Encoder(const Pyramid& pyramid) : p_(pyramid) {
    if (p_.empty()) return;
    Codes codes{0};
    for (int height = top_height(p_.levels.size()); height >= 0; --height) {
      Codes inner;
      for (const std::uint64_t code : codes) add(code, height, inner);
      (height > 0 ? upper_ : lower_) += std::uint32_t(codes.size());
      codes = std::move(inner);
    }
  }

  [[nodiscard]] std::vector<std::byte> bytes() const {
    BoundsHeader h;
    for (int axis = 0; axis < 3; ++axis) {
      h.origin[std::size_t(axis)] = std::int32_t(p_.origin[axis]);
      h.support_lo[std::size_t(axis)] = std::int32_t(p_.support_lo[axis]);
      h.support_hi[std::size_t(axis)] = std::int32_t(p_.support_hi[axis]);
    }
    h.scale = p_.scale;
    h.levels = std::uint32_t(p_.levels.size());
    h.upper = upper_;
    h.lower = lower_;
    h.terminals = std::uint32_t(lo_.size());
    std::vector<std::byte> out;
    append(out, std::span<const BoundsHeader>(&h, 1));
    append(out, std::span(nodes_.children));
    append(out, std::span(nodes_.stops));
    append(out, std::span(lo_));
    append(out, std::span(hi_));
    append(out, std::span(nodes_.groups));
    return out;
  }

  [[nodiscard]] std::size_t terminals() const { return lo_.size(); }

 private:
  template <class Span>
  static void append(std::vector<std::byte>& out, Span values) {
    if (values.empty()) return;
    const std::size_t at = out.size();
    out.resize(at + values.size_bytes());
    std::memcpy(out.data() + at, values.data(), values.size_bytes());
  }

  [[nodiscard]] const PyramidNode* node(int level, std::uint64_t code) const {
    if (std::size_t(level) >= p_.levels.size()) return nullptr;
    const std::vector<PyramidNode>& nodes = p_.levels[std::size_t(level)];
    const auto at = find(nodes, code);
    return at ? &nodes[*at] : nullptr;
  }

  /// Whether the level has nodes among the eight children of a cube.
  [[nodiscard]] bool has_children(int level, std::uint64_t code) const {
    if (level == 0) return false;
    for (std::uint64_t c = 8 * code; c < 8 * code + 8; ++c) {
      if (node(level - 1, c) != nullptr) return true;
    }
    return false;
  }

  void add(std::uint64_t code, int height, Codes& inner) {
    std::uint64_t children = 0, stops = 0;
    std::uint32_t groups = 0;
    for (std::uint32_t g = 0; g < 8; ++g) {
      const std::uint64_t group = 8 * code + g;
      if (node(2 * height + 1, group) && !has_children(2 * height + 1, group)) groups |= 1u << g;
    }
    for (std::uint32_t b = 0; b < 64; ++b) {
      const std::uint64_t child = 64 * code + b;
      if (!node(2 * height, child)) continue;
      children |= std::uint64_t(1) << b;
      if (!has_children(2 * height, child)) stops |= std::uint64_t(1) << b;
    }
    nodes_.children.push_back(children);
    if (height > 0) nodes_.stops.push_back(stops);
    nodes_.groups.push_back(std::uint8_t(groups));
    visit_terminals(code, height, children, stops, groups, inner, [&](int level, std::uint64_t c) {
      const PyramidNode& n = *node(level, c);
      lo_.push_back(encode_down(n.lo, p_.scale));
      hi_.push_back(encode_up(n.hi, p_.scale));
    });
  }

  const Pyramid& p_;
  std::uint32_t upper_ = 0, lower_ = 0;
  WideNodes nodes_;
  std::vector<std::uint16_t> lo_, hi_;
};

class Decoder {
 public:
  Decoder(ChunkReader& chunk, const BoundsHeader& h) : place_(chunk.place()), h_(h) {
    check_counts(chunk.raw_bytes());
    nodes_.children.resize(std::size_t(h.upper) + h.lower);
    nodes_.stops.resize(h.upper);
    nodes_.groups.resize(nodes_.children.size());
    lo_.resize(h.terminals);
    hi_.resize(h.terminals);
    chunk.read(nodes_.children);
    chunk.read(nodes_.stops);
    chunk.read(lo_);
    chunk.read(hi_);
    chunk.read(nodes_.groups);
  }

  [[nodiscard]] Pyramid pyramid() {
    Pyramid p;
    for (int axis = 0; axis < 3; ++axis) {
      p.origin[axis] = h_.origin[std::size_t(axis)];
      p.support_lo[axis] = h_.support_lo[std::size_t(axis)];
      p.support_hi[axis] = h_.support_hi[std::size_t(axis)];
    }
    p.scale = h_.scale;
    p.levels.resize(h_.levels);
    if (!p.empty()) descend(p);
    if (next_node_ != nodes_.children.size() || next_terminal_ != lo_.size()) {
      refuse(place_, fmt::format("the masks lead to {} nodes and {} terminals; expected {} and {}",
                                 next_node_, next_terminal_, nodes_.children.size(), lo_.size()));
    }
    return p;
  }

 private:
  void check_counts(std::uint64_t raw_bytes) const {
    const std::uint64_t nodes = std::uint64_t(h_.upper) + h_.lower;
    const std::uint64_t expected = sizeof(BoundsHeader) + 9 * nodes + 8 * std::uint64_t(h_.upper) +
                                   4 * std::uint64_t(h_.terminals);
    if (raw_bytes != expected) {
      refuse(place_,
             fmt::format("{} raw bytes; its counts of {} and {} nodes and {} terminals take {}",
                         raw_bytes, h_.upper, h_.lower, h_.terminals, expected));
    }
    if (h_.terminals > kMaxTerminals) {
      refuse(place_,
             fmt::format("{} terminals; at most {} can be read", h_.terminals, kMaxTerminals));
    }
    if (h_.levels > std::uint32_t(kMaxRootLog2) - 2) {
      refuse(place_,
             fmt::format("{} levels; at most {} are possible", h_.levels, kMaxRootLog2 - 2));
    }
  }

  void descend(Pyramid& p) {
    Codes codes{0};
    for (int height = top_height(p.levels.size()); height >= 0; --height) {
      Codes inner;
      for (const std::uint64_t code : codes) take(code, height, inner, p);
      codes = std::move(inner);
    }
  }

  void take(std::uint64_t code, int height, Codes& inner, Pyramid& p) {
    const std::size_t i = next_node_++;
    if (i >= nodes_.children.size() || (height > 0) != (i < h_.upper)) {
      refuse(place_,
             fmt::format("the masks lead to more nodes of height {} than there are", height));
    }
    const std::uint64_t children = nodes_.children[i];
    const std::uint64_t stops = height > 0 ? nodes_.stops[i] : children;
    const std::uint32_t groups = nodes_.groups[i];
    check_masks(i, children, stops, groups);
    visit_terminals(code, height, children, stops, groups, inner,
                    [&](int level, std::uint64_t c) { add_terminal(p, level, c); });
  }

  void check_masks(std::size_t i, std::uint64_t children, std::uint64_t stops,
                   std::uint32_t groups) const {
    const auto refuse_node = [&](const std::string& wrong) {
      refuse(place_, fmt::format("node {}: {}", i, wrong));
    };
    if (children == 0 && groups == 0) refuse_node("no children");
    if ((stops & ~children) != 0) refuse_node("an empty child is marked as uniform");
    for (std::uint32_t g = 0; g < 8; ++g) {
      if ((groups >> g & 1) && (children >> 8 * g & 0xff) != 0) {
        refuse_node(fmt::format("group {} is uniform but has children", g));
      }
    }
  }

  void add_terminal(Pyramid& p, int level, std::uint64_t code) {
    const std::size_t i = next_terminal_++;
    if (i >= lo_.size()) refuse(place_, "the masks lead to more terminals than it holds");
    if (std::size_t(level) >= p.levels.size()) refuse(place_, "a cube larger than the root");
    if (lo_[i] > kTopCode || hi_[i] > kTopCode) {
      refuse(place_, fmt::format("terminal {}: a bound above the scale", i));
    }
    p.levels[std::size_t(level)].push_back(
        {code, decode(lo_[i], p.scale), decode(hi_[i], p.scale)});
  }

  const std::string& place_;
  BoundsHeader h_;
  WideNodes nodes_;
  std::vector<std::uint16_t> lo_, hi_;
  std::size_t next_node_ = 0, next_terminal_ = 0;
};

}  // namespace

std::vector<std::byte> encode_bounds(const Pyramid& pyramid, const std::string& place) {
  if (const auto wrong = validate(pyramid)) {
    throw Error(place + ": the bounds to write are wrong: " + *wrong + ".");
  }
  const Encoder encoder(pyramid);
  if (encoder.terminals() > kMaxTerminals) {
    throw Error(fmt::format("{}: the bounds have {} leaves; a file holds at most {}.", place,
                            encoder.terminals(), kMaxTerminals));
  }
  return encoder.bytes();
}

Pyramid decode_bounds(ChunkReader& chunk, LookUp made_for) {
  const auto header = chunk.get<BoundsHeader>();
  Pyramid p = Decoder(chunk, header).pyramid();
  p.look_up = made_for;
  complete_levels(p);
  if (const auto wrong = validate(p)) refuse(chunk.place(), *wrong);
  return p;
}

}  // namespace pvol::formats::detail
