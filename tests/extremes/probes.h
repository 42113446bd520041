// What is rendered at one decade of one quantity, and what it is compared with. Each throws Error
// where pvol refuses.
#pragma once

#include "extremes/extremes.h"

namespace pvol::extremes {

[[nodiscard]] Outcome world_unit(int decade, const Setting& setting);
[[nodiscard]] Outcome density_unit(int decade, const Setting& setting);
[[nodiscard]] Outcome brightness(int decade, const Setting& setting);
[[nodiscard]] Outcome offset(int decade, const Setting& setting);
[[nodiscard]] Outcome voxel_depth(int decade, const Setting& setting);
[[nodiscard]] Outcome camera_distance(int decade, const Setting& setting);
[[nodiscard]] Outcome flatness(int decade, const Setting& setting);
/// 10^decade below 0, 1 - 10^-decade above: of either sign in turn.
[[nodiscard]] Outcome cosine(int decade, const Setting& setting);
[[nodiscard]] std::string cosine_text(int decade);
/// The same, without sign; 1/2 at 0.
[[nodiscard]] Outcome albedo(int decade, const Setting& setting);
[[nodiscard]] std::string albedo_text(int decade);
[[nodiscard]] Outcome pvol_voxel(int decade, const Setting& setting);
[[nodiscard]] Outcome vdb_voxel(int decade, const Setting& setting);

/// Everything at once, each drawn log-uniformly over thirty decades: pixels are finite and opacity
/// is that of the closed form, or the scene is refused.
[[nodiscard]] Outcome random_scene(std::uint64_t number, const Setting& setting);

}  // namespace pvol::extremes
