// The greedy fit: quadrics that together remove as many empty cells of a box as they can.
#pragma once

#include <vector>

#include "shell/fit/separate.h"
#include "shell/fit/support_lattice.h"

namespace pvol::detail {

/// Quadrics R_j that are certified to be below 0 on all of a support, coefficients floats: the
/// first is -F of a shell with base F, the others are its dents. What all leave over is the shell.
class Dents {
 public:
  /// `effort`: factor on the numbers of seeds and iterations.
  Dents(const Support& support, int effort);

  /// Adds one more quadric, the best that is found; false if none removes anything.
  bool add();

  /// Fits quadric j anew, around what the others leave over; true if it got better.
  bool refit(std::size_t j);

  /// Drops all quadrics but the first `count`.
  void keep(std::size_t count);

  [[nodiscard]] const std::vector<Quadric>& quadrics() const { return quadrics_; }
  [[nodiscard]] const SupportLattice& lattice() const { return lattice_; }

 private:
  struct Found {
    Quadric quadric;
    std::size_t removed = 0;  ///< of the empty cells that it was to remove
  };

  [[nodiscard]] std::vector<Seed> make_seeds(const std::vector<std::uint32_t>& cells) const;
  [[nodiscard]] Found best(const std::vector<std::uint32_t>& cells, std::vector<Seed> seeds) const;
  [[nodiscard]] Quadric settle(Quadric q) const;
  [[nodiscard]] std::vector<std::uint8_t> inside(const Quadric& q) const;

  void count(const Quadric& q, int change);

  const Support& support_;
  int effort_;
  SupportLattice lattice_;
  std::vector<Quadric> quadrics_;
  std::vector<std::uint8_t> covers_;  ///< for each empty cell, by how many quadrics it is removed
};

}  // namespace pvol::detail
