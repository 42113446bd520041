// What shells cost and save: rays alone, whole renders, and plateaus that cores could replace.
//
//   shell_bench CLOUD [GRID|-] [THICKNESS=64]
//
// Rays are isotropic lines through the sphere around the cloud's box; each method tests the box
// first. All methods take turns in one process, and the least time of several rounds counts: quote
// ratios. The octree is cut for a mean optical thickness THICKNESS along x.
#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <functional>
#include <memory>
#include <numbers>
#include <span>
#include <string>
#include <vector>

#include "pvol/formats/cloud.h"
#include "pvol/math/rng.h"
#include "pvol/render/plan.h"
#include "pvol/render/render.h"
#include "pvol/render/scene_volume.h"
#include "pvol/shell/costs.h"
#include "pvol/shell/fit_shell.h"
#include "pvol/shell/ray_shell.h"
#include "pvol/shell/recipe_support.h"
#include "pvol/shell/tightness.h"
#include "pvol/volume/facts.h"
#include "pvol/volume/make_volume.h"

namespace {

using namespace pvol;

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr int kRounds = 7;

double seconds_of(const std::function<void()>& work) {
  const auto begin = std::chrono::steady_clock::now();
  work();
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
}

/// Isotropic lines through the sphere around a box, starting outside of it.
std::vector<Ray> make_lines(const Box& box, int count) {
  std::vector<Ray> lines;
  const double radius = 0.5 * length(box.extent());
  Rng rng(1, 2, 3);
  for (int i = 0; i < count; ++i) {
    const auto [a, b] = rng.uniform2();
    const double z = 2 * double(a) - 1, phi = 2 * std::numbers::pi * double(b);
    const double r = std::sqrt(std::max(0.0, 1 - z * z));
    const Vec3d d{r * std::cos(phi), r * std::sin(phi), z};
    Vec3d s, t;
    orthonormal_basis(d, s, t);
    const auto [u, v] = rng.uniform2();
    const double rho = radius * std::sqrt(double(u)), psi = 2 * std::numbers::pi * double(v);
    const Vec3d offset = s * (rho * std::cos(psi)) + t * (rho * std::sin(psi));
    lines.push_back({box.centre() + offset - d * (1.01 * radius), d});
  }
  return lines;
}

// --- boxes: what a shell is compared with -------------------------------------------------------

/// Tight box of the occupied cells in a box of cells; lo > hi where there are none.
struct CellBox {
  Vec3l lo{std::int64_t(1) << 40}, hi{-(std::int64_t(1) << 40)};
  void add(Vec3l l, Vec3l h) { lo = min(lo, l), hi = max(hi, h); }
  void add(const CellBox& b) { add(b.lo, b.hi); }
  [[nodiscard]] double volume() const {
    const Vec3d e = Vec3d(hi - lo);
    return lo.x < hi.x ? e.x * e.y * e.z : 0;
  }
};

/// The cut of a box that leaves the least volume in the tight boxes of its two halves.
struct Cut {
  double gain = 0;
  CellBox a, b;
};

Cut best_cut(const Support& support, const CellBox& box) {
  Cut best;
  for (int axis = 0; axis < 3; ++axis) {
    std::vector<CellBox> slices(std::size_t(box.hi[axis] - box.lo[axis]));
    for (std::int64_t x = box.lo.x; x < box.hi.x; ++x) {
      for (std::int64_t y = box.lo.y; y < box.hi.y; ++y) {
        for (std::int64_t z = box.lo.z; z < box.hi.z; ++z) {
          const Vec3l cell{x, y, z};
          if (!is_occupied(support, cell)) continue;
          slices[std::size_t(cell[axis] - box.lo[axis])].add(cell, cell + Vec3l(1));
        }
      }
    }
    std::vector<CellBox> after(slices.size() + 1);
    for (std::size_t i = slices.size(); i-- > 0;) {
      after[i] = after[i + 1];
      after[i].add(slices[i]);
    }
    CellBox before;
    for (std::size_t i = 0; i + 1 < slices.size(); ++i) {
      before.add(slices[i]);
      const double gain = box.volume() - before.volume() - after[i + 1].volume();
      if (gain > best.gain) best = {gain, before, after[i + 1]};
    }
  }
  return best;
}

/// `count` boxes that hold the support, by repeatedly making the cut that gains most.
std::vector<CellBox> split_into_boxes(const Support& support, std::size_t count) {
  CellBox whole;
  whole.add(support.lo, support.hi);
  std::vector<CellBox> boxes{whole};
  std::vector<Cut> cuts{best_cut(support, whole)};
  while (boxes.size() < count) {
    const auto best = std::max_element(cuts.begin(), cuts.end(),
                                       [](const Cut& a, const Cut& b) { return a.gain < b.gain; });
    if (!(best->gain > 0)) break;
    const Cut cut = *best;
    const auto i = std::size_t(best - cuts.begin());
    boxes[i] = cut.a;
    boxes.push_back(cut.b);
    cuts[i] = best_cut(support, cut.a);
    cuts.push_back(best_cut(support, cut.b));
  }
  return boxes;
}

/// Boxes side by side, so that the compiler tests several at once.
struct BoxSet {
  std::vector<double> lo[3], hi[3];

