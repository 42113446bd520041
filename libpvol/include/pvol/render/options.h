// How a scene is rendered. To add an option: its member, its row in `keys`, and the code that obeys
// it; scene files, the command line, reports and manuals follow from the row.
#pragma once

#include <cstdint>
#include <limits>
#include <optional>

#include "pvol/bounds/octree.h"
#include "pvol/math/color_space.h"
#include "pvol/math/keys.h"
#include "pvol/math/names.h"
#include "pvol/render/adaptive_samples.h"
#include "pvol/render/aov.h"
#include "pvol/track/tracker.h"
#include "pvol/volume/kernel.h"
#include "pvol/volume/volume.h"

namespace pvol {

/// Whether camera rays test a cloud's shell before its octree, where there is a shell.
enum class ShellUse {
  automatic,  ///< where an estimate for this camera says that it saves time
  on,
  off,
};
[[nodiscard]] constexpr auto names(ShellUse) {
  return std::to_array<Named<ShellUse>>({
      {ShellUse::automatic, "auto"},
      {ShellUse::on, "on"},
      {ShellUse::off, "off"},
  });
}

/// Whether paths are ended, split and turned by a coarse estimate of the light that they may meet,
/// made before the picture: much less noise in thick, bright clouds, and the same picture on
/// average (THEORY.md, T5.5).
enum class GuideUse {
  automatic,  ///< where it should pay, see choose_guide
  on,
  off,
};
[[nodiscard]] constexpr auto names(GuideUse) {
  return std::to_array<Named<GuideUse>>({
      {GuideUse::automatic, "auto"},
      {GuideUse::on, "on"},
      {GuideUse::off, "off"},
  });
}

/// Whether the light that media and fires emit is gathered along flights, by its integral, rather
/// than where paths collide: far less noise where the medium is thin, more work and more noise
/// where it is thick (THEORY.md, T5.11). Where a fire burns and nothing collides, it always is.
enum class LineEmission {
  automatic,  ///< where a volume is thin; of a fire in the leaves where it pays
  on,
  off,
};
[[nodiscard]] constexpr auto names(LineEmission) {
  return std::to_array<Named<LineEmission>>({
      {LineEmission::automatic, "auto"},
      {LineEmission::on, "on"},
      {LineEmission::off, "off"},
  });
}

/// Whether lamps are asked from places all along flights, not only from where paths collide: far
/// less noise in thin media, above all near lamps, and more work (THEORY.md, T5.25).
enum class LineLamps {
  automatic,  ///< through volumes that are thin, where lamps bring much of the light
  on,
  off,
};
[[nodiscard]] constexpr auto names(LineLamps) {
  return std::to_array<Named<LineLamps>>({
      {LineLamps::automatic, "auto"},
      {LineLamps::on, "on"},
      {LineLamps::off, "off"},
  });
}

/// How light around a pixel counts in it.
enum class PixelFilter {
  box,              ///< its mean over a square
  gaussian,         ///< of a sixth of the width as deviation
  blackman_harris,  ///< sharper than a Gaussian of the same width, as smooth
};
[[nodiscard]] constexpr auto names(PixelFilter) {
  return std::to_array<Named<PixelFilter>>({
      {PixelFilter::box, "box"},
      {PixelFilter::gaussian, "gaussian"},
      {PixelFilter::blackman_harris, "blackman-harris"},
  });
}

/// Most scatterings that paths can be limited to.
inline constexpr std::uint32_t kMostBounces = 65'000;

struct RenderOptions {
  int width = 640, height = 480;
  int crop_x = 0, crop_y = 0;           ///< upper left corner of the part that is rendered
  int crop_width = 0, crop_height = 0;  ///< 0: up to the image's edge
  std::uint32_t samples = 64;           ///< camera samples per pixel
  /// Instead of `samples` in every pixel, adaptive samples until the noise of pixels beside their
  /// own brightness (`pixel_noise`) is about this, or until this many seconds have passed,
  /// whichever comes first.
  std::optional<double> noise, time;
  std::uint32_t first_sample = 0;  ///< number of the first of them: pictures of one seed add up
  /// Which of them are rendered, as `crop` for pixels: from part_begin on, before part_end; all
  /// where that is 0. Of adaptive samples, only the first kPilot can be chosen.
  std::uint32_t part_begin = 0, part_end = 0;
  std::uint64_t seed = 1;
  int threads = 0;  ///< 0: one for each hardware thread
  Tracker tracker = Tracker::decomposition;
  Transmittance transmittance = Transmittance::automatic;
  MicroBoundsUse micro_bounds = MicroBoundsUse::automatic;
  LookUp look_up = LookUp::trilinear;
  ShellUse shells = ShellUse::automatic;
  GuideUse guide = GuideUse::automatic;
  KernelKind kernel = KernelKind::automatic;
  LineEmission line_emission = LineEmission::automatic;
  LineLamps line_lamps = LineLamps::automatic;
  int emission_points = 8;   ///< of a flight, for each 8 voxels of a fire on its way, of media half
  std::optional<int> depth;  ///< deepest octree level at which walks stop, 0 to
                             ///< kDeepestOctree; above it, and without, by cost
  /// Factor on majorants, for measurements: above 1 bounds get looser and the picture stays the
  /// same; below 1, down to 1/3, they do not bound, which takes a tracker with weights.
  double majorant_scale = 1;
  /// Makes images biased: nodes of the octree that can change the optical depth of a ray through
  /// them by no more than this count as homogeneous (homogenise.h).
  std::optional<double> homogenise;
  /// Makes images biased: how often the grid is to be coarsened (coarsen.h) before make_volume,
  /// which takes it as it is.
  int preview = 0;
  std::optional<std::uint32_t> max_bounces;  ///< scatterings per path; a limit makes images biased
  bool background = true;  ///< whether camera rays see the lights behind the cloud
  AovSet aovs;             ///< what the film keeps beside colour and alpha
  bool deep = false;       ///< keep what is seen by depth (deep.h); takes a tracker without weights
  int deep_bins = 64;      ///< into which deep pictures sort the depths of the volumes' boxes
  double deep_error = 0.005;  ///< share of alpha and colour by which merged bins may be off
  PixelFilter filter = PixelFilter::blackman_harris;
  std::optional<double> filter_width;  ///< in pixels; none: 1 of a box, 3 of others
  /// Of every colour of the scene, and of the picture.
  ColorSpace color_space = ColorSpace::rec709;
  bool count = false;  ///< count look-ups and the like, also for no AOV (a few per cent slower)
  friend bool operator==(const RenderOptions&, const RenderOptions&) = default;
};

inline constexpr std::int64_t kLargestEdge = 1 << 20;  ///< of an image; far above any picture
inline constexpr int kMostThreads = 4096;
inline constexpr int kMostDeepBins = 4096;
inline constexpr int kMostCoarsenings = 8;  ///< of a preview: a 256th of the samples along an axis

template <std::same_as<RenderOptions> O>
[[nodiscard]] constexpr auto keys(const O&) {
  constexpr std::int64_t kMost32 = std::numeric_limits<std::uint32_t>::max();
  constexpr std::int64_t kMost63 = std::numeric_limits<std::int64_t>::max();
  return std::to_array<Key<O>>({
      {{.key = "size",
        .metavar = "WxH",
        .limits = whole(1, kLargestEdge).times(2, 'x'),
        .help = "Size of the image in pixels"},
       [](const O& o) {
         return Value(Value::List{to_value(o.width), to_value(o.height)});
       },
       [](O& o, const Value& v) {  // the crop of another size means nothing
         o.crop_x = o.crop_y = o.crop_width = o.crop_height = 0;
         assign(o.width, (*v.list())[0]), assign(o.height, (*v.list())[1]);
       }},
      {{.key = "crop",
        .metavar = "X,Y,W,H",
        .limits = whole(0, kLargestEdge).times(4),
        .help = "Part of the image to render, in pixels; a W or H of 0 ends at the edge",
        .otherwise = "all"},
       [](const O& o) {
         return Value(Value::List{to_value(o.crop_x), to_value(o.crop_y), to_value(o.crop_width),
                                  to_value(o.crop_height)});
       },
       [](O& o, const Value& v) {
         assign(o.crop_x, (*v.list())[0]), assign(o.crop_y, (*v.list())[1]);
         assign(o.crop_width, (*v.list())[2]), assign(o.crop_height, (*v.list())[3]);
       }},
      key<&O::samples>({.key = "spp",
                        .metavar = "N",
                        .limits = whole(1, kMost32),
                        .help = "Samples per pixel",
                        .effect = Effect::cost}),
      key<&O::noise>({.key = "noise",
                      .metavar = "X|off",
                      .limits = number(Range{0, 1, true, false}).or_word("off"),
                      .help = "Replaces --spp: adaptive samples, more where there is more noise, "
                              "until the standard error of pixels is about this fraction of "
                              "their own brightness, 0.02 for 2 %",
                      .effect = Effect::cost}),
      key<&O::time>({.key = "time",
                     .metavar = "SECONDS|off",
                     .limits = number(Range::above(0)).or_word("off"),
                     .help = "Replaces --spp: adaptive samples until this time is used up, more "
                             "where there is more noise; with --noise, whichever limit comes first",
                     .effect = Effect::cost}),
      key<&O::first_sample>({.key = "first_sample",
                             .metavar = "N",
                             .limits = whole(0, kMost32),
                             .help = "Number of the first sample of each pixel; pictures with one "
                                     "seed and different samples are parts of one picture",
                             .effect = Effect::cost}),
      {{.key = "samples",
        .metavar = "A:B",
        .limits = whole(0, kMost32).times(2, ':').also(expect_rising),
        .help = "Render only samples A to B - 1 of the --spp samples of each pixel; pvol-convert "
                "merge combines such parts. With --noise: 0:16, its pilot",
        .otherwise = "all",
        .effect = Effect::cost,
        .in_scenes = false},
       [](const O& o) {
         const std::uint32_t end = o.part_end > 0 ? o.part_end : o.samples;
         return Value(Value::List{to_value(o.part_begin), to_value(end)});
       },
       [](O& o, const Value& v) {
         assign(o.part_begin, (*v.list())[0]), assign(o.part_end, (*v.list())[1]);
         const bool all = !is_adaptive(o) && o.part_begin == 0 && o.part_end == o.samples;
         if (all) o.part_end = 0;
       }},
      key<&O::seed>({.key = "seed",
                     .metavar = "N",
                     .limits = whole(0, kMost63),
                     .help = "Seed of the random numbers",
                     .effect = Effect::cost}),
      key<&O::threads>({.key = "threads",
                        .metavar = "N",
                        .limits = whole(0, kMostThreads),
                        .help = "Threads; 0 is one for each hardware thread",
                        .effect = Effect::cost,
                        .in_scenes = false}),
      key<&O::tracker>({.key = "tracker",
                        .help = "How free paths are sampled: same picture, different cost",
                        .effect = Effect::cost,
                        .factor = "tracker",
                        .sweep = "delta-global delta decomposition weighted-delta "
                                 "weighted-decomposition regular"}),
      key<&O::transmittance>({.key = "transmittance",
                              .help = "How the transmittance of shadow rays is estimated; auto "
                                      "chooses by the cloud's bounds and prints the reason",
                              .effect = Effect::cost,
                              .factor = "shadow rays",
                              .sweep = "analog ratio residual-ratio regular"}),
      key<&O::micro_bounds>(
          {.key = "micro_bounds",
           .help =
               "What saves look-ups: samples as bytes (codes), or bounds of single voxels (1) or "
               "of cubes of 2^3 (2); the picture stays the same to the last bit. auto uses codes "
               "for trilinear and nearest interpolation, 2^3 for tricubic and 1 for procedural, "
               "where they should save time. Codes are for trilinear and nearest, others have 1 "
               "instead; those of 2^3 are read from a .pvol file that has them",
           .effect = Effect::cost,
           .factor = "micro-bounds",
           .sweep = "none 2 1 codes"}),
      key<&O::look_up>(
          {.key = "interpolation",
           .help = "Interpolation between voxels; tricubic is a B-spline, for which a .pvol must "
                   "have been fitted; procedural evaluates a recipe without sampling it",
           .effect = Effect::field,
           .factor = "interpolation",
           .sweep = "nearest trilinear tricubic"}),
      key<&O::shells>(
          {.key = "shells",
           .help = "Whether camera rays test the shell of a .pvol file before its octree; the "
                   "picture stays the same. auto estimates whether that saves time for this camera",
           .effect = Effect::cost,
           .factor = "shells",
           .sweep = "on off"}),
      key<&O::guide>(
          {.key = "guide",
           .help = "Whether paths are guided by a coarse estimate of the light: less noise in "
                   "thick clouds, same picture on average; auto guides where that should save time",
           .effect = Effect::cost,
           .factor = "guided paths",
           .sweep = "on off"}),
      key<&O::kernel>(
          {.key = "kernel",
           .help = "How many paths a thread traces at once: auto uses as many as the machine and "
                   "the scene allow and prints the reason; the picture is the same on average",
           .effect = Effect::cost}),
      key<&O::line_emission>(
          {.key = "line_emission",
           .help = "Whether emission is gathered along flights instead of at collisions; auto does "
                   "so where a cloud is thin, and in the parts of a fire where it pays. Where a "
                   "fire burns without density it always is",
           .effect = Effect::cost,
           .factor = "line emission",
           .sweep = "on off"}),
      key<&O::line_lamps>(
          {.key = "line_lamps",
           .help =
               "Whether lamps are asked from places all along flights, beside those where paths "
               "collide: less noise in thin smoke and fog; auto does so in thin clouds where a trial "
               "says that it pays",
           .effect = Effect::cost,
           .factor = "line lamps",
           .sweep = "on off"}),
      key<&O::emission_points>({.key = "emission_points",
                                .metavar = "N",
                                .limits = whole(1, 64),
                                .help = "Points at which a fire is looked up, per 8 voxels of a "
                                        "flight; media that glow take half as many",
                                .effect = Effect::cost,
                                .factor = "emission points",
                                .sweep = "4 16"}),
      key<&O::depth>({.key = "depth",
                      .metavar = "N|auto",
                      .limits = whole(0, kDeepestOctree).or_word("auto"),
                      .help = "Deepest octree level at which walks stop; above it they "
                              "stop where that costs least",
                      .otherwise = "auto: no limit",
                      .effect = Effect::cost,
                      .factor = "octree depth",
                      .sweep = "0 2 3 4 6 8"}),
      key<&O::max_bounces>(
          {.key = "max_bounces",
           .metavar = "N|none",
           .limits = whole(0, kMostBounces).or_word("none"),
           .help = "Maximum number of scatterings of a path; a limit darkens the picture",
           .effect = Effect::bias,
           .factor = "bounce limit",
           .sweep = "4 16 64 256"}),
      key<&O::background>(
          {.key = "background",
           .help = "Whether the sky is visible behind the cloud; off leaves it transparent"}),
      key<&O::filter>({.key = "filter",
                       .help = "Reconstruction filter of pixels: a box of one pixel is sharp, and "
                               "its edges are jagged"}),
      key<&O::filter_width>({.key = "filter_width",
                             .metavar = "PIXELS",
                             .limits = number(Range::closed(0.01, 100)).or_word("auto"),
                             .help = "Full width of the filter",
                             .otherwise = "auto: 1 for a box, 3 for others"}),
      key<&O::color_space>(
          {.key = "color_space",
           .help = "Linear colour space of the scene's colours and of the picture: rec709 is that "
                   "of sRGB, acescg that of many studios. Black bodies, clear skies and pictures "
                   "of known primaries are converted to it"}),
      key<&O::aovs>({.key = "aov",
                     .help = "Layers that the .exr holds in addition to colour and alpha; "
                             "pvol-stats image needs variance and samples",
                     .effect = Effect::cost}),
      key<&O::deep_bins>(
          {.key = "deep_bins",
           .metavar = "N",
           .limits = whole(1, kMostDeepBins),
           .help = "Number of equal steps of depth in a deep picture, between the front and the "
                   "back of the clouds' boxes; memory is at most 32 bytes per step and pixel",
           .effect = Effect::cost}),
      key<&O::deep_error>(
          {.key = "deep_error",
           .metavar = "X",
           .limits = number(Range::closed(0, 1)),
           .help = "Largest error of a deep picture from merging similar steps of depth, as a "
                   "fraction of a pixel's alpha and colour at any depth",
           .effect = Effect::cost}),
      key<&O::majorant_scale>(
          {.key = "majorant_scale",
           .metavar = "X",
           .limits = number(Range::closed(1 / kMostBoundsExcess, kMostMajorantScale)),
           .help = "For measurements: factor on majorants. Above 1 the picture stays the same; "
                   "below 1 it takes a weighted tracker and more samples",
           .effect = Effect::cost}),
      key<&O::homogenise>({.key = "homogenise",
                           .metavar = "DEPTH",
                           .limits = number(Range::at_least(0)).or_word("off"),
                           .help = "Biased: nodes that can change the optical depth of a ray by no "
                                   "more than this are treated as homogeneous, without look-ups; "
                                   "the log gives a bound on the error of whole rays",
                           .effect = Effect::bias,
                           .factor = "homogenised nodes",
                           .sweep = "0.1 1 10"}),
      key<&O::preview>(
          {.key = "preview",
           .metavar = "N",
           .limits = whole(0, kMostCoarsenings),
           .help = "Biased: halve the number of samples along each axis this many times",
           .effect = Effect::bias,
           .factor = "preview",
           .sweep = "1 2 3"}),
  });
}

/// Whether samples are adaptive.
[[nodiscard]] inline bool is_adaptive(const RenderOptions& o) { return o.noise || o.time; }

/// Samples of a pixel that choices reckon with.
[[nodiscard]] inline double expected_samples(const RenderOptions& o) {
  constexpr double kAdaptive = 256;  // of pictures with little noise
  return is_adaptive(o) ? kAdaptive : o.samples;
}

/// Samples of a pixel that are rendered, adaptive ones as expected_samples estimates them.
[[nodiscard]] inline double samples_of_part(const RenderOptions& o) {
  return o.part_end > 0 ? double(o.part_end) - o.part_begin : expected_samples(o);
}

/// A crop that does not lie inside the image, samples that the picture does not have, and noise of
/// a picture of one pixel.
[[nodiscard]] std::optional<Misfit> misfit(const RenderOptions& options);

/// Throws Error for values out of range, alone or together.
void validate(const RenderOptions& options);

}  // namespace pvol
