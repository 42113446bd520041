// A small shot with a fire, smoke and a clear sky, rendered by the tool.
#pragma once

#include <gtest/gtest.h>

#include <fstream>
#include <string>
#include <vector>

#include "pvol/formats/image.h"
#include "support/run_tool.h"

namespace pvol::testing {

class ColorShot : public ::testing::Test {
 protected:
  ColorShot() {
    std::ofstream(scene_) << "[volume]\nfile = \"ball.toml\"\n"
                             "[medium]\nextinction = 3\nalbedo = 0.7\n"
                             "[environment]\nelevation = 20\n"
                             "[medium.fire]\nfield = \"density\"\nkelvin = 2500\nintensity = 0.5\n";
    std::ofstream(folder_ / "ball.toml")
        << "[recipe]\nresolution = 24\n[[form]]\nshape = \"ellipsoid\"\n"
           "centre = [0, 0, 0]\nradii = 1\n";
  }
  RunResult render(const std::string& output, const std::vector<std::string>& more) {
    std::vector<std::string> all{scene_, "-o", folder_ / output, "--size", "24x16", "--spp", "64"};
    all.insert(all.end(), more.begin(), more.end());
    return run_tool(PVOL_RENDER, all);
  }
  Film film(const std::string& name) { return formats::read_film(folder_ / name).film; }

  ScratchFolder folder_;
  std::string scene_ = folder_ / "scene.toml";
};

}  // namespace pvol::testing
