// In place of the sources that cut work into parts, where pvol is built without them.
#include "cli/cli.h"
#include "cli/slurm_script.h"
#include "cli/split_render.h"

namespace pvol::cli {
namespace {

[[noreturn]] void refuse() {
  throw UsageError(
      "this pvol was built without support for render farms; configure it with "
      "-DPVOL_WITH_FARM=ON");
}

}  // namespace

void check_split(const RenderOptionsGiven& o) {
  if (o.split.parts || o.split.form || o.split.at_once) refuse();
}

SplitText split_text(const RenderOptionsGiven& /*o*/, const RenderPlan& /*plan*/) { refuse(); }

std::string slurm_script(const SlurmWork& /*work*/) { refuse(); }

}  // namespace pvol::cli
