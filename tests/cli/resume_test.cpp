// Renders that are killed, stopped or run out of disk, and go on to the bytes of one that was not.
#include <gtest/gtest.h>

#include <algorithm>
#include <csignal>
#include <fstream>

#include "pvol/formats/film_file.h"
#include "support/messages.h"
#include "support/run_tool.h"

namespace pvol {
namespace resume_test {

using testing::operator+;
using testing::read_text;
using testing::run_tool;
using testing::RunResult;
using testing::ScratchFolder;
using testing::Words;

class Resume : public ::testing::Test {
 protected:
  Resume() {
    std::ofstream(ball_) << "[recipe]\nresolution = 40\n[[form]]\nshape = \"ellipsoid\"\n"
                            "centre = [0, 0, 0]\nradii = 1\n";
  }

  [[nodiscard]] Words line(const std::string& name, const Words& more = {}) const {
    return Words{
               ball_,   "-o",  exr(name),  "--size",       "48x48", "--set", "medium.extinction=40",
               "--spp", "128", "--no-png", "--checkpoint", "0"} +
           more;
  }
  RunResult render(const std::string& name, const Words& more = {},
                   const std::function<void(int, const std::string&)>& meanwhile = {}) {
    return run_tool(PVOL_RENDER, line(name, more), meanwhile);
  }
  /// The picture of a render that nobody disturbs.
  const std::string& whole() {
    if (whole_.empty()) {
      EXPECT_EQ(render("whole").exit, 0);
      whole_ = read_text(exr("whole"));
    }
    return whole_;
  }
  [[nodiscard]] std::string exr(const std::string& name) const { return folder_ / (name + ".exr"); }

  /// One thread: the render then takes seconds on any machine.
  RunResult disturb(const std::string& name, const Words& more,
                    const std::function<void(int, const std::string&)>& meanwhile) {
    return render(name, more + Words{"--threads", "1"}, meanwhile);
  }

  /// Sends a signal at the first line of progress.
  static std::function<void(int, const std::string&)> at_progress(int signal) {
    return [signal, sent = false](int pid, const std::string& err) mutable {
      if (sent || err.find(" samples/s") == std::string::npos) return;
      sent = true;
      kill(pid, signal);
    };
  }

