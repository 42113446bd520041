// The report of the verb `bounds`: what is measured, and its forms.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "cli/json.h"
#include "pvol/bounds/distribution.h"
#include "pvol/bounds/statistics.h"
#include "pvol/bounds/verify.h"
#include "pvol/formats/cloud.h"
#include "pvol/measure/probe.h"
#include "pvol/volume/facts.h"
#include "pvol/volume/volume.h"
#include "report/document.h"

namespace pvol::cli {

struct BoundsReport {
  std::string file;
  formats::Cloud cloud;
  BoundsStatistics bounds;
  std::vector<DepthDistributions> distributions;
  double empty_share_of_box = 0;

  /// What depends on the extinction.
  struct Cut {
    double extinction = 0;
    VolumeFacts facts;
    Tightness tightness;
  };
  std::optional<Cut> cut;
  std::optional<measure::Probe> probe;      ///< where a render was asked for
  std::optional<BoundsCheck> check;         ///< where the bounds were verified
  std::optional<formats::PvolSizes> bytes;  ///< of a .pvol file

  /// A further grid of a .pvol file.
  struct Field {
    std::string name;
    float largest = 0;
    std::uint64_t leaves = 0;
    Tightness tightness;  ///< of its leaves
    bool verified = false;
  };
  std::vector<Field> fields{};
};

/// A wrong bound in a sentence: what is wrong, where, and by how much.
[[nodiscard]] std::string describe(const WrongBound& wrong, const Affine& index_to_world);
[[nodiscard]] std::string describe(const WrongSupport& wrong);

[[nodiscard]] Json to_json(const BoundsReport& r);
[[nodiscard]] Json to_json(const BoundsCheck& check, const Affine& index_to_world);
/// With `pictures` what only pages show is drawn, too.
[[nodiscard]] report::Document bounds_document(const BoundsReport& r, bool pictures);

// --- the parts that a page draws (bounds_figures.cpp) -------------------------------------------

/// Slices through the middle, and where the look-ups are.
[[nodiscard]] std::vector<report::Content> picture_parts(const BoundsReport& r);
/// Look-ups and tightness by depth.
[[nodiscard]] report::Figures depth_figures(const BoundsReport& r);
/// Histograms of majorants, minorants and gaps of the leaves and of larger cubes.
[[nodiscard]] std::vector<report::Content> histogram_parts(const BoundsReport& r);

}  // namespace pvol::cli
