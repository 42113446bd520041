// What the C API's handles and walks are made of.
#pragma once

#include <array>
#include <atomic>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <string>

#include "capi/brick_update.h"
#include "capi/ray_kernels.h"
#include "capi/samples.h"
#include "pvol/bounds/pyramid.h"
#include "pvol/pvol.h"
#include "pvol/shell/ray_shell.h"
#include "pvol/volume/batch.h"
#include "pvol/volume/volume.h"
#include "volume/flights.h"
#include "volume/linked_bricks.h"

namespace pvol::detail {

/// A volume as rays see it.
struct Committed {
  std::shared_ptr<Volume> volume = std::make_shared<Volume>();
  std::shared_ptr<const BoundedBricks> bricks{};  ///< not null
  std::shared_ptr<const Shell> known_shell{};     ///< of the density, fitted or read; or null
  Affine cells_to_world{};
  Rgb share{1.0f};  ///< of the extinction, by channel
  /// Those beside the density.
  std::array<std::shared_ptr<const VolumeField>, PVOL_MOST_FIELDS> fields{};
  std::optional<RayShell> shell{};
  std::optional<BatchField> batch{};
  Flights flights{};     ///< by pvol's own streams
  RayKernels kernels{};  ///< by the caller's numbers
};

/// A pvol_walk's contents.
struct CapiWalk {
  const Committed* volume = nullptr;
  RayWalk walk{};
  LeafHandle leaf = 0;  ///< of the current segment
};
static_assert(sizeof(CapiWalk) <= sizeof(pvol_walk) && alignof(CapiWalk) <= alignof(pvol_walk));
static_assert(std::is_trivially_copyable_v<CapiWalk> && std::is_trivially_destructible_v<CapiWalk>);

/// What was set, and whether that was after the last commit.
struct Settings {
  double extinction = 1;
  Rgb share{1.0f};
  LookUp look_up = LookUp::trilinear;
  bool shell = false;
  std::array<FieldSamples, PVOL_MOST_FIELDS> fields{};
};

}  // namespace pvol::detail

struct pvol_volume {
  std::atomic<int> references = 1;
  std::string message;
  pvol_error_function error_function = nullptr;
  void* error_user = nullptr;

  pvol::detail::Settings settings;
  std::unique_ptr<const pvol::detail::Committed> committed;

  std::mutex cancelling;         ///< guards `cancel`
  std::function<void()> cancel;  ///< ends the commit that runs; empty: none does
};
