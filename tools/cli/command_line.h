// The command line of a tool: its options, its verbs, its help and its man page. CLI11 is behind
// it, which takes seconds to compile and is included by the sources of this interface alone.
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "cli/cli.h"
#include "cli/manual.h"
#include "pvol/math/limits.h"

namespace CLI {
class App;
class Option;
}  // namespace CLI

namespace pvol::cli {

/// Which texts an option takes.
struct Check {
  /// "found 'x', expected a number above 0"; empty for a text that fits.
  std::function<std::string(const std::string& text)> fault;
  std::string words{};  ///< that fit, with blanks between them: what shells complete
};

/// What a row of a table accepts (pvol/math/limits.h).
[[nodiscard]] Check fits(const Limits& limits);
[[nodiscard]] Check one_of(const std::vector<std::string>& words);
/// One of the words, or a whole number from 0 to `largest`.
[[nodiscard]] Check word_or_number(const std::vector<std::string>& words, std::uint32_t largest);
/// A finite number from `least` to `most`, which messages call `words`.
[[nodiscard]] Check number_from(double least, double most, const std::string& words);
/// A finite number above 0.
[[nodiscard]] Check above_zero();

/// "a or b or c".
[[nodiscard]] std::string alternatives(const std::vector<std::string>& words);

/// An option that was added to a command line, which owns it.
class Option {
 public:
  explicit Option(CLI::Option* option) : option_(option) {}

  /// What stands for its value in the help: "N", "FILE"; "" for positions on the line.
  const Option& type_name(const std::string& name) const;
  const Option& check(const Check& check) const;
  const Option& required() const;
  /// So many values, each time.
  const Option& values(int count) const;
  /// Values have this character between them.
  const Option& separated_by(char character) const;
  /// May be given often, with one value each time; all are kept.
  const Option& repeatable() const;
  /// Takes any number of values, and keeps all.
  const Option& takes_all() const;
  const Option& excludes(const Option& other) const;

 private:
  CLI::Option* option_;
};

/// A tool's command line, or one of its verbs. All have --help, --version, --memory-limit and
/// --root. What options are read into must outlive it. Copies are the same command line.
class CommandLine {
 public:
  /// `examples` ends the help.
  CommandLine(const std::string& description, const std::string& tool, const std::string& examples);

  /// Adds a verb, one of which must then be given; parsing it calls `chosen`.
  [[nodiscard]] CommandLine add_verb(const std::string& name, const std::string& description,
                                     const std::string& examples,
                                     const std::function<void()>& chosen) const;

  /// `T` is a string, a path, a number, an optional of these or a vector of them, as far as
  /// command_line.cpp lists them.
  template <class T>
  Option add_option(const std::string& flags, T& to, const std::string& help) const;
  /// Calls `take` with the text where the option is given.
  Option add_option_function(const std::string& flags,
                             const std::function<void(const std::string& text)>& take,
                             const std::string& help) const;
  Option add_flag(const std::string& flags, bool& to, const std::string& help) const;
  Option add_flag_callback(const std::string& flags, const std::function<void()>& given,
                           const std::string& help) const;

  /// Nothing where the tool goes on, else its exit code: help, version and manual on stdout with
  /// success, misuse on stderr. `parts` are those of the man page besides the options. Throws
  /// UsageError for a first word that is no verb.
  [[nodiscard]] std::optional<int> parse(int argc, char** argv,
                                         const std::vector<ManualPart>& parts = {}) const;

 private:
  CommandLine(std::shared_ptr<CLI::App> owner, CLI::App* app, const std::string& examples);

  std::shared_ptr<CLI::App> owner_;  // of the tool's
  CLI::App* app_;                    // this one, the tool's or a verb's
};

/// `--quiet`, for tools that report on stdout or stderr.
void add_quiet(const CommandLine& line, Common& common);

}  // namespace pvol::cli
