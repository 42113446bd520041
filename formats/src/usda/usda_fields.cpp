#include "usda/usda_fields.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <string_view>

#include "pvol/error.h"
#include "pvol/formats/cloud.h"
#include "pvol/formats/field_names.h"

namespace pvol::formats::detail {
namespace {

constexpr std::string_view kFieldPrefix = "field:";
constexpr std::string_view kDigits = "0123456789";

std::string asset_of(const UsdValue& value) {
  const auto* targets = std::get_if<UsdTargets>(&value);
  return targets == nullptr || targets->all.empty() ? "" : targets->all.front().asset;
}

/// "smoke.####.vdb" where that, with the number of the frame, is the name at each sample; else "".
std::string pattern_of(const UsdAttribute& file) {
  const auto& samples = file.content->samples;
  if (samples.size() < 2) return "";
  const std::string first = asset_of(samples.front().second);
  const std::size_t end = first.find_last_of(kDigits) + 1;
  if (end == 0) return "";
  const std::size_t other = first.find_last_not_of(kDigits, end - 1);
  const std::size_t begin = other == first.npos ? 0 : other + 1, width = end - begin;
  const std::string before = first.substr(0, begin), after = first.substr(end);
  if (after.find('/') != after.npos || width > 16) return "";  // no frame, but a folder
  for (const auto& [time, value] : samples) {
    if (!(time >= 0 && time < 1e9 && time == std::floor(time))) return "";
    const std::string number = fmt::format("{:0{}}", int(time), width);
    if (asset_of(value) != before + number + after) return "";
  }
  return before + std::string(width, '#') + after;
}

std::filesystem::path file_of_field(const UsdView& asset, const UsdMaking& making) {
  const UsdAttribute* file = asset.find("filePath");
  if (file == nullptr) return {};
  const std::string pattern = pattern_of(*file);
  if (pattern.empty() || making.stage.is_chosen) return asset.file("filePath");
  making.note(file->where, fmt::format("the files {} are a sequence: render it with --frames; all "
                                       "else is as at frame {}",
                                       usd_shown(pattern), making.stage.frame));
  return file_of(pattern, file->where);
}

/// Whether the file has a grid of this name, if it can be looked at.
bool has_grid(const std::string& file, const std::string& name) {
  try {
    const std::vector<GridEntry> grids = grids_of(file);
    return std::ranges::find(grids, name, &GridEntry::name) != grids.end();
  } catch (const Error&) {
    return false;  // it may be made later
  }
}

/// The name of a grid. fieldIndex tells grids of one name apart; some programs number all grids of
/// a file with it, whose names say enough.
std::string grid_of_field(const UsdView& asset, const std::string& role) {
  const std::string name = asset.word("fieldName", role);
  const double index = asset.number("fieldIndex", 0);
  if (!(index >= 1)) return name;
  const std::string numbered = fmt::format("{}[{}]", name, index);
  return has_grid(asset.file("filePath"), numbered) ? numbered : name;
}

/// Nothing, and named, where it is no file that pvol reads.
std::optional<UsdField> field_at(const std::string& path, const std::string& role,
                                 const UsdWhere& where, const UsdMaking& making) {
  const std::string what = fmt::format("the field \"{}\" is left out: ", usd_shown(role));
  const UsdPrim* prim = making.stage.find(path);
  if (prim == nullptr) {
    making.note(where, what + fmt::format("there is no prim <{}>", usd_shown(path)));
    return std::nullopt;
  }
  if (prim->type != "OpenVDBAsset") {
    making.note(prim->where, what + fmt::format("it is a {}, and pvol reads OpenVDB files",
                                                usd_shown(prim->type)));
    return std::nullopt;
  }
  const UsdView asset = making.stage.view(*prim);
  UsdField field{role, file_of_field(asset, making), "", prim->where};
  const std::string kind = ending(field.file);
  if (kind != ".vdb" && kind != ".nvdb" && kind != ".pvol") {
    making.note(
        prim->where,
        what + fmt::format("{} is no .vdb file",
                           field.file.empty() ? "nothing" : usd_shown(field.file.string())));
    return std::nullopt;
  }
  field.grid = grid_of_field(asset, role);
  if (asset.says("xformOpOrder")) {
    // Renderers place fields by the file and by the volume.
    making.note(prim->where, fmt::format("the transform of the field \"{}\" is left out: that of "
                                         "its Volume counts",
                                         usd_shown(role)));
  }
  for (const char* name : {"extent", "fieldDataType", "fieldClass", "vectorDataRoleHint"}) {
    asset.ignore(name);  // the file says it
  }
  asset.note_unused(*making.notes);
  return field;
}

}  // namespace

std::vector<UsdField> fields_of(const UsdView& volume, const UsdMaking& making) {
  std::vector<UsdField> fields;
  for (const auto& [name, attribute] : volume.prim().attributes) {
    if (!name.starts_with(kFieldPrefix)) continue;
    const std::vector<std::string> targets = volume.paths(name);
    if (targets.empty()) continue;
    const auto field =
        field_at(targets.front(), name.substr(kFieldPrefix.size()), attribute->where, making);
    if (field) fields.push_back(*field);
  }
  return fields;
}

}  // namespace pvol::formats::detail
