// Scenes of pbrt-v4 for tests.
#pragma once

#include <string>

#include "pvol/formats/pbrt_scene.h"
#include "support/temporary_folder.h"

namespace pvol::test {

/// Eight samples in a box that a shape lets in.
inline const std::string kPbrtFog = R"(
MakeNamedMedium "fog" "string type" "uniformgrid" "integer nx" 2 "integer ny" 2 "integer nz" 2
  "float density" [ 1 2 3 4 5 6 7 8 ]
AttributeBegin
  Material "interface"
  MediumInterface "fog" ""
  Shape "trianglemesh" "point3 P" [ 0 0 0 1 0 0 0 1 0 1 1 0 0 0 1 1 0 1 0 1 1 1 1 1 ]
    "integer indices" [ 0 1 2  5 6 7  1 3 4 ]
AttributeEnd
)";

/// A scene of these lines before and after WorldBegin, with the fog unless there is another medium.
inline std::string pbrt_text(const std::string& before, const std::string& after = "",
                             const std::string& fog = kPbrtFog) {
  return before + "\nWorldBegin\n" + fog + after;
}

/// What becomes of a scene in a file of its own.
inline formats::PbrtScene read_pbrt_text(const std::string& text) {
  const TemporaryFolder folder;
  write_bytes(folder.file("a.pbrt"), text);
  return formats::read_pbrt(folder.file("a.pbrt"), "out");
}

/// All notes, a line each.
inline std::string notes_of(const formats::PbrtScene& scene) {
  std::string all;
  for (const std::string& note : scene.notes) all += note + '\n';
  return all;
}

}  // namespace pvol::test
