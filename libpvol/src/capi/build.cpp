#include "capi/build.h"

#include <type_traits>
#include <utility>

#include "capi/brick_update.h"
#include "field/micro_codes.h"
#include "pvol/bounds/pyramid.h"
#include "pvol/error.h"
#include "pvol/field/micro_bounds.h"
#include "pvol/shell/fit_shell.h"
#include "pvol/shell/support.h"
#include "pvol/volume/make_volume.h"
#include "pvol/volume/value_field.h"
#include "volume/field_checks.h"

namespace pvol::detail {
namespace {

/// What is told of a part of some work, as of all of it.
[[nodiscard]] Progress part_of(const Progress& all, double begin, double end) {
  return [&all, begin, end](double done) { all(begin + (end - begin) * done); };
}

/// The samples of a field in a box, where there are new ones.
[[nodiscard]] std::optional<VoxelGrid> read(const FieldSamples& samples, const LatticeBox& box,
                                            const Progress& progress) {
  std::optional<VoxelGrid> grid;
  std::visit(
      [&](const auto& from) {
        using From = std::decay_t<decltype(from)>;
        if constexpr (!std::is_same_v<From, FieldSamples::None> &&
                      !std::is_same_v<From, FieldSamples::Same> &&
                      !std::is_same_v<From, std::shared_ptr<const BoundedDensity>>) {
          grid = read_samples(from, box, progress);
          grid->index_to_world = samples.index_to_world;
        }
      },
      samples.from);
  return grid;
}

[[nodiscard]] bool has_tiles(const FieldSamples& samples) {
  const auto* const leaves = std::get_if<pvol_leaves>(&samples.from);
  return leaves != nullptr && leaves->tile_count > 0;
}

[[nodiscard]] LinkedBricks bricks_of(const VoxelGrid& grid, const Pyramid& pyramid, LookUp look_up,
                                     const FieldSamples& samples) {
  FieldOptions rules;
  rules.look_up = look_up;
  if (!samples.shared) return link(build_field(grid, pyramid, rules));
  const auto* const array = std::get_if<pvol_array>(&samples.from);
  if (array == nullptr) return link(build_shared_field(grid, pyramid, rules));
  const DenseArray where = shared_array(*array);
  return link(build_shared_field(grid, pyramid, rules, &where));
}

/// Refuses samples that cannot be shared, before all of them are read.
void check_shared(const FieldSamples& samples, LookUp look_up) {
  if (!samples.shared) return;
  if (look_up == LookUp::tricubic) {
    throw Error(
        "found tricubic interpolation of shared samples, expected nearest or trilinear; set the "
        "samples instead, which copies them");
  }
  if (const auto* const array = std::get_if<pvol_array>(&samples.from)) (void)shared_array(*array);
}

/// One commit's work on the density.
class DensityBuild {
 public:
  DensityBuild(const Settings& settings, const Committed* before, const Progress& progress,
               Committed& out)
      : s_(settings), before_(before), progress_(progress), out_(out) {
    medium_.extinction = s_.extinction;
    medium_.extinction_color = s_.share;
    options_.look_up = s_.look_up;
  }

  void run() {
    const FieldSamples& samples = s_.fields[PVOL_DENSITY];
    if (std::holds_alternative<FieldSamples::Same>(samples.from)) return reuse();
    if (const auto* given = std::get_if<std::shared_ptr<const BoundedDensity>>(&samples.from)) {
      return take(*given);
    }
    if (can_update_in_place()) return update();
    check_shared(samples, s_.look_up);
    VoxelGrid grid = read(samples, kEverywhere, part_of(progress_, 0, 0.2)).value_or(VoxelGrid{});
    progress_(0.2);
    Pyramid pyramid = build_pyramid(grid, s_.look_up);
    progress_(0.4);
    add_shell(grid, pyramid, nullptr);
    add_bricks(grid, std::move(pyramid), nullptr);
  }

 private:
  const Settings& s_;
  const Committed* before_;
  const Progress& progress_;
  Committed& out_;
  Medium medium_;
  VolumeOptions options_;

  void add_bricks(const VoxelGrid& grid, Pyramid&& pyramid, const LeafMicroBounds* stored) {
    auto made = std::make_shared<BoundedBricks>();
    made->bricks = bricks_of(grid, pyramid, s_.look_up, s_.fields[PVOL_DENSITY]);
    made->pyramid = std::move(pyramid);
    out_.bricks = made;
    progress_(0.6);
    make([&](int edge) {
      const bool known =
          stored != nullptr && stored->by_leaf.edge == edge && s_.look_up != LookUp::tricubic;
      return known ? arrange(*stored, copies_of(made->bricks), made->bricks.brick_of, made->pyramid)
                   : build_micro_bounds(made->bricks, edge);
    });
  }

  void make(const GetMicroBounds& micro_bounds) {
    *out_.volume =
        make_volume(out_.bricks->bricks, out_.bricks->pyramid,
                    s_.fields[PVOL_DENSITY].index_to_world, medium_, options_, micro_bounds);
  }

