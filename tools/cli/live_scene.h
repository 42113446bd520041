// A scene that changes while it is looked at: what a change leaves alone stays in memory.
#pragma once

#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "cli/load_scene.h"
#include "cli/render_report.h"

namespace pvol::cli {

/// The clouds of a scene's volumes that are in memory already, in the order of the volumes; null or
/// missing where they are to be read from files.
using GivenClouds = std::vector<std::shared_ptr<const formats::Cloud>>;

/// Makes scenes ready to render, one after another. Clouds, skies and surfaces that a scene shares
/// with the one before are not read again, and of a volume only what differs is made anew.
class LiveScene {
 public:
  explicit LiveScene(Loader by) : by_(std::move(by)) {}

  /// The scene with nothing left to choose and its volumes, without a plan. Throws Error for files
  /// that cannot be read; what was in memory before is then still there.
  [[nodiscard]] RenderJob prepare(formats::SceneFile scene, const GivenClouds& given = {});

 private:
  /// What a scene says, beside a volume, of how its cloud is read and the volume made.
  struct Making {
    RenderOptions options{};  ///< those of volumes, others as by default
    Shutter shutter{};
    double fps = 0;
    std::optional<Quantisation> density{};
    friend bool operator==(const Making&, const Making&) = default;
  };
  struct Prepared {
    std::shared_ptr<const formats::Cloud> given{};  ///< null: it was read from the volume's file
    formats::SceneVolume asked{}, chosen{};         ///< before and after choices
    std::shared_ptr<const formats::Cloud> cloud{};
    std::shared_ptr<const Volume> volume{};
    VolumeFacts facts{};
    bool is_proven = false;  ///< the cloud's shell holds it
  };

  [[nodiscard]] static Making making_of(const formats::SceneFile& scene);
  [[nodiscard]] Prepared make_volume_of(const formats::SceneFile& scene,
                                        const formats::SceneVolume& asked,
                                        const std::shared_ptr<const formats::Cloud>& given,
                                        std::span<const Prepared> known) const;
  [[nodiscard]] Prepared prepare_volume(const formats::SceneFile& scene,
                                        const formats::SceneVolume& asked,
                                        const std::shared_ptr<const formats::Cloud>& given,
                                        std::span<const Prepared> known) const;
  void load_files(formats::SceneFile& scene) const;

  Loader by_;
  Making making_{};  ///< of the scene before
  std::vector<Prepared> prepared_{};
  Environment sky_{};
  std::vector<Surface> surfaces_{};
};

}  // namespace pvol::cli
