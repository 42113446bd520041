// Lists of frames and patterns in names: what they stand for, and what is refused.
#include "cli/frames.h"

#include <gtest/gtest.h>

#include "cli/cli.h"
#include "support/messages.h"

namespace pvol::cli {
namespace frames_test {

using Frames = std::vector<int>;

std::string refusal(const std::string& text) {
  try {
    static_cast<void>(parse_frames(text));
    return "";
  } catch (const UsageError& e) {
    return e.what();
  }
}

TEST(Frames, AreNumbersAndRangesWithSteps) {
  EXPECT_EQ(parse_frames("17"), Frames{17});
  EXPECT_EQ(parse_frames("0"), Frames{0});
  EXPECT_EQ(parse_frames("0017"), Frames{17}) << "decimal, not octal";
  EXPECT_EQ(parse_frames("1-4"), (Frames{1, 2, 3, 4}));
  EXPECT_EQ(parse_frames("5-5"), Frames{5});
  EXPECT_EQ(parse_frames("1-10x3"), (Frames{1, 4, 7, 10}));
  EXPECT_EQ(parse_frames("1-9x3"), (Frames{1, 4, 7}));
  EXPECT_EQ(parse_frames("1-3x9999999"), Frames{1});
}

TEST(Frames, MayBeNegative) {
  EXPECT_EQ(parse_frames("-3"), Frames{-3});
  EXPECT_EQ(parse_frames("-2-1"), (Frames{-2, -1, 0, 1}));
  EXPECT_EQ(parse_frames("-5--3"), (Frames{-5, -4, -3}));
  EXPECT_EQ(parse_frames("-4-4x4"), (Frames{-4, 0, 4}));
}

TEST(Frames, KeepTheOrderOfTheListAndComeOnce) {
  EXPECT_EQ(parse_frames("1-2,15,20-24x2"), (Frames{1, 2, 15, 20, 22, 24}));
  EXPECT_EQ(parse_frames("9,1-3"), (Frames{9, 1, 2, 3}));
  EXPECT_EQ(parse_frames("1-5x2,1-5"), (Frames{1, 3, 5, 2, 4}));
}

TEST(Frames, OfOtherFormsAreRefusedWithExamples) {
  for (const char* text : {"", "a", "1-", "-", "1--", "1,", ",1", "1,,2", "1 - 2", "1-2x", "1x2",
                           "1-2x-1", "1..2", "1.5", "+1", "12345678", "1-99999999999999999999"}) {
    const std::string told = refusal(text);
    EXPECT_TRUE(says(told, "frames.frame_such")) << text << ": " << told;
  }
  EXPECT_TRUE(says(refusal("1,b,2"), "frames.b_frame_such")) << "the part that is wrong";
  EXPECT_TRUE(says(refusal("10-1"), "frames.range_descends"));
  EXPECT_TRUE(says(refusal("-3--5"), "frames.negative_range_descends"));
  EXPECT_TRUE(says(refusal("1-10x0"), "frames.step_zero"));
}

TEST(Frames, AreOfALimitedNumber) {
  EXPECT_EQ(parse_frames("1-100000").size(), kMostFrames);
  EXPECT_TRUE(says(refusal("0-100000"), "frames.most_frames"));
  EXPECT_EQ(parse_frames("-9999999-9999999x9999999"), (Frames{-9999999, 0, 9999999}));
}

TEST(Patterns, AreFoundInNamesAndNotInFolders) {
  for (const char* file :
       {"a.####.vdb", "#", "a/b#.vdb", "%04d.exr", "a.%d", "c#/a.%012d.vdb", "a.$F4.vdb", "$F"}) {
    EXPECT_TRUE(has_pattern(file)) << file;
  }
  for (const char* file :
       {"a.vdb", "", "c#/a.vdb", "%d/a", "a.%4d.vdb", "%0d", "%00d", "a.%s", "100%.vdb",
        "a.%0123d.vdb", "a.$FF.vdb", "a.$F12.vdb", "$F0", "$Foam", "F4.vdb"}) {
    EXPECT_FALSE(has_pattern(file)) << file;
    EXPECT_EQ(file_of_frame(file, 7), file);
  }
}

TEST(Patterns, TakeTheNumberWithItsZeros) {
  EXPECT_EQ(file_of_frame("a.####.vdb", 17), "a.0017.vdb");
  EXPECT_EQ(file_of_frame("a.####.vdb", 0), "a.0000.vdb");
  EXPECT_EQ(file_of_frame("a.####.vdb", 12345), "a.12345.vdb");
  EXPECT_EQ(file_of_frame("a#.vdb", 17), "a17.vdb");
  EXPECT_EQ(file_of_frame("a.##.vdb", 7), "a.07.vdb");
  EXPECT_EQ(file_of_frame("/tmp/c#/a.###.vdb", 7), "/tmp/c#/a.007.vdb");
  for (const int frame : {17, 0, 12345, -5, -12345}) {
    EXPECT_EQ(file_of_frame("a.%04d.vdb", frame), file_of_frame("a.####.vdb", frame));
    EXPECT_EQ(file_of_frame("a.%d.vdb", frame), file_of_frame("a.#.vdb", frame));
    EXPECT_EQ(file_of_frame("a.$F4.vdb", frame), file_of_frame("a.####.vdb", frame));
    EXPECT_EQ(file_of_frame("a.$F.vdb", frame), file_of_frame("a.#.vdb", frame));
  }
  EXPECT_EQ(file_of_frame("%010d", 3), "0000000003");
  const std::string many(100'000, '#');
  EXPECT_EQ(file_of_frame(many, 1).string().size(), many.size());
}

TEST(Patterns, CountTheSignOfNegativeFramesAsPrintfDoes) {
  EXPECT_EQ(file_of_frame("a.####.vdb", -5), "a.-005.vdb");
  EXPECT_EQ(file_of_frame("a.#.vdb", -5), "a.-5.vdb");
  EXPECT_EQ(file_of_frame("a.####.vdb", -1234), "a.-1234.vdb");
}

TEST(Patterns, OfSeveralTheLastCounts) {
  EXPECT_EQ(file_of_frame("fire#2.####.vdb", 17), "fire#2.0017.vdb");
  EXPECT_EQ(file_of_frame("fire#2.%03d.vdb", 17), "fire#2.017.vdb");
  EXPECT_EQ(file_of_frame("%d.#.vdb", 17), "%d.17.vdb");
  EXPECT_EQ(file_of_frame("#.%d.%d.vdb", 17), "#.%d.17.vdb");
}

TEST(Patterns, ArePutBeforeTheEnding) {
  EXPECT_EQ(with_pattern("cloud.exr"), "cloud.####.exr");
  EXPECT_EQ(with_pattern("a/b.c/cloud.deep.exr"), "a/b.c/cloud.deep.####.exr");
  EXPECT_EQ(with_pattern("a.%4d.exr"), "a.%04d.exr");
}

}  // namespace frames_test
}  // namespace pvol::cli
