#include "cli/manual.h"

#include <fmt/format.h>
#include <CLI/CLI.hpp>
#include <algorithm>
#include <iterator>

#include "pvol/version.h"

namespace pvol::cli {
namespace {

// --- roff ---------------------------------------------------------------------------------------

/// Text as roff shows it: no escapes, hyphens that can be copied, no line that is a request.
std::string roff(const std::string& text) {
  std::string result;
  bool line_begins = true;
  for (const char c : text) {
    if (line_begins && (c == '.' || c == '\'')) result += "\\&";
    line_begins = c == '\n';
    if (c == '\\') {
      result += "\\e";
    } else if (c == '-') {
      result += "\\-";
    } else {
      result += c;
    }
  }
  return result;
}

/// The same as one argument of a request.
std::string roff_argument(const std::string& text) {
  std::string result;
  for (const char c : roff(text)) result += c == '"' ? std::string("\\(dq") : std::string(1, c);
  return '"' + result + '"';
}

std::string bold(const std::string& text) { return "\\fB" + roff(text) + "\\fR"; }
std::string italic(const std::string& text) { return "\\fI" + roff(text) + "\\fR"; }

std::vector<std::string> flags_of(const CLI::Option& option) {
  std::vector<std::string> flags;
  for (const std::string& s : option.get_snames()) flags.push_back("-" + s);
  for (const std::string& l : option.get_lnames()) flags.push_back("--" + l);
  return flags;
}

bool takes_value(const CLI::Option& option) { return option.get_items_expected_min() > 0; }

void add_term(std::string& page, const std::string& term, const std::string& text) {
  page += fmt::format(".TP\n{}\n{}\n", term, roff(text));
}

void add_options(std::string& page, CLI::App& app) {
  for (const CLI::Option* option : app.get_options()) {
    std::string term;
    for (const std::string& f : flags_of(*option)) term += (term.empty() ? "" : ", ") + bold(f);
    if (term.empty()) {
      term = italic(option->get_name());
    } else if (takes_value(*option)) {
      term += " " + italic(option->get_type_name());
    }
    add_term(page, term, option->get_description());
  }
}

std::string synopsis(CLI::App& app, const std::string& name) {
  std::string line = bold(name) + " [" + italic("OPTIONS") + "]";
  for (const CLI::Option* option : app.get_options()) {
    if (flags_of(*option).empty()) line += " " + italic(option->get_name());
  }
  return line + "\n";
}

/// What ends a help, line by line as it is there.
void add_footer(std::string& page, const CLI::App& app) {
  page += ".PP\n.nf\n" + roff(app.get_footer()) + "\n.fi\n";
}

// --- completion ---------------------------------------------------------------------------------

/// The words that an option takes, which its check has for a name (command_line.cpp).
std::string words_of(CLI::Option& option) {
  try {
    return option.get_validator(0)->get_name();
  } catch (const CLI::OptionNotFound&) {
    return "";
  }
}

bool takes_file(const CLI::Option& option) { return option.get_type_name() == "FILE"; }

/// The function's branches for what stands before the cursor, and the options that may follow.
std::string completion_of(CLI::App& app, const std::string& indent) {
  std::string branches;
  std::vector<std::string> all;
  for (CLI::Option* option : app.get_options()) {
    const std::vector<std::string> flags = flags_of(*option);
    std::copy(flags.begin(), flags.end(), std::back_inserter(all));
    if (flags.empty() || !takes_value(*option)) continue;
    const std::string line =
        takes_file(*option)
            ? "COMPREPLY=($(compgen -f -- \"$current\"))"
            : fmt::format("COMPREPLY=($(compgen -W \"{}\" -- \"$current\"))", words_of(*option));
    branches += fmt::format("{}  {}) {}; return;;\n", indent, fmt::join(flags, "|"), line);
  }
  return fmt::format(
      "{0}case $before in\n{1}{0}esac\n"
      "{0}if [[ $current == -* ]]; then\n"
      "{0}  COMPREPLY=($(compgen -W \"{2}\" -- \"$current\"))\n"
      "{0}  return\n"
      "{0}fi\n",
      indent, branches, fmt::join(all, " "));
}

}  // namespace

std::string man_page(CLI::App& app, const std::vector<ManualPart>& parts) {
  const std::string name = app.get_name();
  std::string page =
      fmt::format(".TH {} 1 \"\" {} {}\n.SH NAME\n{} \\- {}\n.SH SYNOPSIS\n", roff_argument(name),
                  roff_argument("pvol " PVOL_VERSION), roff_argument("pvol manual"), roff(name),
                  roff(app.get_description()));
  const auto verbs = app.get_subcommands([](CLI::App*) { return true; });
  if (verbs.empty()) page += synopsis(app, name);
  for (CLI::App* verb : verbs) {
    page += (verb == verbs.front() ? "" : ".br\n") + synopsis(*verb, name + " " + verb->get_name());
  }
  page += ".SH OPTIONS\n";
  add_options(page, app);
  for (CLI::App* verb : verbs) {
    page += fmt::format(".SH {}\n{}.\n", roff_argument(verb->get_name()),
                        roff(verb->get_description()));
    add_options(page, *verb);
    add_footer(page, *verb);
  }
  for (const ManualPart& part : parts) {
    page += fmt::format("{} {}\n", part.inner ? ".SS" : ".SH", roff_argument(part.title));
    if (!part.text.empty()) page += roff(part.text) + "\n";
    for (const auto& [term, text] : part.terms) add_term(page, bold(term), text);
  }
  page += ".SH NOTES\n";
  add_footer(page, app);
  return page;
}

std::string bash_completion(CLI::App& app) {
  const std::string name = app.get_name();
  std::string function = "_" + name;
  std::replace(function.begin(), function.end(), '-', '_');
  const auto verbs = app.get_subcommands([](CLI::App*) { return true; });
  std::vector<std::string> verb_names;
  std::string by_verb;
  for (CLI::App* verb : verbs) {
    verb_names.push_back(verb->get_name());
    by_verb +=
        fmt::format("    {})\n{}      ;;\n", verb->get_name(), completion_of(*verb, "      "));
  }
  if (!verbs.empty()) {
    by_verb = fmt::format(
        "  if ((COMP_CWORD == 1)) && [[ $current != -* ]]; then\n"
        "    COMPREPLY=($(compgen -W \"{}\" -- \"$current\"))\n"
        "    return\n"
        "  fi\n"
        "  case ${{COMP_WORDS[1]}} in\n{}  esac\n",
        fmt::join(verb_names, " "), by_verb);
  }
  return fmt::format(
      "# Completion of {0} for bash.\n"
      "{1}() {{\n"
      "  local current=${{COMP_WORDS[COMP_CWORD]}} before=${{COMP_WORDS[COMP_CWORD - 1]}}\n"
      "  COMPREPLY=()\n"
      "{2}{3}"
      "  COMPREPLY=($(compgen -f -- \"$current\"))\n"
      "}}\n"
      "complete -o filenames -F {1} {0}\n",
      name, function, by_verb, completion_of(app, "  "));
}

}  // namespace pvol::cli
