#include "render/light/emission/power_tree.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "bounds/octree_children.h"
#include "pvol/bounds/pyramid.h"
#include "pvol/math/parallel.h"
#include "pvol/volume/extinction_source.h"

namespace pvol::detail {

/// A cube of the octree whose samples are in one brick.
struct PowerTree::Cube {
  Vec3i lo;
  int edge = 0;
  float most = 0;  ///< a bound on the field
};

namespace {

using Cube = PowerTree::Cube;

/// The cubes below a node; `most` bounds the field there, where a terminal lies above it.
void add_cubes(const Octree& tree, std::uint32_t index, Vec3i lo, float most,
               std::vector<Cube>& cubes) {
  const Octree::Node& node = tree.nodes[index];
  const int edge = 1 << Octree::child_log2(int(node.height));
  for (std::uint32_t bit = 0; bit < 64; ++bit) {
    const Octree::Entry* e = tree.child(node, bit);
    if (e == nullptr) continue;
    const Octree::Node* const below =
        e->link & Octree::kNodeBit ? &tree.nodes[e->link & ~Octree::kNodeBit] : nullptr;
    float bound = e->log2 != 0 ? e->hi : most;
    const Vec3i at = lo + Vec3i(int(bit >> 4), int(bit >> 2 & 3), int(bit & 3)) * edge;
    if (below != nullptr && below->height > 0) {
      add_cubes(tree, e->link & ~Octree::kNodeBit, at, bound, cubes);
      continue;
    }
    if (below != nullptr && e->log2 == 0) {  // a leaf in parts
      detail::for_children(tree, *below, {}, [&](const Octree::Entry& part, Vec3i, int) {
        bound = std::max(bound, part.hi);
      });
    }
    cubes.push_back({at, edge, bound});
  }
}

/// Luminance emitted per world unit in a cube, by a few points of it.
template <class Value>
float mean_luminance(const EmissionSource& source, const Value& value, const Affine& to_world,
                     const Cube& cube) {
  constexpr int kAlong = 4;  // each edge
  const Segment anywhere{.t0 = 0, .t1 = 0, .lo = 0, .hi = 0, .leaf = Octree::kNodeBit};
  const double step = double(cube.edge) / kAlong;
  float sum = 0;
  for (int i = 0; i < kAlong * kAlong * kAlong; ++i) {
    const Vec3i at(i / (kAlong * kAlong), i / kAlong % kAlong, i % kAlong);
    const Vec3d cells = Vec3d(cube.lo) + (Vec3d(at) + Vec3d(0.5)) * step;
    const LatticePoint p = lattice_point(source.field->octree, cells);
    sum += luminance(source.at(value, anywhere, p, to_world.point(cells)));
  }
  return sum / (kAlong * kAlong * kAlong);
}

/// What a cube may emit by its bounds.
float bound_of(const EmissionSource& source, const Cube& cube) {
  const Rgb of_bound = source.fire != nullptr
                           ? source.fire->fire.color * float(source.fire->fire.intensity)
                           : source.of_depth;
  return cube.most * luminance(of_bound);
}

std::uint64_t code_of(Vec3f lo) { return morton_encode(Vec3<std::uint32_t>(lo)); }

}  // namespace

float PowerTree::Node::seen_from(Vec3f cell) const {
  const Vec3f away = cell - (lo + hi) * 0.5f, half = (hi - lo) * 0.5f;
  return power / std::max(dot(away, away), dot(half, half));
}

std::vector<PowerTree::Node> PowerTree::join(std::vector<Node> cubes) {
  // A density of directions tests all boxes that its line meets. From as few as this on, what is
  // saved weighs more than directions that suit the fire less (tests/bench/RESULTS.md).
  constexpr std::size_t kMostBoxes = 32;
  for (int shift = 3; cubes.size() > kMostBoxes; shift += 3) {
    std::vector<Node> fewer;
    for (const Node& c : cubes) {
      if (fewer.empty() || code_of(fewer.back().lo) >> shift != code_of(c.lo) >> shift) {
        fewer.push_back(c);
        continue;
      }
      Node& to = fewer.back();
      to.lo = min(to.lo, c.lo);
      to.hi = max(to.hi, c.hi);
      to.power += c.power;
    }
    cubes = std::move(fewer);
  }
  return cubes;
}

PowerTree::PowerTree(const EmissionSource& source) {
  const VolumeField& f = *source.field;
  const Affine to_world = inverse(f.world_to_cells);
  std::vector<Cube> cubes;
  add_cubes(f.octree, 0, Vec3i(0), 0, cubes);
  // Points may miss what is small: a little of the power is that of the bounds.
  constexpr float kMissed = 1e-4f;
  std::vector<Node> leaves(cubes.size());
  visit_source(f, [&](const auto& value) {
    parallel_for(0, cubes.size(), [&](std::size_t i) {
      const Cube& c = cubes[i];
      const auto edge = float(c.edge);
      const Vec3f lo(c.lo);
      const float light =
          mean_luminance(source, value, to_world, c) + kMissed * bound_of(source, c);
      leaves[i] = {.lo = lo, .hi = lo + Vec3f(edge), .power = light * edge * edge * edge};
    });
  });
  std::erase_if(leaves, [](const Node& n) { return !(n.power > 0); });
  if (leaves.empty()) return;
  std::sort(leaves.begin(), leaves.end(),
            [](const Node& a, const Node& b) { return code_of(a.lo) < code_of(b.lo); });
  leaves = join(std::move(leaves));
  constexpr int kTopShift = 3 * 20;  // of the bits that tell the root's children apart
  nodes_.emplace_back();
  build(leaves, 0, leaves.size(), kTopShift, 0);
}

void PowerTree::build(std::vector<Node>& cubes, std::size_t begin, std::size_t end, int shift,
                      std::size_t at) {
  if (end - begin == 1) {
    nodes_[at] = cubes[begin];
    return;
  }
  std::array<std::size_t, 9> cuts{};
  std::size_t parts = 0;
  for (;; shift -= 3) {  // down to where they differ
    parts = 0;
    for (std::size_t i = begin; i < end; ++parts) {
      cuts[parts] = i;
      const std::uint64_t own = code_of(cubes[i].lo) >> shift;
      while (i < end && code_of(cubes[i].lo) >> shift == own) ++i;
    }
    cuts[parts] = end;
    if (parts > 1) break;
  }
  const std::size_t first = nodes_.size();
  nodes_.resize(first + parts);
  Node node{.lo = Vec3f(1e30f), .hi = Vec3f(-1e30f)};
  for (std::size_t k = 0; k < parts; ++k) {
    build(cubes, cuts[k], cuts[k + 1], shift - 3, first + k);
    const Node& child = nodes_[first + k];
    node.lo = min(node.lo, child.lo);
    node.hi = max(node.hi, child.hi);
    node.power += child.power;
  }
  node.first = std::uint32_t(first);
  node.count = std::uint32_t(parts);
  nodes_[at] = node;
}

/// A point evenly in a cube that is chosen, from node to node, in proportion to weight(node).
template <class Weight>
Vec3d PowerTree::sample_by(const Weight& weight, Rng& rng) const {
  const Node* node = &nodes_.front();
  while (node->count > 0) {
    std::array<float, 8> weights{};
    float sum = 0;
    for (std::uint32_t k = 0; k < node->count; ++k) {
      sum += weights[k] = weight(nodes_[node->first + k]);
    }
    float left = rng.uniform() * sum;
    std::uint32_t k = 0;
    while (k + 1 < node->count && !(left < weights[k])) left -= weights[k++];
    node = &nodes_[node->first + k];
  }
  const auto [x, y, z, spare] = rng.uniform4();
  return Vec3d(node->lo + (node->hi - node->lo) * Vec3f(x, y, z));
}

Vec3d PowerTree::sample(Vec3f cell, Rng& rng) const {
  return sample_by([&](const Node& node) { return node.seen_from(cell); }, rng);
}

Vec3d PowerTree::sample(Rng& rng) const {
  return sample_by([](const Node& node) { return node.power; }, rng);
}

/// A ray in cells, by world length.
struct PowerTree::Line {
  Vec3f cell;  ///< its origin, as nodes are seen from there
  Ray ray;
  double cell_volume;
};

double PowerTree::pdf(const Line& line, const Node& node, double share) const {
  const auto span = intersect(Box{Vec3d(node.lo), Vec3d(node.hi)}, line.ray, 0,
                              std::numeric_limits<double>::infinity());
  if (!span) return 0;
  if (node.count == 0) {
    const Vec3d size(node.hi - node.lo);
    const double cubes = span->t1 * span->t1 * span->t1 - span->t0 * span->t0 * span->t0;
    return share * cubes / (3 * size.x * size.y * size.z * line.cell_volume);
  }
  std::array<double, 8> weights{};
  double sum = 0;
  for (std::uint32_t k = 0; k < node.count; ++k) {
    sum += weights[k] = double(nodes_[node.first + k].seen_from(line.cell));
  }
  if (sum == 0) return 0;  // so far away that floats do not hold it
  double density = 0;
  for (std::uint32_t k = 0; k < node.count; ++k) {
    density += pdf(line, nodes_[node.first + k], share * weights[k] / sum);
  }
  return density;
}

double PowerTree::pdf(const Ray& cells, double cell_volume) const {
  if (nodes_.empty()) return 0;
  return pdf({Vec3f(cells.o), cells, cell_volume}, nodes_.front(), 1);
}

PlacedPower::PlacedPower(const EmissionSource& source, std::shared_ptr<const PowerTree> tree)
    : source_(source), tree_(std::move(tree)), still_(place_at(0)) {}

PlacedPower::Place PlacedPower::place_at(float time) const {
  const Affine to_cells = source_.field->world_to_cells * source_.to_first_at(time);
  const Affine to_world = inverse(to_cells);
  const PowerTree::Node& root = *tree_->root();
  const Vec3d corner = to_world.vector(Vec3d(root.hi - root.lo) * 0.5);
  return {to_cells, std::abs(determinant(to_world)), to_world.point(Vec3d(root.lo + root.hi) * 0.5),
          dot(corner, corner)};
}

double PlacedPower::seen_from(Vec3d place, const Place& own) const {
  const Vec3d away = place - own.centre;
  return own.cell_volume * double(tree_->root()->power) / std::max(dot(away, away), own.reach);
}

Vec3d PlacedPower::sample(Vec3d place, const Place& own, Rng& rng) const {
  return inverse(own.to_cells).point(tree_->sample(Vec3f(own.to_cells.point(place)), rng));
}

Vec3d PlacedPower::sample(Rng& rng) const {
  return inverse(still_.to_cells).point(tree_->sample(rng));
}

double PlacedPower::pdf(Vec3d place, Vec3d d, const Place& own) const {
  return tree_->pdf({own.to_cells.point(place), own.to_cells.vector(d)}, own.cell_volume);
}

EmissionLights::EmissionLights(const std::vector<EmissionSource>& sources) {
  std::shared_ptr<const PowerTree> tree;
  const VolumeField* of = nullptr;
  for (const EmissionSource& s : sources) {
    if (s.field != of) tree = std::make_shared<const PowerTree>(s);
    of = s.field;
    if (tree->root() != nullptr) lights_.emplace_back(s, tree);
  }
}

EmissionLights::Towards EmissionLights::sample(Vec3d place, float time, Rng& rng) const {
  PlacedPower::Place moved;
  const auto seen = [&](std::size_t k) {
    return lights_[k].seen_from(place, lights_[k].at(time, moved));
  };
  double sum = 0;
  for (std::size_t k = 0; k < lights_.size(); ++k) sum += seen(k);
  if (!(sum > 0)) return {};
  std::size_t k = 0;
  if (lights_.size() > 1) {
    double left = double(rng.uniform()) * sum;
    while (k + 1 < lights_.size() && !(left < seen(k))) left -= seen(k++);
  }
  const Vec3d way = lights_[k].sample(place, lights_[k].at(time, moved), rng) - place;
  const double distance = length(way);
  if (!(distance > 0)) return {};
  const Vec3f d(way / distance);
  return {d, pdf(place, d, time)};
}

double EmissionLights::power() const {
  double sum = 0;
  for (const PlacedPower& l : lights_) sum += l.power();
  return sum;
}

Vec3d EmissionLights::sample(Rng& rng) const {
  double left = double(rng.uniform()) * power();
  std::size_t k = 0;
  while (k + 1 < lights_.size() && !(left < lights_[k].power())) left -= lights_[k++].power();
  return lights_[k].sample(rng);
}

Vec3d EmissionLights::centre() const {
  const double all = power();
  Vec3d sum;
  for (const PlacedPower& l : lights_) sum += l.centre() * (l.power() / all);
  return sum;
}

float EmissionLights::pdf(Vec3d place, Vec3f direction, float time) const {
  double sum = 0, density = 0;
  PlacedPower::Place moved;
  for (const PlacedPower& l : lights_) {
    const PlacedPower::Place& own = l.at(time, moved);
    const double seen = l.seen_from(place, own);
    if (!(seen > 0)) continue;
    sum += seen;
    density += seen * l.pdf(place, Vec3d(direction), own);
  }
  return sum > 0 ? float(density / sum) : 0;
}

}  // namespace pvol::detail
