#include "cli/split_render.h"

#include "cli/split_slurm.h"
#include "cli/split_text.h"

namespace pvol::cli {
namespace {

std::string commands_of(const RenderOptionsGiven& o, const SplitJob& job) {
  switch (o.split.form.value_or(SplitForm::text)) {
    case SplitForm::json:
      return split_json(job);
    case SplitForm::slurm:
      return slurm_script(slurm_work(job, o));
    case SplitForm::text:
      break;
  }
  return split_script(job);
}

}  // namespace

SplitText split_text(const RenderOptionsGiven& o, const RenderPlan& plan) {
  const SplitJob job = split_job(o, plan);
  return {commands_of(o, job), summary(job)};
}

}  // namespace pvol::cli
