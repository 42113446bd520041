// The keys of scenes: each limit and each default is as tests/formats/scene_keys.txt has it, so
// that none changes unseen.
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>

#include "pvol/formats/scene_file.h"

namespace pvol::formats {
namespace scene_keys_test {

/// A line for each key: its section, default and limits.
std::string all_keys() {
  std::string text;
  for (const SectionManual& section : describe_sections()) {
    for (const SectionManual::Line& line : section.lines) {
      text += section.heading + ' ' + line.key;
      if (!line.otherwise.empty()) text += " = " + line.otherwise;
      text += ": " + line.expected + '\n';
    }
  }
  return text;
}

TEST(SceneKeys, HaveTheLimitsAndDefaultsOfTheList) {
  const std::filesystem::path stored = PVOL_SCENE_KEYS;
  const std::filesystem::path now = std::filesystem::temp_directory_path() / stored.filename();
  std::stringstream listed;
  listed << std::ifstream(stored).rdbuf();
  const std::string keys = all_keys();
  if (keys == listed.str()) return;
  std::ofstream(now) << keys;
  ADD_FAILURE() << "the keys of scenes are not those of " << stored << "; see diff " << stored
                << ' ' << now << ", and copy the second over the first where it is right";
}

}  // namespace scene_keys_test
}  // namespace pvol::formats
