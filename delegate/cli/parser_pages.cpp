// The man page and the completion scripts of shells, made from the parser of the command line.
#include <CLI/CLI.hpp>
#include <algorithm>
#include <cctype>
#include <cstdio>

#include "delegate/api/render_delegate.h"
#include "delegate/cli/commands.h"
#include "delegate/cli/console.h"
#include "delegate/cli/exit_codes.h"

namespace alabaster::cli {
namespace {

struct Flag {
  std::vector<std::string> names;  // with their dashes, long ones first
  std::string type, help;          // no type: it takes no value
  bool is_positional = false;
};

std::vector<const CLI::App*> listed_commands(const CLI::App& app) {
  return app.get_subcommands([](const CLI::App* c) { return !c->get_name().empty() && !c->get_group().empty(); });
}

std::vector<Flag> flags_of(const CLI::App& command) {
  std::vector<Flag> flags;
  for (const CLI::Option* option : command.get_options()) {
    if (option->get_group().empty()) continue;  // not listed
    Flag flag{{}, option->get_items_expected_max() == 0 ? "" : option->get_type_name(), option->get_description()};
    flag.is_positional = option->get_positional();
    for (const std::string& name : option->get_lnames()) flag.names.push_back("--" + name);
    for (const std::string& name : option->get_snames()) flag.names.push_back("-" + name);
    flags.push_back(std::move(flag));
  }
  return flags;
}

/// Those of the commands below a command, too: shells complete them all after its name.
std::vector<Flag> completed_flags(const CLI::App& command) {
  std::vector<Flag> all = flags_of(command);
  for (const CLI::App* below : listed_commands(command))
    for (Flag& flag : flags_of(*below)) {
      const bool is_new =
          std::none_of(all.begin(), all.end(), [&](const Flag& one) { return one.names == flag.names; });
      if (is_new && !flag.is_positional) all.push_back(std::move(flag));
    }
  return all;
}

/// "farm status" of a command below another.
std::string whole_name(const CLI::App& command) {
  const CLI::App* above = command.get_parent();
  return above && above->get_parent() ? whole_name(*above) + " " + command.get_name() : command.get_name();
}

bool names_files(const Flag& flag) {
  for (const char* const word : {"FILE", "DIR", "FOLDER", "SCENE", "PART"})
    if (flag.type.starts_with(word)) return true;
  return false;
}

/// `text` with a `mark` before each character that `special` holds.
std::string marked(const std::string& text, const std::string& special, const std::string& mark) {
  std::string out;
  for (const char c : text) {
    if (special.find(c) != std::string::npos) out += mark;
    out += c;
  }
  return out;
}

/// The text up to its first sentence's end, for a line of a menu.
std::string first_sentence(const std::string& text) {
  return text.substr(0, std::min(text.find(". "), text.find(": ")));
}

// roff: a backslash is written \e, and a minus that is typed is \-. No line may begin with a control character.
std::string roff(const std::string& text) {
  std::string out;
  for (const char c : text) {
    if (c == '\\')
      out += "\\e";
    else if (c == '-')
      out += "\\-";
    else if ((c == '.' || c == '\'') && (out.empty() || out.back() == '\n'))
      out += std::string("\\&") + c;
    else
      out += c;
  }
  return out;
}

void add_flags(const CLI::App& command, std::string* page) {
  for (const Flag& flag : flags_of(command)) {
    if (flag.is_positional) {
      *page += ".TP\n\\fI" + roff(flag.type) + "\\fR\n" + roff(flag.help) + ".\n";
      continue;
    }
    std::vector<std::string> names;
    for (const std::string& name : flag.names) names.push_back("\\fB" + roff(name) + "\\fR");
    const std::string value = flag.type.empty() ? "" : " \\fI" + roff(flag.type) + "\\fR";
    *page += ".TP\n" + joined(names) + value + "\n" + roff(flag.help) + ".\n";
  }
}

std::string synopsis(const CLI::App& command) {
  std::string text = ".B alabaster " + whole_name(command) + "\n";
  for (const Flag& flag : flags_of(command))
    if (flag.is_positional) text += "\\fI" + roff(flag.type) + "\\fR\n";
  return text + "[\\fIoptions\\fR]\n";
}

std::string bash_script(const CLI::App& app) {
  std::string commands, cases;
  for (const CLI::App* command : listed_commands(app)) {
    std::vector<std::string> flags, files, values;
    for (const Flag& flag : completed_flags(*command)) {
      if (flag.is_positional) continue;
      flags.insert(flags.end(), flag.names.begin(), flag.names.end());
      auto& takers = names_files(flag) ? files : values;
      if (!flag.type.empty()) takers.insert(takers.end(), flag.names.begin(), flag.names.end());
    }
    commands += command->get_name() + " ";
    cases += "    " + command->get_name() + ")\n      flags=\"" + joined(flags, " ") + "\"\n      files=\"" +
             joined(files, " ") + "\"\n      values=\"" + joined(values, " ") + "\" ;;\n";
  }
  return "# Completion of bash for alabaster, made by `alabaster completion bash`.\n_alabaster() {\n"
         "  local word=${COMP_WORDS[COMP_CWORD]} before=${COMP_WORDS[COMP_CWORD-1]} command= flags files values i\n"
         "  if [[ $word == = ]]; then word=; elif [[ $before == = ]]; then before=${COMP_WORDS[COMP_CWORD-2]}; fi\n"
         "  for ((i = 1; i < COMP_CWORD; ++i)); do\n"
         "    if [[ ${COMP_WORDS[i]} != -* ]]; then command=${COMP_WORDS[i]}; break; fi\n"
         "  done\n  COMPREPLY=()\n  case $command in\n    \"\") flags=\"" +
         commands + "--help --version\"; word=${word:-} ;;\n" + cases +
         "  esac\n"
         "  if [[ -z $command ]]; then COMPREPLY=($(compgen -W \"$flags\" -- \"$word\")); return; fi\n"
         "  if [[ \" $values \" == *\" $before \"* ]]; then return; fi\n"
         "  if [[ \" $files \" != *\" $before \"* && $word == -* ]]; then\n"
         "    COMPREPLY=($(compgen -W \"$flags\" -- \"$word\"))\n    return\n  fi\n"
         "  local IFS=$'\\n'\n  compopt -o filenames 2>/dev/null\n  COMPREPLY=($(compgen -f -- \"$word\"))\n}\n"
         "complete -F _alabaster alabaster\n";
}

std::string zsh_script(const CLI::App& app) {
  const auto quoted = [](const std::string& text) { return marked(text, "[]:\\", "\\"); };
  const auto whole = [](const std::string& text) {
    std::string out;
    for (const char c : text) out += c == '\'' ? std::string("'\\''") : std::string(1, c);
    return "'" + out + "'";
  };
  std::string commands, cases;
  for (const CLI::App* command : listed_commands(app)) {
    commands += "    " + whole(quoted(command->get_name()) + ":" + first_sentence(command->get_description())) + "\n";
    cases += "    " + command->get_name() + ")\n      _arguments";
    for (const Flag& flag : completed_flags(*command)) {
      const std::string action = names_files(flag) ? "_files" : " ";
      if (flag.is_positional) cases += " \\\n        " + whole("*:" + quoted(flag.type) + ":" + action);
      for (const std::string& name : flag.names)
        cases += " \\\n        " + whole("*" + name + "[" + quoted(first_sentence(flag.help)) + "]" +
                                         (flag.type.empty() ? "" : ":" + quoted(flag.type) + ":" + action));
    }
    cases += " ;;\n";
  }
  return "#compdef alabaster\n# Completion of zsh, made by `alabaster completion zsh`.\n_alabaster() {\n"
         "  local -a commands\n  commands=(\n" +
         commands +
         "  )\n  if (( CURRENT == 2 )); then\n    _describe command commands\n    return\n  fi\n"
         "  local command=$words[2]\n  shift words\n  (( CURRENT-- ))\n  case $command in\n" +
         cases + "  esac\n}\n_alabaster \"$@\"\n";
}

std::string fish_script(const CLI::App& app) {
  const auto quoted = [](const std::string& text) { return "'" + marked(text, "'\\", "\\") + "'"; };
  std::string text =
      "# Completion of fish for alabaster, made by `alabaster completion fish`.\n"
      "complete -c alabaster -n __fish_use_subcommand -f\n";
  for (const CLI::App* command : listed_commands(app)) {
    const std::string name = command->get_name();
    text += "complete -c alabaster -n __fish_use_subcommand -f -a " + name + " -d " +
            quoted(first_sentence(command->get_description())) + "\n";
    for (const Flag& flag : completed_flags(*command)) {
      if (flag.is_positional) continue;
      text += "complete -c alabaster -n '__fish_seen_subcommand_from " + name + "'";
      for (const std::string& one : flag.names)
        text += one.starts_with("--") ? " -l " + one.substr(2) : " -s " + one.substr(1);
      text += flag.type.empty() ? "" : names_files(flag) ? " -r" : " -x";
      text += " -d " + quoted(first_sentence(flag.help)) + "\n";
    }
  }
  return text;
}

}  // namespace

int run_man(const CLI::App& app) {
  const std::string versions = AlabasterVersions();
  const std::string version = versions.substr(0, versions.find('\n'));
  std::string page =
      ".\\\" Made by `alabaster man`, from the parser of the command line.\n.TH ALABASTER 1 \"\" \"Alabaster " +
      version + "\" \"User Commands\"\n.SH NAME\nalabaster \\- path tracer for translucent materials\n.SH SYNOPSIS\n";
  std::vector<const CLI::App*> commands;
  for (const CLI::App* command : listed_commands(app)) {
    commands.push_back(command);
    for (const CLI::App* below : listed_commands(*command)) commands.push_back(below);
  }
  for (size_t i = 0; i < commands.size(); ++i) page += (i == 0 ? "" : ".br\n") + synopsis(*commands[i]);
  page += ".SH DESCRIPTION\n" + roff(app.get_description()) + "\n.SH OPTIONS\n";
  add_flags(app, &page);
  for (const CLI::App* command : commands) {
    std::string title = whole_name(*command);
    std::transform(title.begin(), title.end(), title.begin(), [](char c) { return char(std::toupper(c)); });
    page += ".SH " + title + "\n" + roff(command->get_description()) + "\n";
    add_flags(*command, &page);
  }
  page += ".SH EXIT STATUS\n" + roff(app.get_footer()) +
          "\n.SH SEE ALSO\nThe manual, which begins with /usr/share/doc/hdalabaster/README.md in Debian's package.\n";
  std::fputs(page.c_str(), stdout);
  return kDone;
}

int run_completion(const CLI::App& app, const std::string& shell) {
  std::string script;
  if (shell == "bash")
    script = bash_script(app);
  else if (shell == "zsh")
    script = zsh_script(app);
  else if (shell == "fish")
    script = fish_script(app);
  else
    Console(false).usage_error("completion", "'" + shell + "' has no script: write bash, zsh or fish.");
  std::fputs(script.c_str(), stdout);
  return kDone;
}

}  // namespace alabaster::cli
