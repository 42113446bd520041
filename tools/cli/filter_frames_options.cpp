// The command line of `pvol-convert denoise`.
#include "cli/filter_frames.h"
#include "cli/frames_line.h"
#include "cli/picture_line.h"

namespace pvol::cli {
namespace {

constexpr const char* kFilterExamples =
    R"(Pictures are those of pvol-render --denoise-layers. Frames of a sequence are filtered with light
from the frames before and after: a pixel finds its point there by the cameras, and the depth and
velocity of what they see. Their noise falls further than that of single frames, and no longer
flickers.

Examples:
  pvol-render smoke.####.vdb -o noisy.####.exr --frames 1-240 --spp 16 --denoise-layers
  pvol-convert denoise noisy.####.exr -o smoke.####.exr --frames 1-240
      a sequence with little noise and no flicker
  pvol-convert denoise noisy.####.exr -o smoke.####.exr --frames 1-240 --frame 17
      one frame of it, as a task of a farm
  pvol-convert denoise noisy.exr -o clean.exr
      one picture, as pvol-render --denoise filters it

Exit status: 0 success, 1 failure, 2 wrong usage.)";

}  // namespace

std::optional<int> read_filter_line(int argc, char** argv, FilterGiven& o) {
  const CommandLine app("Filters the noise of rendered pictures and sequences.",
                        "pvol-convert denoise", kFilterExamples);
  add_quiet(app, o.common);
  app.add_option("INPUT", o.input, "Picture of pvol-render --denoise-layers: .exr")
      .type_name("")
      .required();
  add_output(app, o.output, "Picture to write: .exr, with the layout of the input");
  add_frames(app, o.frames);
  app.add_option("--around", o.around,
                 "Number of frames before and after each from which it takes light, 0 to 8; more "
                 "take more time and memory [2]")
      .type_name("N")
      .check(fits(whole(0, 8)));
  app.add_option("--threads", o.threads, "Number of threads; 0 is one per hardware thread [0]")
      .type_name("N")
      .check(fits(whole(0, 1024)));
  return app.parse(argc, argv);
}

}  // namespace pvol::cli
