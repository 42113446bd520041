#include "cli/live_picture.h"

#include <algorithm>
#include <atomic>
#include <chrono>
#include <limits>
#include <utility>

#include "cli/cli.h"
#include "cli/film_samples.h"
#include "pvol/render/plan.h"
#include "pvol/render/render.h"

namespace pvol::cli {
namespace {

using Clock = std::chrono::steady_clock;

/// A coarse picture should be there in this time, so that dragging is smooth.
constexpr double kCoarseSeconds = 0.06;
/// Samples a second, before anything is known of the scene: of thick clouds on two cores.
constexpr double kUsualSpeed = 150'000;
constexpr int kCoarsest = 32;
/// For so long the coarsest picture is not given up for a newer change, so that something moves
/// however quickly changes follow each other.
constexpr double kKeptSeconds = 0.15;
/// Between two states of a picture that refines: at least, and as a share of its age.
constexpr double kLeastBetween = 0.15, kShareBetween = 0.05;
/// A filtered picture is worth its time where the film has this many times the samples.
constexpr double kSamplesToFilter = 1.9;

double seconds_since(Clock::time_point t) {
  return std::chrono::duration<double>(Clock::now() - t).count();
}

/// The scene in one sample for each block of pixels.
Scene coarse_scene(const Scene& scene, int factor) {
  Scene coarse = scene;
  RenderOptions& o = coarse.options;
  const auto up = [&](int n) { return (n + factor - 1) / factor; };
  const int right = o.crop_x + (o.crop_width ? o.crop_width : o.width - o.crop_x);
  const int bottom = o.crop_y + (o.crop_height ? o.crop_height : o.height - o.crop_y);
  o.width = up(o.width), o.height = up(o.height);
  o.crop_x /= factor, o.crop_y /= factor;
  o.crop_width = up(right) - o.crop_x, o.crop_height = up(bottom) - o.crop_y;
  o.samples = 1;
  o.noise.reset(), o.time.reset();
  o.part_begin = o.part_end = 0;
  o.guide = GuideUse::off;  // it takes longer than the picture
  return coarse;
}

/// The scene with what the noise filter needs, where it is to be filtered and can be.
Scene scene_to_render(const Scene& scene, const LiveOptions& options) {
  const bool can = is_adaptive(scene.options) || scene.options.samples >= 2;
  return options.filter && can ? with_needs_of_filter(scene) : scene;
}

}  // namespace

LivePicture::LivePicture(LiveScene scene)
    : scene_(std::move(scene)), worker_([this](const std::stop_token& ended) { work(ended); }) {}

std::uint64_t LivePicture::change(formats::SceneFile scene, const LiveOptions& options,
                                  GivenClouds given) {
  const std::lock_guard lock(mutex_);
  next_ = Request{std::move(scene), options, std::move(given), ++changes_, Clock::now()};
  changed_.notify_all();
  return changes_;
}

LiveState LivePicture::state() const {
  const std::lock_guard lock(mutex_);
  return state_;
}

LiveState LivePicture::wait(std::uint64_t number, double seconds) const {
  constexpr double kLongest = 1e6;
  std::unique_lock lock(mutex_);
  (void)changed_.wait_for(lock, std::chrono::duration<double>(std::clamp(seconds, 0.0, kLongest)),
                          [&] { return state_.number > number; });
  return state_;
}

void LivePicture::work(const std::stop_token& ended) {
  for (;;) {
    std::unique_lock lock(mutex_);
    if (!changed_.wait(lock, ended, [&] { return next_.has_value(); })) return;
    Request request = *std::exchange(next_, std::nullopt);
    lock.unlock();
    show(std::move(request), ended);
  }
}

void LivePicture::post(LiveState& state, const Request& request) {
  state.seconds = seconds_since(request.asked);
  if (state.film) state.samples = count_samples(*state.film);
  const std::lock_guard lock(mutex_);
  state.number = state_.number + 1;
  state_ = state;
  changed_.notify_all();
}

void LivePicture::show(Request request, const std::stop_token& ended) {
  const auto stale = [&] {
    if (ended.stop_requested()) return true;
    const std::lock_guard lock(mutex_);
    return next_.has_value();
  };
  LiveState state;
  state.change = request.change;
  try {
    auto job = std::make_shared<RenderJob>(scene_.prepare(std::move(request.scene), request.given));
    show_coarse(*job, state, request, stale);
    if (!stale()) refine(std::move(job), state, request, stale);
  } catch (const std::exception& e) {
    if (!state.film) state.film = this->state().film;
    state.error = e.what();
    state.finished = true;
    post(state, request);
  }
}

RenderPlan LivePicture::plan_of(const RenderJob& job, const Scene& scene) {
  const bool same = lighting_ && scene.environment == environment_ && scene.lights == lights_;
  RenderPlan made = plan(job.volumes, scene,
                         {.facts = job.facts,
                          .force = true,
                          .forecast = false,
                          .lighting = same ? lighting_ : nullptr});
  if (!same) environment_ = scene.environment, lights_ = scene.lights;
  lighting_ = made.lighting;
  return made;
}

void LivePicture::show_coarse(const RenderJob& job, LiveState& state, const Request& request,
                              const std::function<bool()>& stale) {
  const Scene& scene = job.file.scene;
  const RenderOptions& o = scene.options;
  const double pixels = double(o.crop_width ? o.crop_width : o.width - o.crop_x) *
                        (o.crop_height ? o.crop_height : o.height - o.crop_y);
  const double affordable = kCoarseSeconds * (speed_ > 0 ? speed_ : kUsualSpeed);
  int factor = 1;
  while (factor < kCoarsest && pixels / (factor * factor) > affordable) factor *= 2;
  for (bool first = true; first || (factor > 1 && !stale()); factor /= 2, first = false) {
    const Scene coarse = coarse_scene(scene, factor);
    const auto begin = Clock::now();
    const auto goes_on = [&](std::uint64_t, std::uint64_t) {
      return (first && seconds_since(begin) < kKeptSeconds) || !stale();
    };
    const RenderResult result = render(plan_of(job, coarse), goes_on);
    if (!result.complete) return;
    state.film = std::make_shared<const Film>(without_sums(result.film));
    state.coarse = true;
    post(state, request);
    speed_ = double(state.samples) / std::max(1e-6, seconds_since(begin));
  }
}

namespace {

/// A picture with all its pixels while samples are added to it.
class Refinement {
 public:
  using Post = std::function<void(LiveState&)>;

