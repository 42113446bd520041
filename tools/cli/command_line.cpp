#include "cli/command_line.h"

#include <fmt/format.h>
#include <CLI/CLI.hpp>
#include <algorithm>
#include <filesystem>
#include <iostream>
#include <limits>
#include <sstream>

#include "cli/build_facts.h"
#include "cli/json.h"
#include "cli/root_folder.h"
#include "pvol/math/nearest_word.h"

namespace pvol::cli {
namespace {

constexpr std::size_t kColumn = 32;  // where descriptions begin in the help

bool is_among(const std::vector<std::string>& words, const std::string& text) {
  return std::find(words.begin(), words.end(), text) != words.end();
}

/// Takes effect while the line is parsed, before anything is loaded.
void add_memory_limit(CLI::App& app) {
  constexpr double kLeast = 1e8;  // what the tools and their libraries take themselves
  Option(app.add_option_function<std::string>(
             "--memory-limit", [](const std::string& text) { limit_memory(*parse_bytes(text)); },
             "Limit of the address space, in bytes or with k, M, G or T, e.g. 4G: fail with a "
             "message instead of using more"))
      .type_name("BYTES")
      .check({[](const std::string& text) -> std::string {
        const std::optional<double> bytes = parse_bytes(text);
        if (bytes && *bytes >= kLeast) return {};
        return fmt::format("found '{}', expected a size of 100M or more, such as 4G", text);
      }});
}

/// Likewise, and before the options that are added after it.
void add_root(CLI::App& app) {
  app.add_option_function<std::string>(
         "--root", [](const std::string& folder) { keep_below(folder); },
         "Read and write files below this folder only, whatever scenes and links name: for "
         "services that render what others send (Linux 5.13 or later)")
      ->type_name("DIR");
}

/// The options of a tool or of one of its verbs, as users write them.
std::vector<std::string> flags_of(const CLI::App& app) {
  std::vector<std::string> flags;
  for (const CLI::Option* option : app.get_options()) {
    for (const std::string& name : option->get_lnames()) flags.push_back("--" + name);
  }
  return flags;
}

/// 'unexpected argument --exposur; did you mean --exposure?'
std::string message_of_extras(const CLI::App& app) {
  const std::vector<std::string> extras = app.remaining(true);
  std::string message = extras.size() == 1 ? "unexpected argument" : "unexpected arguments";
  for (const std::string& extra : extras) message += ' ' + extra;
  const CLI::App* verb = &app;
  if (const auto verbs = app.get_subcommands(); !verbs.empty()) verb = verbs.front();
  const std::vector<std::string> flags = flags_of(*verb);
  const std::vector<std::string_view> words(flags.begin(), flags.end());
  for (const std::string& extra : extras) {
    if (!extra.starts_with("--")) continue;
    if (const auto nearest = nearest_word(extra.substr(0, extra.find('=')), words)) {
      return message + "; did you mean " + std::string(*nearest) + '?';
    }
  }
  return message;
}

/// Version, help and messages as all tools have them.
void add_common(CLI::App& app, const std::string& examples) {
  // So that scripts around a tool can be called with options that they set themselves.
  app.option_defaults()->multi_option_policy(CLI::MultiOptionPolicy::TakeLast);
  app.set_version_flag("--version", app.get_name() + " " + version_text(),
                       "Print version, commit and best kernel, and exit");
  app.set_help_flag("-h,--help", "Print this help and exit");
  add_memory_limit(app);
  add_root(app);
  app.get_formatter()->column_width(kColumn);
  app.footer(examples);
  app.failure_message([](const CLI::App* a, const CLI::Error& e) {
    while (a->get_parent() != nullptr) a = a->get_parent();
    const bool extras = dynamic_cast<const CLI::ExtrasError*>(&e) != nullptr;
    return a->get_name() + ": error: " + (extras ? message_of_extras(*a) : e.what()) +
           "\nRun with --help for the options.\n";
  });
}

/// Breaks the descriptions of all options into lines of 100 columns.
void wrap_descriptions(CLI::App& app) {
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
bool print_manual(CLI::App& app, int argc, char** argv, const std::vector<ManualPart>& parts) {
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

/// Refuses a first word that is no verb; CLI11 would only say that one is missing.
void require_verb(const CLI::App& app, int argc, char** argv) {
  std::vector<std::string> verbs;
  for (const CLI::App* verb : app.get_subcommands({})) verbs.push_back(verb->get_name());
  if (verbs.empty() || argc < 2 || argv[1][0] == '-' || is_among(verbs, argv[1])) return;
  throw UsageError(fmt::format("found '{}', expected {}", argv[1], alternatives(verbs)));
}

}  // namespace

Check fits(const Limits& limits) {
  const bool flag = limits.shape == Limits::Shape::flag;
  return {[limits](const std::string& text) -> std::string {
            const auto refusal = refuse(limits, parse_value(limits, text));
            if (!refusal) return {};
            return fmt::format("found '{}', expected {}", text, command_expected(limits, *refusal));
          },
          flag ? "on off" : fmt::format("{}", fmt::join(limits.all_words(), " "))};
}

Check one_of(const std::vector<std::string>& words) {
  return {[words](const std::string& text) -> std::string {
            if (is_among(words, text)) return {};
            return fmt::format("found '{}', expected {}", text, alternatives(words));
          },
          fmt::format("{}", fmt::join(words, " "))};
}

Check word_or_number(const std::vector<std::string>& words, std::uint32_t largest) {
  return {[words, largest](const std::string& text) -> std::string {
            std::uint32_t value = 0;
            if (is_among(words, text)) return {};
            if (CLI::detail::lexical_cast(text, value) && value <= largest) return {};
            return fmt::format("found '{}', expected {} or a whole number up to {}", text,
                               alternatives(words), largest);
          },
          fmt::format("{}", fmt::join(words, " "))};
}

Check number_from(double least, double most, const std::string& words) {
  return {[least, most, words](const std::string& text) -> std::string {
    double value = 0;
    if (CLI::detail::lexical_cast(text, value) && value >= least && value <= most) return {};
    return fmt::format("found '{}', expected {}", text, words);
  }};
}

Check above_zero() {
  constexpr double kLeast = std::numeric_limits<double>::min();
  return number_from(kLeast, std::numeric_limits<double>::max(), "a number above 0");
}

std::string alternatives(const std::vector<std::string>& words) {
  return fmt::format("{}", fmt::join(words, " or "));
}

const Option& Option::type_name(const std::string& name) const {
  option_->type_name(name);
  return *this;
}

const Option& Option::check(const Check& check) const {
  // Shell completion finds the words in the check's name (manual.cpp).
  option_->check(
      CLI::Validator([fault = check.fault](std::string& text) { return fault(text); }, "")
          .name(check.words));
  return *this;
}

const Option& Option::required() const {
  option_->required();
  return *this;
}

const Option& Option::values(int count) const {
  option_->type_size(count)->expected(1);
  return *this;
}

const Option& Option::separated_by(char character) const {
  option_->delimiter(character);
  return *this;
}

const Option& Option::repeatable() const {
  option_->expected(1)->take_all()->allow_extra_args(false);
  return *this;
}

const Option& Option::takes_all() const {
  option_->multi_option_policy(CLI::MultiOptionPolicy::TakeAll);
  return *this;
}

const Option& Option::excludes(const Option& other) const {
  option_->excludes(other.option_);
  return *this;
}

CommandLine::CommandLine(const std::string& description, const std::string& tool,
                         const std::string& examples)
    : owner_(std::make_shared<CLI::App>(description, tool)), app_(owner_.get()) {
  add_common(*app_, examples);
}

CommandLine::CommandLine(std::shared_ptr<CLI::App> owner, CLI::App* app,
                         const std::string& examples)
    : owner_(std::move(owner)), app_(app) {
  add_common(*app_, examples);
}

CommandLine CommandLine::add_verb(const std::string& name, const std::string& description,
                                  const std::string& examples,
                                  const std::function<void()>& chosen) const {
  app_->require_subcommand(1);
  CLI::App* const verb = app_->add_subcommand(name, description);
  verb->callback(chosen);
  return {owner_, verb, examples};
}

template <class T>
Option CommandLine::add_option(const std::string& flags, T& to, const std::string& help) const {
  return Option(app_->add_option(flags, to, help));
}

template Option CommandLine::add_option(const std::string&, int&, const std::string&) const;
template Option CommandLine::add_option(const std::string&, unsigned&, const std::string&) const;
template Option CommandLine::add_option(const std::string&, double&, const std::string&) const;
template Option CommandLine::add_option(const std::string&, std::string&, const std::string&) const;
template Option CommandLine::add_option(const std::string&, std::filesystem::path&,
                                        const std::string&) const;
template Option CommandLine::add_option(const std::string&, std::optional<int>&,
                                        const std::string&) const;
template Option CommandLine::add_option(const std::string&, std::optional<double>&,
                                        const std::string&) const;
template Option CommandLine::add_option(const std::string&, std::optional<std::string>&,
                                        const std::string&) const;
template Option CommandLine::add_option(const std::string&, std::optional<std::filesystem::path>&,
                                        const std::string&) const;
template Option CommandLine::add_option(const std::string&, std::vector<int>&,
                                        const std::string&) const;
template Option CommandLine::add_option(const std::string&, std::vector<std::string>&,
                                        const std::string&) const;
template Option CommandLine::add_option(const std::string&, std::vector<std::filesystem::path>&,
                                        const std::string&) const;

Option CommandLine::add_option_function(const std::string& flags,
                                        const std::function<void(const std::string&)>& take,
                                        const std::string& help) const {
  return Option(app_->add_option_function<std::string>(flags, take, help));
}

Option CommandLine::add_flag(const std::string& flags, bool& to, const std::string& help) const {
  return Option(app_->add_flag(flags, to, help));
}

Option CommandLine::add_flag_callback(const std::string& flags, const std::function<void()>& given,
                                      const std::string& help) const {
  return Option(app_->add_flag_callback(flags, given, help));
}

std::optional<int> CommandLine::parse(int argc, char** argv,
                                      const std::vector<ManualPart>& parts) const {
  require_verb(*app_, argc, argv);
  if (print_manual(*app_, argc, argv, parts)) return kSuccess;
  wrap_descriptions(*app_);
  try {
    app_->parse(argc, argv);
  } catch (const CLI::ParseError& e) {
    return app_->exit(e) == 0 ? kSuccess : kUsage;
  }
  return std::nullopt;
}

void add_quiet(const CommandLine& line, Common& common) {
  line.add_flag("--quiet", common.quiet,
                "Print no report and no progress, only warnings and errors");
}

}  // namespace pvol::cli
