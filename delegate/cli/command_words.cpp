#include "delegate/cli/command_words.h"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <filesystem>
#include <map>
#include <set>
#include <utility>

#include "delegate/cli/shell_word.h"
#include "delegate/description/render_description.h"
#include "delegate/host/product_writer.h"
#include "delegate/support/extension.h"
#include "delegate/support/nearest_name.h"

namespace alabaster::cli {
namespace {

struct Example {
  const char *command, *line, *meaning;
};
// The first five are those of a program without arguments.
constexpr Example kExamples[] = {
    {"render", "alabaster render model.glb -o frame.png --quality preview", "a first picture"},
    {"render", "alabaster render model.glb -o frame.png --set 'materials/*.roughness=0.3'", "with a material changed"},
    {"info", "alabaster info model.glb", "its materials and meshes, and how to change them"},
    {"view", "alabaster view model.glb", "a window: look around, edit, save"},
    {"check", "alabaster check scene.json", "every fault that a render would report"},
    {"farm", "alabaster farm scene.json -o frame.exr --spp 256 --tasks 8", ""},
    {"farm status", "alabaster farm status scene_farm", ""},
    {"merge", "alabaster merge scene_farm/*.checkpoint -o frame.exr", ""},
    {"convert", "alabaster convert scene.json -o scene.alab", ""},
    {"tradeoff", "alabaster tradeoff scene.json --budget 10", ""},
    {"schema", "alabaster schema disney_material", ""}};
constexpr size_t kShownExamples = 5;

template <size_t N>
const Alias* find_alias(const Alias (&aliases)[N], const std::string& word) {
  const auto found = std::find_if(aliases, aliases + N, [&](const Alias& one) { return word == one.word; });
  return found == aliases + N ? nullptr : found;
}

std::string with_example(const std::string& text, const std::string& command) {
  return command.empty() ? text : text + "\n  " + command;
}

std::string example_of(const std::string& command) {
  for (const Example& example : kExamples)
    if (command == example.command) return example.line;
  return {};
}

std::string option_of(const std::string& word) {
  return word.substr(0, word.find('='));
}

bool is_option(const std::string& word) {
  return word.size() > 1 && word[0] == '-' && word.find_first_not_of("0123456789.-") != std::string::npos;
}

std::vector<const CLI::App*> commands_of(const CLI::App& app) {
  return app.get_subcommands([](const CLI::App*) { return true; });
}

const CLI::App* find_command(const CLI::App& app, const std::string& name) {
  for (const CLI::App* command : commands_of(app))
    if (command->get_name() == name) return command;
  return nullptr;
}

// The extensions of LoadScene.
bool is_scene(const std::string& word) {
  const std::set<std::string> extensions{".glb", ".gltf", ".json", ".alab"};
  return extensions.contains(hd::support::lower_extension(word));
}

/// The option of a word, which may hold its value: --spp=4, -oframe.png. Null: the command has none of that name.
const CLI::Option* known_option(const CLI::App& command, const std::string& word, bool* holds_value) {
  const CLI::Option* option = command.get_option_no_throw(option_of(word));
  *holds_value = word.find('=') != std::string::npos;
  if (option || word.starts_with("--")) return option;
  *holds_value = true;
  return command.get_option_no_throw(word.substr(0, 2));
}

/// The settings that --set takes, by name.
const std::map<std::string, hd::host::FieldRow>& known_settings() {
  static const std::map<std::string, hd::host::FieldRow> kSettings = [] {
    std::map<std::string, hd::host::FieldRow> all;
    for (const hd::host::FieldRow& row : hd::description::DescriptionKeys("settings")) all[row.name] = row;
    return all;
  }();
  return kSettings;
}

/// "glossy-filter" of glossyFilter.
std::string flag_name(const std::string& setting) {
  std::string name;
  for (const char c : setting) {
    const bool is_upper = c >= 'A' && c <= 'Z';
    if (is_upper) name += '-';
    name += is_upper ? static_cast<char>(c - 'A' + 'a') : c;
  }
  return name;
}

/// The option that a wrong one means: --set and a setting, where that has no option of its own. Empty: none is near.
struct MeantOption {
  std::string option, setting;