  [[nodiscard]] bool can_update_in_place() const {
    const FieldSamples& samples = s_.fields[PVOL_DENSITY];
    return !std::holds_alternative<FieldSamples::None>(samples.from) && !samples.changed.empty() &&
           before_ != nullptr && s_.look_up != LookUp::tricubic && !s_.shell && !samples.shared &&
           can_update(*before_->bricks) && !has_tiles(s_.fields[PVOL_DENSITY]);
  }

  /// The density of before but for the leaves that changed.
  void update() {
    const FieldSamples& samples = s_.fields[PVOL_DENSITY];
    // Of each box anew, how much of it is read would not rise.
    const Progress unless_cancelled = [&](double) { progress_(0); };
    const ReadBox read_box = [&](const LatticeBox& box) {
      return *read(samples, box, unless_cancelled);
    };
    out_.bricks = std::make_shared<const BoundedBricks>(
        update_bricks(*before_->bricks, samples.changed, read_box));
    progress_(0.6);
    make([&](int edge) {
      const MicroBounds& known = before_->volume->density.micro;
      if (known.edge != edge) return build_micro_bounds(out_.bricks->bricks, edge);
      MicroBounds updated = known;
      remake_micro_bounds(updated, copies_of(out_.bricks->bricks), out_.bricks->changed);
      return updated;
    });
  }

  /// The density of before under another extinction or place.
  void reuse() {
    out_.known_shell = before_->known_shell;
    const bool was_tricubic = before_->volume->density.look_up == LookUp::tricubic;
    if (was_tricubic != (s_.look_up == LookUp::tricubic)) {
      throw Error(
          "the interpolation changed to or from tricubic, which needs other samples; set the "
          "samples of the density again before the commit");
    }
    if (s_.shell && !out_.known_shell && !before_->bricks->pyramid.empty()) {
      throw Error(
          "a shell is fitted to the density's samples, which were released; set them again before "
          "the commit");
    }
    out_.bricks = before_->bricks;
    make([&](int edge) {
      const MicroBounds& known = before_->volume->density.micro;
      return known.edge == edge ? known : build_micro_bounds(out_.bricks->bricks, edge);
    });
  }

  /// A density with its bounds.
  void take(const std::shared_ptr<const BoundedDensity>& given) {
    const VoxelGrid& grid = given->grid;
    const bool holds = given->pyramid.empty() || holds_for(given->pyramid.look_up, s_.look_up);
    Pyramid pyramid = holds ? given->pyramid : build_pyramid(grid, s_.look_up);
    require_cover(grid, pyramid);
    progress_(0.4);
    add_shell(grid, pyramid, given->shell);
    add_bricks(grid, std::move(pyramid), given->micro_bounds.get());
  }

  void add_shell(const VoxelGrid& grid, const Pyramid& pyramid,
                 const std::shared_ptr<const Shell>& known) {
    out_.known_shell = known;
    if (!s_.shell || known || pyramid.empty()) return;
    ShellOptions o;
    o.index_to_world = s_.fields[PVOL_DENSITY].index_to_world;
    out_.known_shell = std::make_shared<const Shell>(fit_shell(make_support(grid, pyramid), o));
    progress_(0.5);
  }
};

void add_fields(const Settings& s, const Committed* before, const Progress& progress,
                Committed& out) {
  const auto of_field = [&](std::size_t i, double begin, double end) {
    const auto at = [&](double done) {
      return 0.7 + 0.2 * (double(i - 1) + done) / double(s.fields.size() - 1);
    };
    return part_of(progress, at(begin), at(end));
  };
  for (std::size_t i = 1; i < s.fields.size(); ++i) {
    if (std::holds_alternative<FieldSamples::Same>(s.fields[i].from)) {
      auto same = std::make_shared<VolumeField>(*before->fields[i]);
      same->world_to_cells =
          translation(-Vec3d(same->octree.origin)) * inverse(s.fields[i].index_to_world);
      out.fields[i] = std::move(same);
    } else if (const auto grid = read(s.fields[i], kEverywhere, of_field(i, 0, 0.5))) {
      const Pyramid pyramid = build_pyramid(*grid);
      out.fields[i] = std::make_shared<const VolumeField>(
          make_value_field({*grid, pyramid}, {}, {}, "fields beside the density"));
    }
    of_field(i, 0, 1)(1);
  }
}

}  // namespace

std::unique_ptr<const Committed> build(const Settings& settings, const Committed* before,
                                       const Progress& progress) {
  auto out = std::make_unique<Committed>();
  progress(0);
  DensityBuild(settings, before, progress, *out).run();
  progress(0.7);
  add_fields(settings, before, progress, *out);
  const VolumeField& density = out->volume->density;
  out->cells_to_world = inverse(density.world_to_cells);
  out->share = settings.share;
  if (out->known_shell && settings.shell) {
    out->shell.emplace(*out->known_shell, density.octree.origin);
  }
  const bool shared = density.shares_samples();
  out->flights = find_flights(kind_of(density));
  out->kernels = find_ray_kernels(
      {.look_up = density.look_up, .squeeze = squeeze_of(density), .shared = shared});
  out->batch.emplace(std::shared_ptr<const Volume>(out->volume));
  progress(1);
  return out;
}

}  // namespace pvol::detail
