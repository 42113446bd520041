// Man pages and completion as the build makes them.
#include <gtest/gtest.h>

#include <algorithm>
#include <set>
#include <sstream>

#include "pvol/formats/scene_file.h"
#include "support/run_tool.h"

namespace pvol {
namespace manual_test {

using testing::read_text;
using testing::run_tool;

struct Tool {
  const char* name;
  const char* path;
};
const Tool kTools[] = {{"pvol-fit", PVOL_FIT},
                       {"pvol-render", PVOL_RENDER},
                       {"pvol-stats", PVOL_STATS},
#ifdef PVOL_VIEW
                       {"pvol-view", PVOL_VIEW},
#endif
                       {"pvol-convert", PVOL_CONVERT}};

std::string page_of(const Tool& tool) {
  return std::string(PVOL_SHARE) + "/man/man1/" + tool.name + ".1";
}
std::string script_of(const Tool& tool) {
  return std::string(PVOL_SHARE) + "/bash-completion/completions/" + tool.name;
}

/// The page as it is read: without the escapes of roff.
std::string plain_page(const Tool& tool) {
  const std::string page = read_text(page_of(tool));
  std::string text;
  for (std::size_t i = 0; i < page.size(); ++i) {
    if (page.compare(i, 2, "\\f") == 0) {
      i += 2;
    } else if (page.compare(i, 2, "\\&") == 0 || page.compare(i, 2, "\\-") == 0) {
      if (page[++i] == '-') text += '-';
    } else if (page.compare(i, 4, "\\(dq") == 0) {
      text += '"';
      i += 3;
    } else {
      text += page[i];
    }
  }
  return text;
}

/// What the tool's help and that of its verbs say before the two blanks of a description.
std::set<std::string> options_in_help(const Tool& tool) {
  std::set<std::string> options;
  std::vector<std::vector<std::string>> helps{{"--help"}};
  if (std::string(tool.name) == "pvol-stats") {
    for (const char* verb : {"bounds", "shells", "image", "depth", "trade"}) {
      helps.push_back({verb, "--help"});
    }
  }
  for (const auto& arguments : helps) {
    std::istringstream lines(run_tool(tool.path, arguments).out);
    for (std::string line; std::getline(lines, line);) {
      if (line.rfind("  -", 0) != 0) continue;
      const std::size_t begin = line.find("--");
      if (begin == std::string::npos) continue;
      options.insert(line.substr(begin, line.find_first_of(" ,", begin) - begin));
    }
  }
  return options;
}

TEST(Manual, MentionsEveryOption) {
  for (const Tool& tool : kTools) {
    const std::string page = plain_page(tool), script = read_text(script_of(tool));
    const std::set<std::string> options = options_in_help(tool);
    EXPECT_GT(options.size(), 5u) << tool.name;
    for (const std::string& option : options) {
      EXPECT_NE(page.find(option), std::string::npos) << tool.name << ' ' << option;
      EXPECT_NE(script.find(option), std::string::npos) << tool.name << ' ' << option;
    }
  }
}

TEST(Manual, HasEveryKeyOfAScene) {
  const std::string page = plain_page(kTools[1]);
  const std::size_t begin = page.find(".SH \"SCENE FILE\"");
  ASSERT_NE(begin, std::string::npos);
  std::set<std::string> keys;
  for (const formats::SectionManual& section : formats::describe_sections()) {
    std::string heading = section.heading;
    const std::size_t at = page.find(".SS \"" + heading + "\"", begin);
    ASSERT_NE(at, std::string::npos) << heading;
    for (const auto& line : section.lines) {
      keys.insert(line.key);
      EXPECT_NE(page.find("\n" + line.key + "\n" + line.help + ". Value: ", at), std::string::npos)
          << heading << ' ' << line.key;
    }
  }
  // One of each table.
  for (const char* key : {"file", "grid", "fov", "extinction", "share", "albedo", "g", "emission",
                          "rotate", "matrix", "radiance", "zenith", "rotation", "irradiance",
                          "max_bounces", "density", "density_tolerance", "preview"}) {
    EXPECT_TRUE(keys.count(key)) << key;
  }
  EXPECT_FALSE(keys.count("threads")) << "is no part of a scene";
}

TEST(Manual, IsRoffWithoutErrors) {
  const std::string groff = PVOL_GROFF;
  if (groff.empty()) GTEST_SKIP() << "groff is not installed";
  for (const Tool& tool : kTools) {
    const auto r = run_tool(groff, {"-man", "-Tascii", "-ww", "-z", page_of(tool)});
    EXPECT_EQ(r.exit, 0) << r.err;
    EXPECT_EQ(r.err, "");
  }
}

/// What the script offers for a line of words whose last one is to be completed.
std::set<std::string> completed(const Tool& tool, const std::string& words) {
  std::string function = std::string("_") + tool.name;
  std::replace(function.begin(), function.end(), '-', '_');
  std::string command = "source '";
  command.append(script_of(tool)).append("'; COMP_WORDS=(").append(words).append(")");
  command.append("; COMP_CWORD=$((${#COMP_WORDS[@]} - 1)); ").append(function);
  command.append("; printf '%s\\n' \"${COMPREPLY[@]}\"");
  const auto r = run_tool("/bin/bash", {"-c", command});
  EXPECT_EQ(r.err, "");
  std::istringstream lines(r.out);
  std::set<std::string> found;
  for (std::string line; std::getline(lines, line);) found.insert(line);
  return found;
}

TEST(Completion, OffersOptionsAndTheirWords) {
  using Words = std::set<std::string>;
  const Tool &render = kTools[1], &stats = kTools[2];
  EXPECT_EQ(completed(render, "pvol-render --tra"), (Words{"--tracker", "--transmittance"}));
  EXPECT_EQ(completed(render, "pvol-render --tracker weighted"),
            (Words{"weighted-delta", "weighted-decomposition"}));
  EXPECT_EQ(completed(render, "pvol-render --background o"), (Words{"on", "off"}));
  EXPECT_EQ(completed(render, "pvol-render --depth a"), Words{"auto"});
  EXPECT_EQ(completed(stats, "pvol-stats b"), Words{"bounds"});
  EXPECT_EQ(completed(stats, "pvol-stats trade --max-"), (Words{"--max-error", "--max-time"}));
}

}  // namespace manual_test
}  // namespace pvol
