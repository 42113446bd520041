// Pictures that are shown in another way, without being rendered again.
#include <gtest/gtest.h>

#include "support/color_shot.h"
#include "support/messages.h"

namespace pvol {
namespace show_test {

using testing::read_text;
using testing::run_tool;
using testing::RunResult;

using Show = testing::ColorShot;

TEST_F(Show, ConvertWritesThePngThatRenderWouldHave) {
  for (const char* background : {"on", "off"}) {
    const std::vector<std::string> display{"--exposure", "1.5", "--tone-map", "filmic"};
    std::vector<std::string> all{"--background", background};
    all.insert(all.end(), display.begin(), display.end());
    ASSERT_EQ(render("a.exr", all).exit, 0);
    std::vector<std::string> words{folder_ / "a.exr", folder_ / "b.png"};
    words.insert(words.end(), display.begin(), display.end());
    const RunResult r = run_tool(PVOL_CONVERT, words);
    ASSERT_EQ(r.exit, 0) << r.err;
    EXPECT_NE(r.out.find("b.png"), std::string::npos) << r.out;
    EXPECT_EQ(read_text(folder_ / "b.png"), read_text(folder_ / "a.png")) << background;
  }
}

TEST_F(Show, WhatGoesWithAPictureAloneIsRefusedElsewhere) {
  for (const char* flag : {"--exposure", "--tone-map"}) {
    const RunResult r = run_tool(
        PVOL_CONVERT,
        {"a.pvol", folder_ / "a.vdb", flag, flag == std::string("--exposure") ? "1" : "filmic"});
    EXPECT_EQ(r.exit, 2);
    EXPECT_TRUE(says(r.err, "show.exposure_without_picture"));
  }
}

}  // namespace show_test
}  // namespace pvol
