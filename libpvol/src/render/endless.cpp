#include "render/endless.h"

#include <string>

#include "math/digits.h"
#include "pvol/error.h"
#include "pvol/render/plan.h"

namespace pvol::detail {
namespace {

constexpr double kMostEvents = 1e6;

std::string scatterings(double count, double thickness, double albedo) {
  return "a path would scatter about " + digits(count) + " times (optical thickness up to " +
         digits(thickness) + ", albedo " + digits(albedo) + "), expected at most " +
         digits(kMostEvents) +
         ". Lower medium.extinction, limit paths with --max-bounces N, or insist with --force.";
}

std::string growing_weights(double excess, double thickness, double growth, double most) {
  return "weights would grow without end: majorants are up to " + digits(excess) +
         " times too low in a cloud of optical thickness up to " + digits(thickness) +
         ", so that the variance grows by exp(" + digits(growth) + "), expected at most exp(" +
         digits(most) + "). Fit the cloud again, raise --majorant-scale, or insist with --force.";
}

std::string null_collisions(double count) {
  return "a ray would meet about " + digits(count) +
         " null collisions in one segment, expected at most " + digits(kMostEvents) +
         ". Lower medium.extinction, leave --depth at auto and --tracker at decomposition, or "
         "insist with --force.";
}

}  // namespace

void refuse_endless_work(const Volume& volume, const VolumeFacts& facts,
                         const RenderOptions& options) {
  const auto refuse = [&](const std::string& why) {
    throw Error(volume.name.empty() ? why : volume.name + ": " + why);
  };
  const double albedo = double(largest_albedo(volume.medium));
  const double thickness = facts.largest_optical_thickness;
  const double count = estimate_scatterings(thickness, albedo);
  if (count > kMostEvents && !options.max_bounces) refuse(scatterings(count, thickness, albedo));
  // Second moments of weights grow by exp(4 (k - 1) depth) where majorants are k times too low
  // (THEORY.md, T3.5).
  constexpr double kMostGrowth = 20;
  const double excess = volume.density.majorant_excess, growth = 4 * (excess - 1) * thickness;
  if (growth > kMostGrowth) refuse(growing_weights(excess, thickness, growth, kMostGrowth));
  const double null = worst_null_collisions(volume);
  if (null > kMostEvents) refuse(null_collisions(null));
}

}  // namespace pvol::detail
