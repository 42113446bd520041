// Paths that were split and wait for their turn.
#pragma once

#include <array>
#include <cstddef>

#include "render/guide/importance.h"

namespace pvol::detail {

/// Importance above which paths are split, and the most that one of them is split into.
inline constexpr float kSplitAbove = 2, kMostCopies = 8;

/// Equal paths that wait at a collision to be scattered.
template <class Place>
struct Branch {
  Place place;
  const MediumComponent* component;
  const Importance::Row* row;
  Vec3f direction;  ///< of the flight that ended there
  Rgb throughput;   ///< of each
  std::uint32_t scatterings;
  int copies;
};

/// Those of a camera path. While all places are taken, paths are not split, so that none is
/// dropped.
template <class Place>
class Branches {
 public:
  [[nodiscard]] bool full() const { return count_ == all_.size(); }
  void add(const Branch<Place>& branch) { all_[count_++] = branch; }
  /// The last one, once for each of its copies, until the next call; null where none waits.
  [[nodiscard]] const Branch<Place>* take() {
    if (count_ == 0) return nullptr;
    Branch<Place>& last = all_[count_ - 1];
    if (--last.copies == 0) --count_;
    return &last;
  }

 private:
  std::array<Branch<Place>, 16> all_;
  std::size_t count_ = 0;
};

}  // namespace pvol::detail
