#include "delegate/cli/picture_inputs.h"

#include <algorithm>
#include <array>
#include <sstream>

#include "core/files/input_file.h"
#include "delegate/cli/exit_codes.h"
#include "delegate/host/denoiser_library.h"
#include "delegate/support/lookup.h"

namespace alabaster::cli {
namespace {

constexpr const char* kTitle = "alabaster farm inputs 1";
constexpr std::array<const char*, 6> kInputKinds{"version", "variable", "colors",
                                                 "lut",     "file",     "reader"};  // by InputKind

PictureInputs::key_type denoiser_key() {
  return {InputKind::version, "Open Image Denoise"};
}

// Bytes other than visible ASCII as %XX.
std::string percent_escaped(const std::string& text) {
  constexpr const char* kDigits = "0123456789abcdef";
  std::string out;
  for (const char c : text) {
    const auto byte = static_cast<unsigned char>(c);
    if (byte > ' ' && byte < 0x7f && c != '%')
      out += c;
    else
      out += std::string("%") + kDigits[byte >> 4] + kDigits[byte & 15];
  }
  return out;
}

std::string percent_unescaped(const std::string& text) {
  const auto digit = [](char c) { return c <= '9' ? c - '0' : c - 'a' + 10; };
  std::string out;
  for (size_t i = 0; i < text.size(); ++i) {
    const bool is_escape = text[i] == '%' && i + 2 < text.size();
    out += is_escape ? static_cast<char>(digit(text[i + 1]) * 16 + digit(text[i + 2])) : text[i];
    if (is_escape) i += 2;
  }
  return out;
}

// The text of a variable, for people.
std::string variable_text(const std::string& value) {
  return value.empty() ? "not set" : "'" + value.substr(1) + "'";
}

InputDifference describe(InputKind kind, const std::string& name, const std::string* farm, const std::string* here) {
  const std::string again = "or write the farm's jobs again with what this machine has";
  const auto version = [](const std::string* of) { return of ? *of : "none"; };
  switch (kind) {
    case InputKind::version:
    case InputKind::reader:
      return {name, "this machine has version " + version(here) + ", and the farm's jobs were written with " +
                        version(farm) + ": install that version here, " + again};
    case InputKind::colors:
      return {name, "the colour configuration is not that of the farm: copy that file here, " + again};
    case InputKind::variable:
      return {"$" + name, "the colour configuration names this variable, which is " + variable_text(here ? *here : "") +
                              " here and " + variable_text(farm ? *farm : "") + " for the farm: set it so, " + again};
    case InputKind::lut:
      return {name, std::string("this LUT of the colour configuration ") +
                        (!here || here->empty() ? "is not found" : "is not that of the farm") +
                        ": copy the farm's into its search path, " + again};
    case InputKind::file:
      break;
  }
  if (!farm) return {name, "the scene reads this file, which the farm's scene does not have: remove it, " + again};
  return {name, std::string(!here           ? "the farm's scene reads this file, and the scene here does not"
                            : here->empty() ? "this file cannot be read"
                                            : "this file is not that of the farm") +
                    ": copy the farm's file here, " + again};
}

}  // namespace

void add_colors(const hd::host::ColorInputs& colors, PictureInputs* inputs) {
  std::istringstream lines(AlabasterVersions());
  for (std::string line; std::getline(lines, line);) {
    const size_t space = line.find(' ');
    const bool is_own = space == std::string::npos;
    (*inputs)[{InputKind::version, is_own ? "Alabaster" : line.substr(0, space)}] =
        is_own ? line : line.substr(space + 1);
  }
  (*inputs)[{InputKind::version, "OpenColorIO"}] = colors.library;
  (*inputs)[{InputKind::colors, colors.origin}] = colors.digest;
  for (const auto& [name, lut] : colors.luts) (*inputs)[{InputKind::lut, name}] = lut.digest;
  for (const auto& [name, value] : colors.variables)
    (*inputs)[{InputKind::variable, name}] = value ? "=" + *value : std::string();
}

void add_denoiser(PictureInputs* inputs) {
  if (const std::string version = hd::host::DenoiserVersion(); !version.empty()) (*inputs)[denoiser_key()] = version;
}

void add_files(const SceneSession& session, const std::string& scene, PictureInputs* inputs) {
  for (const std::string& file : scene_files(session, scene))
    (*inputs)[{InputKind::file, file}] = hd::host::FileDigest(file);
  for (const auto& model : session.file.models)
    for (const auto& [name, version] : model.libraries) (*inputs)[{InputKind::reader, name}] = version;
}

std::string to_text(const PictureInputs& inputs) {
  std::string text = std::string(kTitle) + "\n";
  for (const auto& [input, value] : inputs)
    text += std::string(kInputKinds[static_cast<size_t>(input.first)]) + " " + percent_escaped(input.second) + " " +
            percent_escaped(value) + "\n";
  return text;
}

PictureInputs parse_inputs(const std::string& text) {
  std::istringstream lines(text);
  PictureInputs inputs;
  std::string line;
  if (!std::getline(lines, line) || line != kTitle) return {};
  while (std::getline(lines, line)) {
    const size_t first = line.find(' '), second = line.find(' ', first + 1);
    if (first == std::string::npos || second == std::string::npos) return {};
    const auto kind = std::find(kInputKinds.begin(), kInputKinds.end(), line.substr(0, first));
    if (kind == kInputKinds.end()) return {};
    inputs[{static_cast<InputKind>(kind - kInputKinds.begin()),
            percent_unescaped(line.substr(first + 1, second - first - 1))}] =
        percent_unescaped(line.substr(second + 1));
  }
  return inputs;
}

InputDifference input_difference(const PictureInputs& farm, const PictureInputs& here, bool with_files) {
  PictureInputs both = farm;
  both.insert(here.begin(), here.end());
  for (const auto& [key, unused] : both) {
    if ((key.first == InputKind::file || key.first == InputKind::reader) && !with_files) continue;
    const std::string *const theirs = hd::support::find_in(farm, key), *const ours = hd::support::find_in(here, key);
    if (!theirs || !ours || *theirs != *ours) return describe(key.first, key.second, theirs, ours);
  }
  return {};
}

void require_inputs(const std::string& file, const SceneSession& session, const std::string& scene, Console* console) {
  if (file.empty()) return;
  const InputFile opened(file);
  std::string text;
  console->require(kInput, file, opened ? std::string() : opened.reason());
  const PictureInputs farm = opened.read(&text) ? parse_inputs(text) : PictureInputs();
  if (farm.empty()) console->fail(kInput, file, "this is no list of inputs, which 'alabaster farm' writes");
  const auto colors = hd::host::ReadColorInputs(session.colors(), console->sink());
  if (!colors) throw Exit{kInput};
  PictureInputs here;
  add_colors(*colors, &here);
  if (!scene.empty()) add_files(session, scene, &here);
  // The merge denoises. The tasks do not, so that their machines may have another denoiser.
  if (const auto denoiser = farm.find(denoiser_key()); denoiser != farm.end() && scene.empty())
    add_denoiser(&here);
  else if (denoiser != farm.end())
    here.insert(*denoiser);
  const InputDifference found = input_difference(farm, here, !scene.empty());
  if (!found.text.empty()) console->fail(kInput, found.where, found.text);
}

}  // namespace alabaster::cli
