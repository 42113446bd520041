// The options about work for many machines.
#pragma once

#include <fmt/format.h>

#include <filesystem>

#include "cli/command_line.h"
#include "cli/split.h"
#include "cli/split_given.h"

namespace pvol::cli {

/// `--for` and `--at-once`, for tools that have work for a queue.
inline void add_form(const CommandLine& app, SplitGiven& given, const std::string& help) {
  app.add_option_function(
         "--for", [&given](const std::string& t) { given.form = *find_named<SplitForm>(t); }, help)
      .type_name("NAME")
      .check(fits(name_of<SplitForm>()));
  app.add_option("--at-once", given.at_once,
                 "With --for slurm: maximum number of tasks that run at a time")
      .type_name("N")
      .check(fits(whole(1, kMostParts)));
}

inline void add_split(const CommandLine& app, SplitGiven& given,
                      std::filesystem::path& local_copies) {
  app.add_option(
         "--split", given.parts,
         fmt::format("Render nothing; print command lines of N parts (1 to {}) of about equal "
                     "work, and of the merge that combines them to the same picture",
                     kMostParts))
      .type_name("N")
      .check(fits(whole(1, kMostParts)));
  add_form(app, given,
           "Output of --split: text, a script for bash or lines for any queue; json; slurm, a "
           "script that submits arrays [text]");
  app.add_option("--local-copies", local_copies,
                 "Copy the scene's files to this folder, unless they are already there, and read "
                 "them from there; auto is a folder of the user in $SLURM_TMPDIR, $TMPDIR or /tmp, "
                 "whichever exists first")
      .type_name("DIR|auto");
}

}  // namespace pvol::cli