  explicit BoxSet(const std::vector<CellBox>& boxes) {
    for (const CellBox& b : boxes) {
      for (int axis = 0; axis < 3; ++axis) {
        lo[axis].push_back(double(b.lo[axis]));
        hi[axis].push_back(double(b.hi[axis]));
      }
    }
  }

  [[nodiscard]] bool hit(const Ray& ray) const {
    const Vec3d inv{1 / ray.d.x, 1 / ray.d.y, 1 / ray.d.z};
    int hits = 0;
    for (std::size_t i = 0; i < lo[0].size(); ++i) {
      double t0 = 0, t1 = kInfinity;
      for (int axis = 0; axis < 3; ++axis) {
        const double a = (lo[axis][i] - ray.o[axis]) * inv[axis];
        const double b = (hi[axis][i] - ray.o[axis]) * inv[axis];
        t0 = std::max(t0, std::min(a, b));
        t1 = std::min(t1, std::max(a, b));
      }
      hits += t0 < t1;
    }
    return hits > 0;
  }
};

// --- rays ---------------------------------------------------------------------------------------

struct Method {
  std::string name;
  std::size_t bytes = 0;
  double volume_ratio = 0;
  std::function<std::size_t()> count_hits;
  std::size_t hits = 0;
  double best = kInfinity;
};

template <class Hit>
std::function<std::size_t()> counter(const std::vector<Ray>& lines, const Box& box, Hit hit) {
  return [&lines, box, hit]() mutable {
    std::size_t hits = 0;
    for (const Ray& ray : lines) {
      const auto span = intersect(box, ray, 0, kInfinity);
      hits += span && hit(ray, *span);
    }
    return hits;
  };
}

Method box_method(const std::vector<Ray>& lines, const Box& box, double cells) {
  return {"box", 24, box.extent().x * box.extent().y * box.extent().z / cells,
          counter(lines, box, [](const Ray&, const Span&) { return true; })};
}

Method boxes_method(const std::vector<Ray>& lines, const Box& box, const Support& support,
                    Vec3l origin, std::size_t count) {
  std::vector<CellBox> boxes = split_into_boxes(support, count);
  double sum = 0;
  for (CellBox& b : boxes) {
    sum += b.volume();
    b.lo -= origin;
    b.hi -= origin;
  }
  const auto set = std::make_shared<BoxSet>(boxes);
  return {std::to_string(boxes.size()) + " boxes", 24 * boxes.size(), sum / double(support.cells),
          counter(lines, box, [set](const Ray& r, const Span&) { return set->hit(r); })};
}

Method octree_method(const std::vector<Ray>& lines, const Box& box, const Octree& tree) {
  return {"octree",
          tree.nodes.size() * sizeof(Octree::Node) + tree.entries.size() * sizeof(Octree::Entry), 0,
          counter(lines, box, [&](const Ray& r, const Span& s) {
            Walk walk(tree, make_cursor(tree, r.at(s.t0)), widen(Vec3f(r.d)));
            return walk.next().has_value();
          })};
}

/// Whether a ray misses the shell, and the spans in it.
void add_shell_methods(const std::vector<Ray>& lines, const Box& box, const Shell& shell,
                       Vec3l origin, std::vector<Method>& methods) {
  const std::size_t k = shell.form.perturbations.size();
  const auto rays = std::make_shared<RayShell>(shell, origin);
  const std::string kind = shell.kind == ShellKind::hard ? "hard" : "soft";
  methods.push_back(
      {kind + " shell K=" + std::to_string(k), 88 + 44 * k, shell.tightness.volume_ratio,
       counter(lines, box,
               [rays](const Ray& r, const Span& s) { return !rays->misses(r, s.t0, s.t1); })});
  methods.push_back(
      {"  its spans", 88 + 44 * k, shell.tightness.volume_ratio,
       counter(lines, box,
               [rays, spans = std::vector<Span>()](const Ray& r, const Span& s) mutable {
                 rays->intersect(r, s.t0, s.t1, spans);
                 return !spans.empty();
               })});
}

void bench_rays(const Support& support, const Volume& volume, const std::vector<Shell>& shells) {
  const Octree& tree = volume.density.octree;
  const Box box{Vec3d(support.lo - tree.origin), Vec3d(support.hi - tree.origin)};
  const std::vector<Ray> lines = make_lines(box, 1 << 16);
  std::vector<Method> methods{box_method(lines, box, double(support.cells))};
  for (const std::size_t count : {16, 64}) {
    methods.push_back(boxes_method(lines, box, support, tree.origin, count));
  }
  methods.push_back(octree_method(lines, box, tree));
  for (const Shell& shell : shells) add_shell_methods(lines, box, shell, tree.origin, methods);
  for (int round = 0; round < kRounds; ++round) {
    for (Method& m : methods) {
      const double s = seconds_of([&] { m.hits = m.count_hits(); });
      m.best = std::min(m.best, s);
    }
  }
  std::size_t true_hits = 0;
  for (const Ray& ray : lines) {
    const Ray in_index{ray.o + Vec3d(tree.origin), ray.d};
    true_hits += first_and_last(support, in_index).has_value();
  }
  std::printf("\n%-20s %9s %9s %9s %9s\n", "rays", "bytes", "volume", "hits", "ns/line");
  for (const Method& m : methods) {
    std::printf("%-20s %9zu %9.3f %9.3f %9.1f\n", m.name.c_str(), m.bytes, m.volume_ratio,
                double(m.hits) / double(true_hits), m.best / double(lines.size()) * 1e9);
  }
}

// --- whole renders ------------------------------------------------------------------------------

bool equal(const Film& a, const Film& b) {
  return std::equal(a.pixels.begin(), a.pixels.end(), b.pixels.begin(),
                    [](const PixelSums& x, const PixelSums& y) {
                      return x.sum == y.sum && x.sum_squares == y.sum_squares && x.alpha == y.alpha;
                    });
}

void bench_render(const char* name, const Volume& volume, Scene scene, double distance) {
  Camera& c = scene.camera;
  c.position = c.target + (c.position - c.target) * distance;
  const auto plan_with = [&](ShellUse use) {
    scene.options.shells = use;
    return plan(std::span(&volume, 1), scene);
  };
  RenderPlan plans[2] = {plan_with(ShellUse::off), plan_with(ShellUse::on)};
  const ShellEstimate estimate = plans[1].shells[0].estimate;
  double best[2] = {kInfinity, kInfinity};
  Film films[2];
  for (int round = 0; round < kRounds; ++round) {
    for (const int on : {0, 1}) {
      best[on] = std::min(best[on], seconds_of([&] { films[on] = render(plans[on]).film; }));
    }
  }
  scene.options.count = true;
  const Counts off = render(plan_with(ShellUse::off)).counts;
  const Counts on = render(plan_with(ShellUse::on)).counts;
  const double samples = double(scene.options.width) * scene.options.height * scene.options.samples;
  std::printf(
      "%-10s %8.3f %9.3f %9.3f %9.3f %9.3f %8.3f %8.3f %8.4f  %s; estimate: spent %.1f ns, "
      "saved %.1f ns\n",
      name, double(on.shell_tests) / samples, double(on.shell_rejections) / samples,
      double(off.path.segments) / samples, double(on.path.segments) / samples,
      double(off.path.null_collisions - on.path.null_collisions) / samples, best[0] / samples * 1e6,
      best[1] / samples * 1e6, best[1] / best[0],
      equal(films[0], films[1]) ? "bits equal" : "BITS DIFFER", estimate.spent, estimate.saved);
}

void bench_renders(const Volume& volume, const Scene& scene) {
  std::printf("\nrenders with the hard shell of %zu perturbations; per camera sample\n",
              volume.shell->form.perturbations.size());
  std::printf("%-10s %8s %9s %9s %9s %9s %8s %8s %8s\n", "camera", "in box", "rejected",
              "segm. off", "segm. on", "- nulls", "us off", "us on", "on/off");
  bench_render("close-up", volume, scene, 0.45);
  bench_render("framed", volume, scene, 1);
  bench_render("far", volume, scene, 8);
}

// --- plateaus -----------------------------------------------------------------------------------

/// How many segments along isotropic lines have bounds within `tolerance` of each other, and how
/// many of those continue the one before: what uniform cores could merge at best.
void count_plateaus(const Volume& volume, double tolerance) {
  const Box box = volume.density.octree.support();
  std::size_t segments = 0, uniform = 0, merged = 0;
  double length_all = 0, length_uniform = 0;
  for (const Ray& ray : make_lines(box, 1 << 14)) {
    const auto span = intersect(box, ray, 0, kInfinity);
    if (!span) continue;
    Walk walk(volume.density.octree, make_cursor(volume.density.octree, ray.at(span->t0)),
              widen(Vec3f(ray.d)));
    std::optional<Segment> before;
    while (const auto s = walk.next()) {
      ++segments;
      length_all += s->t1 - s->t0;
      const bool flat = double(s->hi - s->lo) <= tolerance * double(s->hi);
      if (flat) {
        ++uniform;
        length_uniform += s->t1 - s->t0;
        merged += before && std::abs(double(before->hi - s->hi)) <= tolerance * double(s->hi);
      }
      before = flat ? s : std::nullopt;
    }
  }
  std::printf("%8.0e %9.3f %9.3f %9.3f\n", tolerance, double(uniform) / double(segments),
              double(merged) / double(segments), length_uniform / length_all);
}

int run(int argc, char** argv) {
  if (argc < 2) {
    std::fprintf(stderr, "usage: shell_bench CLOUD [GRID] [THICKNESS=64]\n");
    return 2;
  }
  formats::GridOptions grid;
  if (argc > 2 && std::string(argv[2]) != "-") grid.grid = argv[2];
  const formats::Cloud cloud = formats::load_cloud(argv[1], grid);
  Scene scene;
  scene.options.width = scene.options.height = 128;
  scene.options.samples = 16;
  scene.options.threads = 1;
  const VolumeFacts of_unit = describe(cloud.grid(), 1, {});
  const double thickness = argc > 3 ? std::strtod(argv[3], nullptr) : 64;
  const Medium medium{thickness / of_unit.mean_optical_thickness[0],
                      {Component{.phase = HenyeyGreenstein(0.85)}}};
  Volume volume = make_volume(cloud.grid(), cloud.pyramid, medium, volume_options(scene.options));
  scene.camera = frame(volume.density.world_box, 1);

  const Support support = make_support(cloud.grid(), cloud.pyramid);
  std::printf("%s: %lld x %lld x %lld cells, %llu of them occupied\n", argv[1],
              static_cast<long long>((support.hi - support.lo).x),
              static_cast<long long>((support.hi - support.lo).y),
              static_cast<long long>((support.hi - support.lo).z),
              static_cast<unsigned long long>(support.cells));
  std::vector<Shell> shells;
  for (const int k : {0, 4, 16, 64}) {
    const double s = seconds_of([&] {
      shells.push_back(fit_shell(support, {ShellKind::hard, k}));
    });
    std::printf("fitted hard K=%d in %.1f s\n", k, s);
  }
  for (const int k : {4, 16}) {
    const double s = seconds_of([&] {
      shells.push_back(fit_shell(support, {ShellKind::soft, k}));
    });
    std::printf("fitted soft K=%d in %.1f s\n", k, s);
  }
  bench_rays(support, volume, shells);
  volume.shell = std::make_shared<const Shell>(shells[2]);
  bench_renders(volume, scene);
  std::printf(
      "\nplateaus: share of segments with bounds within a tolerance, of those that could be\n"
      "merged with the one before, and of the length\n%8s %9s %9s %9s\n",
      "within", "uniform", "merged", "length");
  for (const double tolerance : {0.0, 1e-3, 1e-2, 1e-1}) count_plateaus(volume, tolerance);
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  try {
    return run(argc, argv);
  } catch (const std::exception& e) {
    std::fprintf(stderr, "shell_bench: error: %s\n", e.what());
    return 1;
  }
}
