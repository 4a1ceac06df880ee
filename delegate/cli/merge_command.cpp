#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <map>
#include <nlohmann/json.hpp>

#include "delegate/cli/commands.h"
#include "delegate/cli/exit_codes.h"
#include "delegate/cli/interrupt.h"
#include "delegate/cli/outputs.h"
#include "delegate/cli/render_options.h"

namespace alabaster::cli {
namespace {

using hd::host::RecordStatus;
using nlohmann::json;

// Reads the note of a part, which the frame recorder has written. Empty if it is no such note.
std::optional<hd::RenderSettingsDescription> description_of(const json& note) {
  try {
    hd::RenderSettingsDescription d;
    d.camera = note.at("camera").get<std::string>();
    d.width = note.at("size").at(0).get<int>();
    d.height = note.at("size").at(1).get<int>();
    const auto window = note.at("window").get<std::array<int, 4>>();
    d.crop = hd::Rect2i{window[0], window[1], window[2], window[3]};
    if (*d.crop == d.frame_window()) d.crop.reset();
    d.pixelAspectRatio = note.at("pixelAspectRatio").get<float>();
    d.frame = note.at("frame").get<double>();
    for (const auto& [name, value] : note.at("settings").items()) {
      hd::Value& setting = d.settings[name];
      if (value.is_boolean())
        setting = value.get<bool>();
      else if (value.is_number_integer())
        setting = value.get<int64_t>();
      else if (value.is_number())
        setting = value.get<float>();
      else
        setting = value.get<std::string>();
    }
    return d;
  } catch (const json::exception&) {
    return std::nullopt;
  }
}

class MergeCommand {
 public:
  explicit MergeCommand(const MergeArguments& arguments) : a_(arguments), console_(arguments.quiet) {}

  int run() {
    catch_interrupts();
    if (!session_.choose_colors(a_.ocio, console_.sink())) return kUsage;
    int code = plan();
    if (code != kDone) return code;
    if (!session_.start(console_.sink())) return kRender;
    if (a_.outputs.empty()) return tell();
    code = describe(a_.parts);
    return code == kDone ? write() : code;
  }

 private:
  int plan() {
    RenderArguments products;
    products.outputs = a_.outputs;
    products.display = a_.display, products.view = a_.view, products.look = a_.look;
    products.exposure = a_.exposure;
    products.aovs = a_.aovs;
    std::string problem;
    for (const std::string& part : a_.parts) {
      std::vector<std::string> files = a_.outputs;
      files.push_back(part);
      if (problem.empty()) problem = same_file_twice(files);
    }
    if (problem.empty() && !a_.outputs.empty()) products_ = make_products(products, {}, &problem);
    if (!problem.empty()) return console_.usage_error("merge", problem);
    for (const hd::RenderProduct& product : products_)
      if (!hd::host::CheckProduct(product, session_.colors(), console_.sink()))
        return console_.last_error().code == "product.invalid" ? kUsage : kOutput;
    return kDone;
  }

  // How far the parts are, and the noise of as many as make a frame: those from sample 0 on without a gap.
  int tell() {
    std::map<int64_t, std::pair<int64_t, std::string>> whole;  // by first sample: the end and the file
    for (const std::string& part : a_.parts) {
      if (!std::filesystem::exists(part)) {
        std::printf("%s: not begun\n", printable(part).c_str());
        continue;
      }
      const hd::Value described = session_.delegate()->InvokeCommand("describeCheckpoint", {{"file", part}});
      const auto dictionary = described.get_or(std::shared_ptr<const hd::Dictionary>());
      if (!dictionary) return fail(part, described.text_or(""));
      const int64_t first = dictionary->at("firstSample").get_or(int64_t(0));
      const int64_t end = dictionary->at("samples").get_or(int64_t(0));
      const bool is_whole = dictionary->at("complete").get_or(false);
      if (is_whole) whole[first] = {end, part};
      std::printf("%s: samples %lld to %lld, %s\n", printable(part).c_str(), static_cast<long long>(first),
                  static_cast<long long>(end - 1), is_whole ? "whole" : "not whole yet");
    }
    std::printf("%zu of %zu parts are whole\n", whole.size(), a_.parts.size());
    std::vector<std::string> joined;
    int64_t end = 0;
    for (auto next = whole.find(0); next != whole.end(); next = whole.find(end)) {
      joined.push_back(next->second.second);
      end = next->second.first;
    }
    if (joined.empty()) return kDone;
    if (const int code = describe(joined); code != kDone) return code;
    hd::host::RecordOptions options;
    options.cancel = &interrupted();
    options.diagnostics = console_.sink();
    const hd::host::RecordResult result = hd::host::RecordFrame(session_.index(), &session_.scene, path_, options);
    std::printf("%s\n", noise_text(result.stats).c_str());
    return exit_code(result.status);
  }

  // Reads from the parts what frame they are of. showCheckpoints finds out if they belong together.
  int describe(const std::vector<std::string>& parts) {
    std::optional<hd::RenderSettingsDescription> frame;
    int64_t samples = 0;
    for (const std::string& part : parts) {
      const hd::Value described = session_.delegate()->InvokeCommand("describeCheckpoint", {{"file", part}});
      const auto dictionary = described.get_or(std::shared_ptr<const hd::Dictionary>());
      if (!dictionary) return fail(part, described.text_or(""));
      samples = std::max(samples, dictionary->at("samples").get_or(int64_t(0)));
      const json note = json::parse(dictionary->at("note").text_or(""), nullptr, false);
      degraded_ = degraded_ || (note.is_object() && note.value("degraded", json()) == json(true));
      if (!frame) frame = description_of(note);
      if (!frame)
        return fail(part, "it does not say what frame it is of: only checkpoints of 'alabaster render' can be merged");
    }
    frame->settings["samples"] = samples;
    frame->settings["firstSample"] = int64_t(0);
    frame->products = products_;
    session_.scene.SetRenderSettings(path_, std::move(*frame));
    const hd::Dictionary files{{"files", hd::Array<std::string>(parts)}};
    const std::string fault = session_.delegate()->InvokeCommand("showCheckpoints", files).text_or("");
    return fault.empty() ? kDone : fail("merge", fault);
  }

  int write() {
    hd::host::RecordOptions options;
    options.colors = session_.colors();
    options.cancel = &interrupted();
    options.diagnostics = console_.sink();
    options.progress = [this](const hd::host::RecordProgress& progress) { console_.progress(progress); };
    options.writing = [] { set_writing(true); };
    const hd::host::RecordResult result = hd::host::RecordFrame(session_.index(), &session_.scene, path_, options);
    console_.end_progress();
    for (const std::string& file : result.written) console_.note("wrote " + file);
    if (result.status == RecordStatus::done && degraded_) {
      console_.note("the parts were rendered with --keep-going, without all that their scene names");
      return kDegraded;
    }
    return exit_code(result.status);
  }

  int fail(const std::string& where, const std::string& fault) {
    console_.error(where, fault);
    return kInput;
  }

  const MergeArguments& a_;
  Console console_;
  SceneSession session_;
  const hd::Path path_{"/merge"};
  std::vector<hd::RenderProduct> products_;
  bool degraded_ = false;
};

}  // namespace

int run_merge(const MergeArguments& arguments) {
  return MergeCommand(arguments).run();
}

}  // namespace alabaster::cli