  Refinement(std::shared_ptr<const RenderJob> job, const LiveOptions& options, LiveState& state,
             const std::function<bool()>& stale, const Post& post)
      : job_(std::move(job)), options_(options), state_(state), stale_(stale), post_(post) {}

  void run() {
    RenderCallbacks callbacks;
    callbacks.progress = [&](std::uint64_t, std::uint64_t total) {
      wanted_ = total;
      return !stale_();
    };
    callbacks.pass_done = [&](const Film& film) {
      if (!stale_()) see(film, false);
    };
    callbacks.wants_film = [&] { return seconds_since(shown_) > between_; };
    const RenderResult result = resume(job_->plan, {}, callbacks);
    if (result.complete) see(result.film, true);
  }

 private:
  void see(const Film& film, bool complete) {
    const std::uint64_t samples = count_samples(film);
    const bool filters = options_.filter && least_samples(film) >= 2 &&
                         (complete || double(samples) >= kSamplesToFilter * filtered_samples_);
    state_.film = std::make_shared<const Film>(without_sums(film));
    state_.coarse = false;
    state_.samples_wanted = wanted_;
    state_.finished = complete && !filters;
    post_(state_);
    if (filters) filter(film, complete, double(samples));
    between_ = std::max(kLeastBetween, kShareBetween * state_.seconds);
    shown_ = Clock::now();
  }

  void filter(const Film& film, bool complete, double samples) {
    try {
      state_.filtered = std::make_shared<const FilteredPicture>(
          filter_picture(film, job_->file.scene.options, stale_));
      filtered_samples_ = samples;
    } catch (const Error& e) {
      if (stale_()) return;
      state_.error = e.what();  // the picture is there unfiltered
    }
    state_.finished = complete;
    post_(state_);
  }

  std::shared_ptr<const RenderJob> job_;
  const LiveOptions& options_;
  LiveState& state_;
  const std::function<bool()>& stale_;
  const Post& post_;
  std::atomic<std::uint64_t> wanted_ = 0;
  std::atomic<Clock::time_point> shown_ = Clock::now();
  /// Never before the first pass is whole: the coarse picture has no holes.
  std::atomic<double> between_ = std::numeric_limits<double>::infinity();
  double filtered_samples_ = 0;
};

}  // namespace

void LivePicture::refine(std::shared_ptr<RenderJob> job, LiveState& state, const Request& request,
                         const std::function<bool()>& stale) {
  RenderOptions& asked = job->file.scene.options;
  job->plan = plan_of(*job, scene_to_render(job->file.scene, request.options));
  job->chose_transmittance = asked.transmittance == Transmittance::automatic;
  job->denoise = request.options.filter;
  asked.transmittance = job->plan.scene.options.transmittance;
  state.job = job;
  const Refinement::Post post_state = [&](LiveState& s) { post(s, request); };
  Refinement(std::move(job), request.options, state, stale, post_state).run();
}

}  // namespace pvol::cli
