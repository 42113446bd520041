// The command line itself, with CLI11: included once by each tool, for it takes seconds to compile.
#pragma once

#include <fmt/format.h>
#include <CLI/CLI.hpp>
#include <algorithm>
#include <iostream>
#include <limits>
#include <optional>
#include <sstream>
#include <string>
#include <vector>

#include "cli/cli.h"
#include "cli/json.h"
#include "cli/manual.h"
#include "pvol/math/limits.h"
#include "pvol/version.h"

namespace pvol::cli {

inline constexpr std::size_t kColumn = 32;  ///< where descriptions begin in the help

/// Takes effect while the line is parsed, before anything is loaded.
inline void add_memory_limit(CLI::App& app) {
  constexpr double kLeast = 1e8;  // what the tools and their libraries take themselves
  app.add_option_function<std::string>(
         "--memory-limit", [](const std::string& text) { limit_memory(*parse_bytes(text)); },
         "Fail with a message rather than take more address space than this, e.g. 4G")
      ->type_name("BYTES")
      ->check(CLI::Validator(
          [](const std::string& text) -> std::string {
            const std::optional<double> bytes = parse_bytes(text);
            if (bytes && *bytes >= kLeast) return {};
            return fmt::format("found '{}', expected a size of 100M or more, such as 4G", text);
          },
          ""));
}

/// Version, help and messages as all tools have them. `examples` ends the help.
inline void add_common(CLI::App& app, const std::string& examples) {
  // So that scripts around a tool can be called with options that they set themselves.
  app.option_defaults()->multi_option_policy(CLI::MultiOptionPolicy::TakeLast);
  app.set_version_flag("--version", std::string(PVOL_VERSION), "Print the version and exit");
  app.set_help_flag("-h,--help", "Print this help and exit");
  add_memory_limit(app);
  app.get_formatter()->column_width(kColumn);
  app.footer(examples);
  app.failure_message([](const CLI::App* a, const CLI::Error& e) {
    while (a->get_parent() != nullptr) a = a->get_parent();
    return a->get_name() + ": error: " + e.what() + "\nRun with --help for the options.\n";
  });
}

inline void add_quiet(CLI::App& app, Common& common) {
  app.add_flag("--quiet", common.quiet, "No report and no progress; warnings and errors stay");
}

/// "a or b or c".
[[nodiscard]] inline std::string alternatives(const std::vector<std::string>& words) {
  return fmt::format("{}", fmt::join(words, " or "));
}

// A check that takes words has them for a name, which shell completion shows (manual.h).

/// Accepts what a row of a table does (pvol/math/limits.h).
[[nodiscard]] inline CLI::Validator fits(const Limits& limits) {
  const bool flag = limits.shape == Limits::Shape::flag;
  return CLI::Validator(
             [limits](const std::string& text) -> std::string {
               const auto refusal = refuse(limits, parse_value(limits, text));
               if (!refusal) return {};
               return fmt::format("found '{}', expected {}", text,
                                  command_expected(limits, *refusal));
             },
             "")
      .name(flag ? "on off" : fmt::format("{}", fmt::join(limits.all_words(), " ")));
}

/// Accepts one of the words.
[[nodiscard]] inline CLI::Validator one_of(const std::vector<std::string>& words) {
  return CLI::Validator(
             [words](const std::string& text) -> std::string {
               if (std::find(words.begin(), words.end(), text) != words.end()) return {};
               return fmt::format("found '{}', expected {}", text, alternatives(words));
             },
             "")
      .name(fmt::format("{}", fmt::join(words, " ")));
}

/// Accepts one of the words, or a whole number from 0 to `largest`.
[[nodiscard]] inline CLI::Validator word_or_number(const std::vector<std::string>& words,
                                                   std::uint32_t largest) {
  return CLI::Validator(
             [words, largest](const std::string& text) -> std::string {
               std::uint32_t value = 0;
               if (std::find(words.begin(), words.end(), text) != words.end()) return {};
               if (CLI::detail::lexical_cast(text, value) && value <= largest) return {};
               return fmt::format("found '{}', expected {} or a whole number up to {}", text,
                                  alternatives(words), largest);
             },
             "")
      .name(fmt::format("{}", fmt::join(words, " ")));
}

/// Accepts a finite number from `least` to `most`, as the words say.
[[nodiscard]] inline CLI::Validator number_from(double least, double most,
                                                const std::string& words) {
  return CLI::Validator(
      [least, most, words](const std::string& text) -> std::string {
        double value = 0;
        if (CLI::detail::lexical_cast(text, value) && value >= least && value <= most) return {};
        return fmt::format("found '{}', expected {}", text, words);
      },
      "");
}

/// Accepts a finite number above 0.
[[nodiscard]] inline CLI::Validator above_zero() {
  constexpr double kLeast = std::numeric_limits<double>::min();
  return number_from(kLeast, std::numeric_limits<double>::max(), "a number above 0");
}

/// Breaks the descriptions of all options into lines of 100 columns.
inline void wrap_descriptions(CLI::App& app) {
  constexpr std::size_t kWidth = 100 - kColumn;
  for (CLI::Option* option : app.get_options()) {
    std::istringstream words(option->get_description());
    std::string text, line, word;
    while (words >> word) {
      if (!line.empty() && line.size() + 1 + word.size() > kWidth) {
        text += line + '\n';  // CLI11 indents what follows
        line.clear();
      }
      line += (line.empty() ? "" : " ") + word;
    }
    option->description(text + line);
  }
  for (CLI::App* verb : app.get_subcommands({})) wrap_descriptions(*verb);
}

/// `--man` alone prints the man page and `--completion bash` a script; neither is in the help, for
/// they are there for the build. Whether one of them was given.
[[nodiscard]] inline bool print_manual(CLI::App& app, int argc, char** argv,
                                       const std::vector<ManualPart>& parts) {
  const std::vector<std::string> given(argv + 1, argv + argc);
  if (given == std::vector<std::string>{"--man"}) {
    std::cout << man_page(app, parts);
    return true;
  }
  if (given == std::vector<std::string>{"--completion", "bash"}) {
    std::cout << bash_completion(app);
    return true;
  }
  return false;
}

/// Nothing where the tool goes on, else its exit code: help, version and manual on stdout with
/// success, misuse on stderr. `parts` are those of the man page besides the options.
[[nodiscard]] inline std::optional<int> parse(CLI::App& app, int argc, char** argv,
                                              const std::vector<ManualPart>& parts = {}) {
  if (print_manual(app, argc, argv, parts)) return kSuccess;
  wrap_descriptions(app);
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& e) {
    return app.exit(e) == 0 ? kSuccess : kUsage;
  }
  return std::nullopt;
}

}  // namespace pvol::cli