  std::string text() const { return setting.empty() ? option : option + " " + setting + "=VALUE"; }
  bool is_switch() const { return !setting.empty() && known_settings().at(setting).type.type == ALABASTER_BOOL; }
};

/// An alias, else the shortest name that begins as the word does, else the nearest name. Names are those of options and
/// of settings.
MeantOption meant_option(const CLI::App& command, const std::string& wrong) {
  constexpr size_t kLeastLetters = 3;
  const std::string word = wrong.substr(std::min(wrong.find_first_not_of('-'), wrong.size()));
  if (const Alias* alias = find_alias(kFlagAliases, word); alias && command.get_option_no_throw(alias->ours))
    return {alias->ours, ""};
  Words names;
  for (const CLI::Option* option : command.get_options())
    names.insert(names.end(), option->get_lnames().begin(), option->get_lnames().end());
  std::map<std::string, std::string> settings;
  if (command.get_option_no_throw("--set"))
    for (const auto& [setting, row] : known_settings())
      if (const std::string name = flag_name(setting); !command.get_option_no_throw("--" + name))
        names.push_back(name), settings[name] = setting;
  std::string longer;
  for (const std::string& name : names)
    if (word.size() >= kLeastLetters && name.starts_with(word) && (longer.empty() || name.size() < longer.size()))
      longer = name;
  const std::string name = longer.empty() ? hd::support::NearestName(word, names) : longer;
  if (name.empty()) return {};
  if (const auto setting = settings.find(name); setting != settings.end()) return {"--set", setting->second};
  return {"--" + name, ""};
}

/// A command line with right options in the place of wrong ones.
struct Corrected {
  Words words;
  std::string wrong, right;  // the first wrong option, and the right one; empty: none
  bool complete = true;      // each wrong option has a right one
};

class Corrector {
 public:
  Corrector(const CLI::App& command, const Words& words) : command_(command), words_(words) {
    result_.words = {words[0]};
    for (at_ = 1; at_ < words.size() && words[at_] != "--"; ++at_) take();
    result_.words.insert(result_.words.end(), words.begin() + std::ptrdiff_t(at_), words.end());
  }
  const Corrected& result() const { return result_; }

 private:
  void take() {
    const std::string& word = words_[at_];
    if (!is_option(word)) return result_.words.push_back(word);
    bool holds_value = false;
    const CLI::Option* option = known_option(command_, word, &holds_value);
    if (!option) return replace(word);
    used_.insert(option_name(*option));
    result_.words.push_back(word);
    if (!holds_value && option->get_expected_max() > 0 && at_ + 1 < words_.size())
      result_.words.push_back(words_[++at_]);
  }

  void replace(const std::string& word) {
    const std::string wrong = option_of(word);
    const MeantOption right = meant_option(command_, wrong);
    if (result_.wrong.empty()) result_.wrong = wrong, result_.right = right.text();
    if (right.option.empty()) result_.complete = false;
    if (right.option.empty()) return;
    const bool takes_value = command_.get_option_no_throw(right.option)->get_expected_max() > 0;
    std::string value = wrong == word ? "" : word.substr(wrong.size() + 1);
    if (takes_value && wrong == word && next_is_value(right)) value = words_[++at_];
    if (right.is_switch() && value.empty()) value = "true";
    if (takes_value && value.empty()) result_.complete = false;
    if (!used_.insert(right.text()).second) return;  // --width and --height are one --size
    const Alias* alias = find_alias(kFlagAliases, wrong.substr(std::min(wrong.find_first_not_of('-'), wrong.size())));
    if (alias && alias->value && value.find_first_not_of("0123456789") == std::string::npos) {
      const std::string number = std::exchange(value, alias->value);
      for (size_t at = 0; (at = value.find('%')) != std::string::npos;) value.replace(at, 1, number);
    }
    result_.words.push_back(right.option);
    if (takes_value) result_.words.push_back(right.setting.empty() ? value : right.setting + "=" + value);
  }

  bool next_is_value(const MeantOption& option) const {
    if (at_ + 1 >= words_.size()) return false;
    const std::string& next = words_[at_ + 1];
    return option.is_switch() ? next == "true" || next == "false" : !is_option(next);
  }

