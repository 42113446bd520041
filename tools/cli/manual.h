// Man pages and shell completion, made from a tool's own command line.
#pragma once

#include <string>
#include <utility>
#include <vector>

namespace CLI {
class App;
}

namespace pvol::cli {

/// A part of a man page after the options.
struct ManualPart {
  std::string title;   ///< "SCENE FILE", or of a part within "[camera]"
  bool inner = false;  ///< within the part before
  std::string text;    ///< a sentence or two; may be empty
  std::vector<std::pair<std::string, std::string>> terms;  ///< each with what it means
};

/// The page in roff (man 7): name, synopsis, options or those of each verb, `parts`, and what the
/// help says at its end.
[[nodiscard]] std::string man_page(CLI::App& app, const std::vector<ManualPart>& parts);

/// A script for bash that completes verbs, options, their words and file names.
[[nodiscard]] std::string bash_completion(CLI::App& app);

}  // namespace pvol::cli
