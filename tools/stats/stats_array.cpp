#include "stats/stats_array.h"

#include <fmt/format.h>

#include <algorithm>
#include <iostream>
#include <set>

#include "cli/cli.h"
#include "cli/json.h"
#include "cli/shell_words.h"
#include "cli/slurm_script.h"

namespace pvol::cli {
namespace {

struct Task {
  std::vector<std::string> command;
  std::string output;  ///< what it prints is to be written to
};

/// The command line as given, with one cloud in place of all and the report as JSON.
std::vector<std::string> command_for(const StatsArray& array, const std::string& cloud) {
  std::vector<std::string> all;
  bool placed = false;
  const auto& given = array.arguments;
  const auto is_cloud = [&](const std::filesystem::path& word) {
    return std::ranges::find(array.clouds, word) != array.clouds.end();
  };
  for (std::size_t i = 0; i < given.size(); ++i) {
    const std::string flag = given[i].substr(0, given[i].find('='));
    if (flag == "--for" || flag == "--at-once") {
      i += flag == given[i] ? 1 : 0;
    } else if (i > 1 && is_cloud(given[i])) {
      if (!placed) all.push_back(cloud);
      placed = true;
    } else if (flag != "--json" && flag != "--quiet") {
      all.push_back(given[i]);
    }
  }
  all.insert(all.end(), {"--json", "--quiet"});
  return all;
}

std::vector<Task> tasks_of(const StatsArray& array, const std::string& verb) {
  std::vector<Task> tasks;
  std::set<std::string> outputs;
  for (const std::filesystem::path& cloud : array.clouds) {
    const std::string output = fmt::format("{}.{}.json", cloud.stem().string(), verb);
    if (!outputs.insert(output).second) {
      throw UsageError(fmt::format(
          "{}: the report of another cloud of that name would go to {} as well; rename one of them",
          cloud.string(), output));
    }
    tasks.push_back({command_for(array, cloud.string()), output});
  }
  return tasks;
}

/// Does nothing where the report is there, and writes it whole or not at all.
std::string line_of(const Task& task) {
  const std::string to = shell_word(task.output), aside = shell_word(task.output + ".part");
  return fmt::format("[ -s {} ] || {{ {} >{} && mv {} {}; }}", to, shell_line(task.command), aside,
                     aside, to);
}

std::string print(const StatsArray& array, const std::string& verb) {
  const std::vector<Task> tasks = tasks_of(array, verb);
  std::vector<std::string> lines;
  Json json = Json::array();
  for (const Task& t : tasks) {
    lines.push_back(line_of(t));
    json.push_back({{"command", t.command}, {"stdout", t.output}});
  }
  const std::string about = fmt::format(
      "pvol-stats {} of {} clouds, each reported to CLOUD.{}.json", verb, tasks.size(), verb);
  if (array.given.form == SplitForm::json) return to_text({{"tasks", json}});
  if (array.given.form == SplitForm::slurm) {
    // Times are of one thread, so that a task is best alone on its processor.
    return slurm_script({.about = about + ".",
                         .folder = "pvol-" + verb,
                         .arrays = {{verb, lines}},
                         .at_once = array.given.at_once});
  }
  std::string text = fmt::format("#!/bin/bash\n# {}.\n", about);
  for (const std::string& line : lines) text += line + '\n';
  return text;
}

}  // namespace

int run_or_print(const StatsArray& array, const std::string& verb, bool page,
                 const std::function<int(const std::filesystem::path&)>& run) {
  if (array.given.at_once && array.given.form != SplitForm::slurm) {
    throw UsageError("--at-once needs --for slurm, whose tasks it limits");
  }
  if (!array.given.form) {
    if (array.clouds.size() == 1) return run(array.clouds.front());
    throw UsageError(fmt::format(
        "found {} clouds, expected one; use --for text, json or slurm to print a task for each",
        array.clouds.size()));
  }
  if (page)
    throw UsageError("--html and --for exclude each other: all clouds would write the same page");
  std::cout << print(array, verb);
  return kSuccess;
}

}  // namespace pvol::cli
