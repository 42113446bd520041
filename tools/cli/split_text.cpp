#include "cli/split_text.h"

#include <fmt/format.h>

#include "cli/json.h"
#include "cli/shell_words.h"

namespace pvol::cli {
namespace {

std::string text_of(const SplitStage& stage) {
  std::string text;
  for (const PartCommand& p : stage.parts) text += shell_line(p.command) + '\n';
  return text + shell_line(stage.merge) + '\n';
}

std::string text_of(const SplitPicture& picture) {
  std::string text =
      picture.frame ? fmt::format("\n# frame {}\n", *picture.frame) : std::string("\n");
  text += fmt::format("mkdir -p {}\n", shell_word(picture.folder.string()));
  if (picture.pilots) {
    text += "# pilots, which find where samples are needed\n" + text_of(*picture.pilots);
    text += "# the parts, with samples where they are needed\n";
  }
  return text + text_of(picture.parts);
}

Json json_of(const MergeCommand& merge, const std::string& output) {
  return {{"command", merge.command()}, {"output", output}};
}

Json json_of(const PartCommand& p) {
  const PixelRect& r = p.part.pixels;
  Json j = {{"command", p.command},
            {"output", p.output.string()},
            {"crop", {r.x, r.y, r.width, r.height}}};
  if (p.samples_told) j["samples"] = {p.part.first_sample, p.part.end_sample};
  j["share"] = p.part.share;
  return j;
}

Json json_of(const SplitStage& stage, const std::string& output) {
  Json parts = Json::array();
  for (const PartCommand& p : stage.parts) parts.push_back(json_of(p));
  return {{"parts", std::move(parts)}, {"merge", json_of(stage.merge, output)}};
}

Json json_of(const SplitPicture& picture) {
  Json j;
  if (picture.frame) j["frame"] = *picture.frame;
  j["folder"] = picture.folder.string();
  if (picture.pilots) {
    const std::string merged = *(picture.pilots->merge.after.begin() + 1);
    j["pilots"] = json_of(*picture.pilots, merged);
  }
  j.update(json_of(picture.parts, picture.output.string()));
  return j;
}

}  // namespace

std::string shell_line(const MergeCommand& merge) {
  return fmt::format("{} {}/{} {}", shell_line(merge.before), shell_word(merge.folder.string()),
                     merge.pattern, shell_line(merge.after));
}

std::string split_script(const SplitJob& job) {
  std::string text = fmt::format(
      "#!/bin/bash\n"
      "# {}.\n"
      "# Each line that renders may run anywhere, in this folder, at the same time as the others; "
      "a merge\n"
      "# needs those before it. A line that is run again continues its work.\n"
      "set -e\n",
      summary(job));
  for (const SplitPicture& picture : job.pictures) text += text_of(picture);
  return text;
}

std::string split_json(const SplitJob& job) {
  Json j;
  if (job.pictures.front().frame) {
    j["frames"] = Json::array();
    for (const SplitPicture& p : job.pictures) j["frames"].push_back(json_of(p));
  } else {
    j = json_of(job.pictures.front());
  }
  j["cpu_seconds"] = job.cpu_seconds;
  return to_text(j);
}

}  // namespace pvol::cli
