// Where a ray lies inside a shell: all of its intervals, in closed form.
#pragma once

#include <vector>

#include "pvol/math/box.h"
#include "pvol/shell/shell.h"

namespace pvol {

/// A shell made ready for rays. Immutable; safe to use from any thread.
///
/// Rays are clipped to the shell's box first, so that everything is computed in a parameter s of
/// [0, 1] along the part in the box, from Bernstein coefficients over it. The promise is
/// containment: the spans hold every t at which the ray with exactly the given origin and direction
/// is inside the shell, its box and its surface included; what they hold besides has a slack above
/// -excess() and is no farther from the box than rounding takes it (THEORY.md, T7.3). Both hold for
/// finite rays of any distance; beyond 2^37 half extents the spans are those of the box.
class RayShell {
 public:
  /// The shell must be valid. `origin`: rays are given in cells from this lattice point, not world
  /// space.
  explicit RayShell(const Shell& shell, Vec3l origin = {});

  /// Whether the part of the ray with t in [t0, t1] certainly misses the shell. Does not allocate.
  [[nodiscard]] bool misses(const Ray& ray, double t0, double t1) const;

  /// The spans inside, ascending and disjoint, written over `spans`.
  void intersect(const Ray& ray, double t0, double t1, std::vector<Span>& spans) const;

  /// How far below 0 the slack may be inside the spans, for rays whose origin lies at most
  /// `distance` cells from the box.
  [[nodiscard]] double excess(double distance) const;

 private:
  static constexpr int kLanes = 8;
  static constexpr int kTerms = 10;
  // The vector extension of GCC and Clang: element by element, in as many registers as it takes.
  using Lanes = double __attribute__((vector_size(8 * kLanes)));
  /// Eight quadrics, coefficient by coefficient.
  struct Block {
    Lanes coefficient[kTerms];
  };
  struct Segment;
  struct Controls;

  [[nodiscard]] bool clip(const Ray& ray, double t0, double t1, Segment& segment) const;
  void add(const Quadric& q, double weight);
  void evaluate(const Segment& segment, std::size_t block, Controls& controls) const;
  template <class Visit>
  void visit_hard(const Segment& segment, const Visit& visit) const;
  template <class Visit>
  void visit_soft(const Segment& segment, const Visit& visit) const;
  template <class Visit>
  void visit_parts(const Segment& segment, const Visit& visit) const;

  ShellKind kind_;
  Vec3d lo_, hi_, centre_;  ///< cells from the rays' origin
  double to_unit_;          ///< 1 / unit of the shell's frame
  double scale_ = 0;        ///< slack per unit of what is computed
  /// Hard: the negatives of base and bulges first, then the dents: outside where positive. Soft:
  /// the base, then the forms of the perturbations.
  std::vector<Block> blocks_;
  std::vector<double> weights_;  ///< of the quadrics; their strengths in soft shells
  int count_ = 0;
  int united_ = 1;  ///< number of base and bulges in hard shells
};

}  // namespace pvol
