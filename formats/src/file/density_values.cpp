#include "file/density_values.h"

#include <fmt/format.h>

#include "file/grid_choice.h"
#include "pvol/error.h"

namespace pvol::formats::detail {

namespace {

std::string of_active(std::uint64_t count, const ValueCounts& counts) {
  return fmt::format("{} of {} active voxels", count, counts.active);
}

}  // namespace

void finish_report(const std::filesystem::path& file, const ValueCounts& counts, float background,
                   bool strict, GridReport& report) {
  report.active = counts.active;
  report.non_finite = counts.non_finite;
  report.negative = counts.negative;
  report.largest = counts.largest;

  std::vector<std::string>& warnings = report.warnings;
  if (counts.non_finite > 0) {
    warnings.push_back(of_active(counts.non_finite, counts) +
                       " are not finite or exceed the range of floats; they are taken as 0");
  }
  if (counts.negative > 0) {
    warnings.push_back(of_active(counts.negative, counts) + " are negative; they are taken as 0");
  }
  if (background != 0) {
    warnings.push_back(fmt::format(
        "the empty space of the grid holds {:g} (its background); it is taken as 0", background));
  }
  if (counts.stray > 0) {
    warnings.push_back(fmt::format(
        "{} inactive voxels hold values other than 0; they are taken as 0", counts.stray));
  }
  if (counts.largest == 0) warnings.push_back("the grid is empty: no voxel has a density above 0");

  if (!strict || warnings.empty()) return;
  std::string text =
      file.string() + ": grid '" + printable(report.grid) + "' is refused (strict): ";
  for (std::size_t i = 0; i < warnings.size(); ++i) text += (i ? "; " : "") + warnings[i];
  throw Error(text);
}

}  // namespace pvol::formats::detail