  ScratchFolder folder_;
  std::string ball_ = folder_ / "ball.toml";
  std::string whole_;
};

TEST_F(Resume, AfterCtrlCAndTermGivesTheBytesOfOneRender) {
  for (const int signal : {SIGINT, SIGTERM}) {
    std::filesystem::remove(exr("a"));
    const RunResult stopped = disturb("a", {}, at_progress(signal));
    ASSERT_EQ(stopped.exit, 1) << stopped.err << " a render of seconds ended within one";
    EXPECT_TRUE(says(stopped.err, "resume.interrupted_after_samples"));
    const auto header = formats::read_picture_header(exr("a"));
    EXPECT_TRUE(header.has_sums);
    const RunResult again = render("a", {"--resume"});
    EXPECT_EQ(again.exit, 0) << again.err;
    EXPECT_TRUE(says(again.err, "resume.resuming"));
    EXPECT_TRUE(read_text(exr("a")) == whole());
    const RunResult finished = render("a", {"--resume"});
    EXPECT_EQ(finished.exit, 0);
    EXPECT_TRUE(says(finished.err, "resume.finished"));
  }
}

/// SIGUSR1 has a checkpoint written; then the process is killed, and nothing can be saved.
TEST_F(Resume, AfterAKillGoesOnFromTheLastCheckpoint) {
  const auto meanwhile = [asked = false](int pid, const std::string& err) mutable {
    if (!asked && err.find(" samples/s") != std::string::npos) {
      asked = true;
      kill(pid, SIGUSR1);
    }
    if (times_said(err, "resume.checkpoint") > 0) kill(pid, SIGKILL);
  };
  const RunResult killed = disturb("a", {}, meanwhile);
  ASSERT_EQ(killed.signal, SIGKILL) << killed.err;
  const formats::FilmFile checkpoint = formats::read_film_file(exr("a"));
  EXPECT_FALSE(checkpoint.record.pieces.at(0).complete);
  EXPECT_EQ(render("a", {"--resume"}).exit, 0);
  EXPECT_TRUE(read_text(exr("a")) == whole());
}

TEST_F(Resume, ByTheClockCheckpointsLeaveNoTrace) {
  const RunResult r = render("a", {"--checkpoint", "0.0005"});
  EXPECT_EQ(r.exit, 0) << r.err;
  EXPECT_TRUE(says(r.err, "resume.checkpoint"));
  EXPECT_TRUE(read_text(exr("a")) == whole());
}

/// A limit on the size of files stands for a full disk.
TEST_F(Resume, FullDisksLeaveTheLastCheckpoint) {
  ASSERT_EQ(disturb("a", {}, at_progress(SIGTERM)).exit, 1);
  const std::string checkpoint = read_text(exr("a"));
  const Words again = line("a", {"--resume", "--checkpoint", "0.001"});
  const RunResult full =
      run_tool("/bin/sh",
               Words{"-c", "trap '' XFSZ; ulimit -f 16; exec \"$0\" \"$@\"", PVOL_RENDER} + again);
  EXPECT_EQ(full.exit, 1) << full.err;
  EXPECT_TRUE(says(full.err, "resume.no_checkpoint"));
  EXPECT_TRUE(read_text(exr("a")) == checkpoint);
  EXPECT_EQ(render("a", {"--resume"}).exit, 0);
  EXPECT_TRUE(read_text(exr("a")) == whole());
}

TEST_F(Resume, OfPartsAndAdaptiveWorksToo) {
  const Words kinds[] = {{"--samples", "12:125", "--crop", "3,5,40,20"},
                         {"--noise", "0.024", "--aov", "variance,depth,halves"}};
  for (const Words& kind : kinds) {
    std::filesystem::remove(exr("a"));
    ASSERT_EQ(render("b", kind).exit, 0);
    const RunResult stopped = disturb("a", kind, at_progress(SIGTERM));
    ASSERT_EQ(stopped.exit, 1) << stopped.err;
    const RunResult again = render("a", kind + Words{"--resume"});
    ASSERT_EQ(again.exit, 0) << again.err;
    const auto a = formats::read_picture_header(exr("a")),
               b = formats::read_picture_header(exr("b"));
    EXPECT_EQ(a.attributes, b.attributes);
    if (a.has_sums) {
      const Film one = formats::read_film_file(exr("a")).film;
      EXPECT_EQ(one.remainders, formats::read_film_file(exr("b")).film.remainders);
    } else {
      EXPECT_TRUE(read_text(exr("a")) == read_text(exr("b")));
    }
  }
}

/// The work of a sample that an interruption gave up is not counted: adaptive samples depend on it.
TEST_F(Resume, OfCountsGivesTheBytesOfOneRender) {
  const Words kind{"--kernel", "scalar", "--guide", "off",
                   "--spp",    "72",     "--aov",   "collisions,lookups"};
  ASSERT_EQ(render("b", kind).exit, 0);
  const RunResult stopped = disturb("a", kind, at_progress(SIGTERM));
  ASSERT_EQ(stopped.exit, 1) << stopped.err;
  ASSERT_EQ(render("a", kind + Words{"--resume"}).exit, 0);
  EXPECT_TRUE(read_text(exr("a")) == read_text(exr("b")));
}

/// `timeout` and some schedulers signal a process and then its group.
TEST_F(Resume, AfterTwoSignalsAtOnceTheRenderIsSaved) {
  const RunResult r = disturb("a", {}, [sent = false](int pid, const std::string& err) mutable {
    if (sent || err.find(" samples/s") == std::string::npos) return;
    sent = true;
    kill(pid, SIGTERM), kill(pid, SIGINT), kill(pid, SIGTERM);
  });
  EXPECT_EQ(r.exit, 1) << r.err;
  EXPECT_TRUE(formats::read_picture_header(exr("a")).has_sums);
}

TEST_F(Resume, RefusesPicturesOfSomethingElse) {
  const auto refuses = [&](const Words& more, const std::string& key) {
    const std::string before = read_text(exr("a"));
    const RunResult r = render("a", more + Words{"--resume"});
    EXPECT_EQ(r.exit, 1) << r.err;
    EXPECT_TRUE(says(r.err, key));
    EXPECT_TRUE(read_text(exr("a")) == before);
  };
  const Words few{"--spp", "4"};
  ASSERT_EQ(render("a", few).exit, 0);
  refuses({"--spp", "8"}, "resume.resume_exr_another_picture_scene_spp");
  refuses(few + Words{"--set", "medium.g=0.1"}, "resume.resume_exr_another_picture_scene");
  refuses(few + Words{"--samples", "0:2"}, "resume.resume_exr_another");
  refuses(few + Words{"--denoise"}, "resume.resume_exr_another_picture");
  ASSERT_EQ(render("a", few + Words{"--sums", "off", "--samples", "0:2"}).exit, 0);
  std::ofstream(ball_, std::ios::app) << "# another\n";
  refuses(few + Words{"--samples", "0:2"}, "resume.resume_exr_another_picture_contents");
  std::ofstream(exr("a")) << "no picture";
  refuses(few, "resume.not_exr_picture");
}

TEST_F(Resume, WantsAPictureThatKeepsSums) {
  const std::pair<Words, const char*> lines[] = {
      {{"-o", folder_ / "a.png", "--resume"}, "resume.resume_needs_exact"},
      {{"-o", folder_ / "a.png", "--sums", "on"}, "resume.sums_needs_exact"},
      {{"-o", exr("a"), "--resume", "--deep", exr("deep")}, "resume.resume_deep_exclude"},
      {{"-o", exr("a"), "--samples", "4:2"}, "resume.samples_first_number"}};
  for (const auto& [more, key] : lines) {
    const RunResult r = run_tool(PVOL_RENDER, Words{ball_} + more);
    EXPECT_EQ(r.exit, 2) << r.err;
    EXPECT_TRUE(says(r.err, key));
  }
}

}  // namespace resume_test
}  // namespace pvol
