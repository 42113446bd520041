// Scenes from texts, for the tests of their reader and their writer.
#pragma once

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include "pvol/error.h"
#include "pvol/formats/scene_file.h"
#include "support/temporary_folder.h"

namespace pvol::formats {

namespace fs = std::filesystem;
using Sets = std::vector<std::string>;

/// Writes text to a scene file in a folder of its own.
class SceneText : public testing::Test {
 protected:
  [[nodiscard]] fs::path write(const std::string& text) const {
    std::ofstream(folder_ / "s.toml", std::ios::binary) << text;
    return folder_ / "s.toml";
  }
  [[nodiscard]] SceneFile read(const std::string& text, const Sets& sets = {}) const {
    return read_scene(write(text), sets);
  }
  /// The message for a text, without the name of the folder.
  [[nodiscard]] std::string error(const std::string& text, const Sets& sets = {}) const {
    try {
      (void)read(text, sets);
    } catch (const Error& e) {
      std::string message = e.what();
      const std::string prefix = (folder_ / "").string();
      if (const auto at = message.find(prefix); at != std::string::npos) {
        message.erase(at, prefix.size());
      }
      return message;
    }
    return "no error";
  }

  const TemporaryFolder own_;
  const fs::path folder_ = own_.path();
};

inline const std::string kCloud =
    "[volume]\nfile = \"cloud.pvol\"\n";  // two lines: sections begin at 3

[[nodiscard]] inline const Sun& sun(const SceneFile& file, std::size_t i) {
  return std::get<Sun>(file.scene.lights[i]);
}

}  // namespace pvol::formats
