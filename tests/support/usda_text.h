// Scenes of USD for tests.
#pragma once

#include <optional>
#include <string>

#include "pvol/formats/usda_scene.h"
#include "support/temporary_folder.h"

namespace pvol::test {

/// A volume of one field, in a prim of this path.
inline std::string usd_cloud(const std::string& above = "") {
  return R"(
def Volume "cloud"
{
    rel field:density = <)" +
         above + R"(/cloud/density>
    def OpenVDBAsset "density"
    {
        asset filePath = @./cloud.vdb@
        token fieldName = "density"
    }
}
)";
}
inline const std::string kUsdCloud = usd_cloud();

/// A scene of these prims and this metadata of the layer, with the cloud unless there is another.
inline std::string usda_text(const std::string& prims, const std::string& metadata = "",
                             const std::string& cloud = kUsdCloud) {
  return "#usda 1.0\n(\n" + metadata + "\n)\n" + cloud + prims;
}

/// What becomes of a scene in a file of its own.
inline formats::ImportedScene read_usda_text(const std::string& text,
                                             std::optional<int> frame = {}) {
  const TemporaryFolder folder;
  write_bytes(folder.file("a.usda"), text);
  return formats::read_usda(folder.file("a.usda"), "out", frame);
}

/// All notes, a line each.
inline std::string usda_notes(const formats::ImportedScene& scene) {
  std::string all;
  for (const std::string& note : scene.notes) all += note + '\n';
  return all;
}

/// A prim with this operation order and these lines.
inline std::string usda_prim(const std::string& type, const std::string& lines,
                             const std::string& order = "") {
  std::string text = "def " + type + " \"it\"\n{\n" + lines + '\n';
  if (!order.empty()) text += "uniform token[] xformOpOrder = [" + order + "]\n";
  return text + "}\n";
}

}  // namespace pvol::test
