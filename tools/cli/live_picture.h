// A picture that refines on a thread of its own while its scene is changed.
#pragma once

#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <stop_token>
#include <string>
#include <thread>
#include <vector>

#include "cli/live_scene.h"
#include "pvol/render/film.h"

namespace pvol::cli {

/// What there is to see. All states of a picture have numbers that rise.
struct LiveState {
  std::uint64_t number = 0;
  std::uint64_t change = 0;  ///< that it shows, counted from 1
  /// Without exact sums; at first of fewer pixels than the scene asks for. Null before there is
  /// any, and then that of the change before.
  std::shared_ptr<const Film> film{};
  std::shared_ptr<const FilteredPicture> filtered{};  ///< of this film or one before; null: not yet
  /// Of a film with all its pixels: the scene with nothing left to choose, and the plan.
  std::shared_ptr<const RenderJob> job{};
  bool coarse = false;               ///< the film has fewer pixels
  bool finished = false;             ///< it has all its samples
  std::uint64_t samples = 0;         ///< of all its pixels
  std::uint64_t samples_wanted = 0;  ///< 0 where that is not known
  double seconds = 0;                ///< since the change
  std::string error{};               ///< why there is none, or no better one
};

/// How a picture is made, beside its scene.
struct LiveOptions {
  bool filter = false;  ///< filter its noise each time that it has twice the samples
};

/// Renders a scene from coarse to fine: a few pixels at once, then twice as many along each side
/// until there are all, then further samples up to those of the scene. All calls return at once and
/// may come from any thread.
class LivePicture {
 public:
  explicit LivePicture(LiveScene scene);
  LivePicture(const LivePicture&) = delete;
  LivePicture& operator=(const LivePicture&) = delete;

  /// Begins anew with another scene, and returns the number of the change. What was under way is
  /// given up.
  std::uint64_t change(formats::SceneFile scene, const LiveOptions& options = {},
                       GivenClouds given = {});

  [[nodiscard]] LiveState state() const;
  /// The state, as soon as its number is above this one or so many seconds have passed.
  [[nodiscard]] LiveState wait(std::uint64_t number, double seconds) const;

 private:
  struct Request {
    formats::SceneFile scene;
    LiveOptions options{};
    GivenClouds given{};
    std::uint64_t change = 0;
    std::chrono::steady_clock::time_point asked{};
  };

  void work(const std::stop_token& ended);
  void show(Request request, const std::stop_token& ended);
  [[nodiscard]] RenderPlan plan_of(const RenderJob& job, const Scene& scene);
  void show_coarse(const RenderJob& job, LiveState& state, const Request& request,
                   const std::function<bool()>& stale);
  void refine(std::shared_ptr<RenderJob> job, LiveState& state, const Request& request,
              const std::function<bool()>& stale);
  void post(LiveState& state, const Request& request);

  // Of the worker alone:
  LiveScene scene_;
  double speed_ = 0;  ///< samples a second of the coarse picture before; 0: none was
  std::shared_ptr<const Lighting> lighting_{};  ///< of these; null: nothing was planned yet
  Environment environment_{};
  std::vector<Light> lights_{};

  mutable std::mutex mutex_;  ///< of all below
  mutable std::condition_variable_any changed_;
  LiveState state_{};
  std::optional<Request> next_{};
  std::uint64_t changes_ = 0;
  std::jthread worker_;  // last: it uses all others
};

}  // namespace pvol::cli
