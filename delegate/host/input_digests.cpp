#include "delegate/host/input_digests.h"

#include <algorithm>
#include <vector>

#include "core/color/config_inputs.h"
#include "core/digest/digest.h"
#include "core/files/input_file.h"
#include "core/math/float_environment.h"

namespace alabaster::hd::host {
namespace {

std::string digest_of(std::initializer_list<std::string> texts) {
  Digest digest;
  for (const std::string& text : texts) digest.add(text);
  return digest.text();
}

}  // namespace

std::string FileDigest(const std::string& file) {
  constexpr uint64_t kAtOnce = uint64_t(1) << 20;
  const InputFile opened(file);
  if (!opened) return {};
  Digest digest;
  std::vector<std::byte> block;
  for (uint64_t at = 0; at < opened.size(); at += kAtOnce) {
    block.resize(std::min(kAtOnce, opened.size() - at));
    if (!opened.read(at, block.data(), block.size())) return {};
    digest.add_bytes(block);
  }
  return digest.text();
}

std::optional<ColorInputs> ReadColorInputs(const OutputColors& colors, const DiagnosticSink& sink) {
  const FloatEnvironment environment;
  const auto config = colors.config(sink);
  if (!config) return std::nullopt;
  const ConfigInputs found = config_inputs(*config);
  const std::string display = config->default_display();
  ColorInputs inputs{config->origin(),
                     found.library,
                     digest_of({config->serialize(), display, config->default_view(display)}),
                     {},
                     found.variables};
  for (const char* of_machine :
       {"HOME", "HOSTNAME", "LD_LIBRARY_PATH", "LOGNAME", "PATH", "PWD", "SHELL", "TMPDIR", "USER"})
    inputs.variables.erase(of_machine);
  for (const auto& [name, file] : found.luts)
    inputs.luts[name] = {file, file.empty() ? std::string() : FileDigest(file)};
  return inputs;
}

std::string ColorInputs::all() const {
  Digest whole;
  whole.add(digest);
  for (const auto& [name, lut] : luts) whole.add(name), whole.add(lut.digest);
  for (const auto& [name, value] : variables) whole.add(name), whole.add(value.value_or(""));
  return whole.text();
}

}  // namespace alabaster::hd::host
