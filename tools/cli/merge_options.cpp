// The command line of `pvol-convert merge`.
#include "cli/merge.h"
#include "cli/picture_line.h"

namespace pvol::cli {
namespace {

constexpr const char* kExamples =
    R"(Parts are pictures that pvol-render wrote with --samples, --crop or another seed, checkpoints of
interrupted renders, and merges of those: all .exr with exact sums. The bytes of the whole do not
depend on the order of the parts or on earlier merges. If all parts have one seed, they are the
bytes of a single render. The noise of the whole is that of all samples together.

Examples:
  pvol-render scene.toml --samples 0:32 -o a.exr && pvol-render scene.toml --samples 32:64 -o b.exr
  pvol-convert merge a.exr b.exr -o whole.exr
      the bytes of pvol-render scene.toml --spp 64 -o whole.exr
  pvol-convert merge --partial parts/*.exr -o so_far.exr
      the work of a farm so far

Exit status: 0 success, 1 failure, 2 wrong usage.)";

}  // namespace

std::optional<int> read_merge_line(int argc, char** argv, MergeGiven& o) {
  const CommandLine app("Merges parts of a picture into one.", "pvol-convert merge", kExamples);
  add_quiet(app, o.common);
  app.add_option("PART", o.parts, "Parts of a picture: .exr with exact sums")
      .type_name("")
      .required();
  add_output(app, o.output, "Picture to write: .exr, with the layout of the parts");
  app.add_flag("--partial", o.partial,
               "Merge the parts that exist even if samples are missing or parts are unfinished; "
               "the picture keeps its sums, so the rest can be merged later");
  app.add_option("--crop", o.crop, "Part of the image that the parts cover [all]")
      .type_name("X,Y,W,H")
      .separated_by(',')
      .values(4);
  add_named(app, "--sums", o.sums,
            "Whether the picture keeps its exact sums; auto: with --partial and --crop [auto]");
  return app.parse(argc, argv);
}

}  // namespace pvol::cli
