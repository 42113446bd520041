#include "cli/timed_render.h"

#include <fmt/format.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <iostream>

#include "cli/film_samples.h"
#include "cli/instructions.h"
#include "cli/interrupt.h"
#include "cli/picture_facts.h"
#include "cli/render_outputs.h"
#include "pvol/error.h"

namespace pvol::cli {

namespace {

/// Writes checkpoints, whatever becomes of the render.
class Checkpoints {
 public:
  Checkpoints(const FrameJob& frame, const RenderJob& job) : frame_(frame), job_(job) {}

  /// Whether one is due, which is so from then on until it is written. From any thread.
  [[nodiscard]] bool due() {
    if (frame_.outputs.exr.empty() || !frame_.outputs.deep.empty()) return false;
    const bool late = frame_.options.checkpoint > 0 && watch_.seconds() > next_;
    if (late || take_checkpoint_request()) due_ = true;
    return due_;
  }

  /// Writes what is there, if it is due. Disks may be full for a while; a render goes on.
  void write_if_due(const TimedRender& t) {
    if (!due_) return;
    try {
      save_pictures(frame_, job_, t);
      if (!frame_.options.common.quiet && !on_terminal()) {
        std::cerr << kRenderTool << ": checkpoint in " << frame_.outputs.exr.string() << ", "
                  << progress_text(t) << " samples\n";
      }
    } catch (const Error& e) {
      print_warnings(kRenderTool, {std::string(e.what()) +
                                   "; no checkpoint was written, and rendering continues"});
    }
    next_ = watch_.seconds() + 60 * frame_.options.checkpoint;
    due_ = false;
  }

 private:
  const FrameJob& frame_;
  const RenderJob& job_;
  const Stopwatch watch_;
  std::atomic<double> next_ = 60 * frame_.options.checkpoint;  // of the watch's seconds
  std::atomic<bool> due_ = false;
};

/// The noise of pixels (`pixel_noise`) once they have `times` as many samples: it falls with their
/// root. Beside its own brightness a pixel that few samples found bright never has more than one of
/// them, so that of small blocks is looked at as well, and the larger noise is expected.
double expected_noise(const Film& film, double noise, double times) {
  constexpr int kEdge = 4;
  double light = 0;
  for (const PixelSums& p : film.pixels) light += luminance(mean(p));
  const double pixels = double(film.pixels.size());
  double sum = 0;
  for (int y = 0; y < film.crop_height; y += kEdge) {
    for (int x = 0; x < film.crop_width; x += kEdge) {
      double variance = 0, brightness = 0, count = 0;
      for (int j = y; j < std::min(y + kEdge, film.crop_height); ++j) {
        for (int i = x; i < std::min(x + kEdge, film.crop_width); ++i) {
          const std::size_t pixel = film.index(i, j);
          variance += luminance_variance(film, pixel);
          brightness += luminance(mean(film.pixels[pixel])), ++count;
        }
      }
      sum += variance / squared_unit_of_noise(brightness / count, light / pixels);
    }
  }
  return std::max(noise, std::sqrt(sum / pixels)) / std::sqrt(times);
}

/// "noise 7.2 % (4 % of the mean), 2.1 % expected", where the number of samples wanted is known.
std::string note(const Film& film, std::uint64_t wanted) {
  double done = 0;
  for (const PixelSums& p : film.pixels) done += p.samples;
  std::string text = noise_text(film);
  const std::optional<double> noise = pixel_noise(film);
  if (double(wanted) > done && noise.value_or(0) > 0) {
    text +=
        ", " + readable(100 * expected_noise(film, *noise, double(wanted) / done)) + " % expected";
  }
  return text;
}

/// "pvol-render: about 12 s of CPU time expected, 0.8 s of it for the guide; 6 s on 2 threads".
std::string forecast_text(const TimeForecast& f, const RenderOptions& o) {
  std::string text =
      fmt::format("{}: about {} of CPU time", kRenderTool, readable_seconds(f.cpu_seconds()));
  text +=
      is_adaptive(o) ? " for " + readable(expected_samples(o)) + " samples per pixel" : " expected";
  if (f.guide_seconds > 0)
    text += ", " + readable_seconds(f.guide_seconds) + " of it for the guide";
  if (f.threads > 1) {
    text +=
        fmt::format("; {} on {} threads", readable_seconds(f.cpu_seconds() / f.threads), f.threads);
  }
  return text;
}

}  // namespace

TimedRender render_timed(const FrameJob& frame, const RenderJob& job, Film begun,
                         const PassDone& show) {
  TimedRender t;
  // The log of a sequence has a line a frame.
  const bool in_log = frame.frames_of_run > 1 && !on_terminal();
  ProgressBar bar(job.frame ? job.frame->label : "rendering", "samples",
                  frame.options.common.quiet || in_log);
  Checkpoints checkpoints(frame, job);
  Stopwatch watch;
  const double before = cpu_seconds();
  std::atomic<std::uint64_t> wanted = 0;
  const auto progress = [&](std::uint64_t done, std::uint64_t total) {
    bar.show(done, total);
    wanted = total;
    return !interrupted();
  };
  const auto pass_done = [&](const Film& film) {
    bar.note(note(film, wanted));
    if (show) show(film);
    TimedRender now;
    now.under_way = &film;
    now.result.complete = false;
    now.cpu_seconds = cpu_seconds() - before, now.wall_seconds = watch.seconds();
    now.samples = count_samples(film), now.samples_wanted = wanted;
    checkpoints.write_if_due(now);
  };
  RenderCallbacks callbacks{progress, pass_done, [&] { return checkpoints.due(); }};
  if (!frame.options.common.quiet || !frame.options.stats.empty()) {
    const std::uint64_t done = count_samples(begun);
    callbacks.forecast = [&, done](const TimeForecast& f) {
      t.forecast = f;
      bar.begin(done, f.sample_seconds / f.threads);
      if (f.sample_seconds > 0 && !frame.options.common.quiet && frame.prints_facts) {
        bar.print(forecast_text(f, job.plan.scene.options));
      }
    };
  }
  t.result = resume(job.plan, std::move(begun), callbacks);
  t.cpu_seconds = cpu_seconds() - before;
  t.wall_seconds = watch.lap();
  t.samples = count_samples(t.result.film);
  t.samples_wanted = t.result.complete ? t.samples : wanted.load();
  return t;
}

TimedRender already_rendered(Film film) {
  TimedRender t;
  t.result.film = std::move(film);
  t.result.guided = true;  // or not: it was said then
  t.samples = t.samples_wanted = count_samples(t.result.film);
  return t;
}

}  // namespace pvol::cli