  const CLI::App& command_;
  const Words& words_;
  size_t at_ = 0;
  std::set<std::string> used_;
  Corrected result_;
};

// "" if the options of the command are all its own.
std::string option_fault(const CLI::App& command, const Words& words) {
  const Corrected corrected = Corrector(command, words).result();
  if (corrected.wrong.empty()) return {};
  std::string text = "'alabaster " + words[0] + "' has no option '" + corrected.wrong + "'.";
  if (!corrected.right.empty()) text += " Did you mean '" + corrected.right + "'?";
  if (corrected.complete) return with_example(text, command_text(corrected.words));
  return text + " Its options: alabaster " + words[0] + " --help";
}

/// The words that render a scene file: with an output, if they name none, and with right options.
std::string render_command(const CLI::App& app, const std::string& scene, const Words& others) {
  Words words{"render", scene};
  words.insert(words.end(), others.begin(), others.end());
  const bool writes = std::any_of(words.begin(), words.end(), [](const std::string& word) {
    return word.starts_with("-o") || word.starts_with("--out");
  });
  if (!writes) words.insert(words.end(), {"-o", std::filesystem::path(scene).stem().string() + ".png"});
  const Corrected corrected = Corrector(*find_command(app, "render"), words).result();
  return corrected.complete ? command_text(corrected.words) : example_of("render");
}

Words without(const Words& words, size_t at) {
  Words rest = words;
  rest.erase(rest.begin() + std::ptrdiff_t(at));
  return rest;
}

std::string help_command(const CLI::App& app, const Words& words) {
  return words.size() > 1 && find_command(app, words[1]) ? command_text({words[1], "--help"}) : "alabaster --help";
}

// The first word is no command.
std::string unknown_command(const CLI::App& app, const Words& words) {
  const std::string& word = words[0];
  Words names;
  for (const CLI::App* command : commands_of(app)) names.push_back(command->get_name());
  if (is_scene(word))
    return with_example("'" + word + "' is a scene, and a command comes before it. To render it:",
                        render_command(app, word, without(words, 0)));
  if (word == "help") return with_example("There is no command 'help'. To get help:", help_command(app, words));
  const Alias* alias = find_alias(kCommandAliases, word);
  const std::string right = alias ? alias->ours : hd::support::NearestName(word, names);
  if (right.empty()) {
    std::error_code error;
    const bool is_file = std::filesystem::exists(word, error);
    return with_example("'" + word + "' is " +
                            (is_file ? "a file, but no scene (.glb, .gltf, .json or .alab)" : "not a command") +
                            ". The commands are " + joined(names) + ". For example:",
                        example_of("render"));
  }
  Words corrected = words;
  corrected[0] = right;
  const CLI::App* command = find_command(app, right);
  if (command && right != "view") corrected = Corrector(*command, corrected).result().words;
  const bool is_alone = words.size() == 1;  // it lacks its scene
  return with_example("There is no command '" + word + "'. Did you mean '" + right + "'?",
                      is_alone ? example_of(right) : command_text(corrected));
}

// An option stands where a command does.
std::string early_option_fault(const CLI::App& app, const Words& words) {
  for (size_t i = 1; i < words.size(); ++i) {
    if (find_command(app, words[i])) {
      Words moved = without(words, i);
      moved.insert(moved.begin(), words[i]);
      const Corrected corrected = Corrector(*find_command(app, words[i]), moved).result();
      return with_example("'" + option_of(words[0]) + "' stands before the command. Write:",
                          corrected.complete ? command_text(corrected.words) : example_of(words[i]));
    }
    if (is_scene(words[i]))
      return with_example("The command is missing. To render '" + words[i] + "':",
                          render_command(app, words[i], without(words, i)));
  }
  return with_example("'" + option_of(words[0]) + "' is an option without a command. For example:",
                      example_of("render"));
}

std::vector<std::string> choices_of(const std::string& option) {
  if (option == "--engine") return farm_engines();
  if (option == "--aov") return hd::host::ProductAovs();
  const auto setting = known_settings().find(option.substr(option.find_first_not_of('-')));
  return setting == known_settings().end() ? std::vector<std::string>() : setting->second.words;
}

/// The choice that a wrong one means. Empty if it is right, or the option takes other values than choices.
/// `*complete`: false if no choice is near.
std::string right_choice(const std::string& option, const std::string& choice, bool* complete) {
  const std::vector<std::string> choices = choices_of(option);
  if (choices.empty()) return {};
  for (const char* open : {"primvars:", "lightGroup:", "lpe:"})
    if (choice.starts_with(open)) return {};
  if (std::find(choices.begin(), choices.end(), choice) != choices.end()) return {};
  const std::string right = hd::support::NearestName(choice, choices);
  *complete = *complete && !right.empty();
  return right;
}

}  // namespace

std::string examples_text() {
  std::string text = "Alabaster renders translucent materials: skin, wax, marble, leaves. Examples:\n\n";
  for (size_t i = 0; i < kShownExamples; ++i)
    text += std::string("  # ") + kExamples[i].meaning + "\n  " + kExamples[i].line + "\n";
  return text + "\nCommands: alabaster --help. Options of one: alabaster render --help.\n";
}

std::string word_fault(const CLI::App& app, const Words& words, const CLI::ParseError& error) {
  if (words.empty()) return {};
  if (is_option(words[0])) return early_option_fault(app, words);
  const CLI::App* command = find_command(app, words[0]);
  return command ? command_fault(*command, words, error) : unknown_command(app, words);
}

std::string command_fault(const CLI::App& command, const Words& words, const CLI::ParseError& error) {
  const std::string fault = option_fault(command, words);
  if (!fault.empty() || error.get_name() != "RequiredError") return fault;
  std::string missing = error.what();
  if (missing.starts_with("file ")) missing.replace(0, 4, "SCENE");
  const bool is_below = missing.starts_with("folder ");  // of farm status
  if (is_below) missing.replace(0, 6, "FOLDER");
  const std::string name = words[0] + (is_below ? " status" : "");
  return with_example("alabaster " + name + ": " + missing + ". For example:", example_of(name));
}

std::string with_near_choices(const CLI::App& app, const Words& words) {
  const CLI::App* command = words.empty() ? nullptr : find_command(app, words[0]);
  if (!command) return {};
  Words corrected = words;
  bool complete = true, changed = false;
  for (size_t i = 1; i < words.size() && words[i] != "--"; ++i) {
    bool holds_value = false;
    const CLI::Option* option = is_option(words[i]) ? known_option(*command, words[i], &holds_value) : nullptr;
    if (!option || option->get_expected_max() == 0) continue;
    const std::string name = option_name(*option);
    if (!holds_value && ++i == words.size()) break;
    const size_t begin = holds_value ? words[i].find('=') + 1 : 0;
    const std::string right = right_choice(name, words[i].substr(begin), &complete);
    if (right.empty()) continue;
    corrected[i] = words[i].substr(0, begin) + right;
    changed = true;
  }
  return complete && changed ? command_text(corrected) : std::string();
}

std::string option_name(const CLI::Option& option) {
  return option.get_lnames().empty() ? std::string() : "--" + option.get_lnames()[0];
}

const Words& farm_engines() {
  static const Words kEngines{"script", "slurm", "openjd"};
  return kEngines;
}

std::string joined(const Words& names, const std::string& between) {
  std::string text;
  for (const std::string& name : names) text += (text.empty() ? "" : between) + name;
  return text;
}

Words with_options(const Words& words, const Words& left_out, const Words& added) {
  Words kept;
  for (size_t i = 0; i < words.size(); ++i) {
    if (std::find(left_out.begin(), left_out.end(), option_of(words[i])) == left_out.end())
      kept.push_back(words[i]);
    else if (words[i].find('=') == std::string::npos)
      ++i;  // its value
  }
  // After "--" there are no options.
  kept.insert(std::find(kept.begin(), kept.end(), "--"), added.begin(), added.end());
  return kept;
}

std::string command_text(const Words& words) {
  std::string text = "alabaster";
  for (const std::string& word : words) text += " " + shell_word(word);
  return has_control_character(text) ? std::string() : text;
}

}  // namespace alabaster::cli
