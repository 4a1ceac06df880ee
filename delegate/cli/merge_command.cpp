#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "delegate/cli/commands.h"
#include "delegate/cli/exit_codes.h"
#include "delegate/cli/interrupt.h"
#include "delegate/cli/outputs.h"
#include "delegate/cli/render_options.h"
#include "delegate/cli/shell_word.h"
#include "delegate/host/product_limits.h"

namespace alabaster::cli {
namespace {

using hd::host::RecordStatus;
using nlohmann::json;

// Reads the note of a part, which the frame recorder has written. Empty if it is no such note. Limits are those of this
// command and not of a file.
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
    for (const char* name : {"memoryLimit", "textureMemory", "threads"}) d.settings.erase(name);
    return d;
  } catch (const json::exception&) {
    return std::nullopt;
  }
}

// A part as its file tells of it.
struct PartState {
  std::string file;
  int64_t first = 0, end = 0;  // of its samples
  bool is_whole = false;
  double taken = 0, error = -1;  // mean samples per pixel that are saved, and their relative RMSE; < 0: not known

  double share() const { return is_whole ? 1 : end > first ? taken / static_cast<double>(end - first) : 0; }
};

class MergeCommand {
 public:
  explicit MergeCommand(const MergeArguments& arguments) : a_(arguments), console_(arguments.quiet) {}

  int run() {
    catch_interrupts();
    if (!session_.choose_colors(a_.ocio, console_.sink())) return kUsage;
    int code = plan();
    if (code != kDone) return code;
    if (!session_.start(console_.sink())) return kRender;
    code = a_.outputs.empty() ? tell() : merge();
    return code;
  }

 private:
  int merge() {
    int code = check_all_there();
    if (code == kDone) code = describe(a_.parts);
    return code == kDone ? write() : code;
  }

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
      if (const auto check = hd::host::CheckProduct(product, session_.colors(), console_.sink()); !check)
        return exit_code(check.status, true);
    return kDone;
  }

  // How far the parts are, and the noise so far.
  int tell() {
    std::vector<PartState> saved;
    double share = 0;
    for (const std::string& file : a_.parts) {
      PartState part{.file = file};
      if (const int code = look_at(&part); code != kDone) return code;
      share += part.share();
      if (part.end > 0) saved.push_back(std::move(part));
    }
    const auto whole = std::count_if(saved.begin(), saved.end(), [](const PartState& part) { return part.is_whole; });
    std::printf("%lld of %zu parts are whole, and %.0f %% of the samples are saved\n", static_cast<long long>(whole),
                a_.parts.size(), std::floor(100 * share / static_cast<double>(a_.parts.size())));
    return tell_noise(std::move(saved));
  }

  // Prints a line about a part; its end stays 0 where nothing is saved.
  int look_at(PartState* part) {
    if (!std::filesystem::exists(part->file)) {
      std::printf("%s: nothing is saved yet\n", printable(part->file).c_str());
      return kDone;
    }
    int code = read(part, false);
    if (code == kDone && !part->is_whole) code = read(part, true);  // only a part that goes on is read twice
    if (code != kDone) return code;
    std::printf("%s: samples %lld to %lld, ", printable(part->file).c_str(), static_cast<long long>(part->first),
                static_cast<long long>(part->end - 1));
    if (part->is_whole)
      std::printf("whole\n");
    else
      std::printf("%.1f of %lld are saved\n", part->taken, static_cast<long long>(part->end - part->first));
    return kDone;
  }

  int read(PartState* part, bool measure) {
    std::shared_ptr<const hd::Dictionary> dictionary;
    if (const int code = describe_file(part->file, measure, &dictionary); code != kDone) return code;
    const auto number = [&](const char* name, double unknown) {
      const auto found = dictionary->find(name);
      return found == dictionary->end() ? unknown : found->second.number_or(unknown);
    };
    part->first = static_cast<int64_t>(number("firstSample", 0));
    part->end = static_cast<int64_t>(number("samples", 0));
    part->is_whole = dictionary->at("complete").get_or(false);
    part->taken = number("meanSamples", 0);
    part->error = number("error.relativeRmse", -1);
    return kDone;
  }

  // The whole parts from sample 0 on without a gap make a frame, whose noise is known with its interval. The other
  // parts are pictures of their own: the error of the mean of independent pictures is the root of the sum of squares.
  int tell_noise(std::vector<PartState> saved) {
    std::stable_sort(saved.begin(), saved.end(), [](const auto& a, const auto& b) { return a.first < b.first; });
    std::vector<std::string> joined;
    int64_t end = 0;
    for (const PartState& part : saved)
      if (part.is_whole && part.first == end) joined.push_back(part.file), end = part.end;
    double samples = 0, squares = 0;
    const auto add = [&](double count, double error) {
      if (error < 0 || !std::isfinite(error)) return;
      samples += count;
      squares += count * count * error * error;
    };
    if (!joined.empty()) {
      hd::Dictionary stats;
      if (const int code = tell_joined(joined, &stats); code != kDone || joined.size() == saved.size()) return code;
      const auto error = stats.find("error.relativeRmse");
      add(static_cast<double>(end), error == stats.end() ? -1 : error->second.number_or(-1));
    }
    for (PartState& part : saved) {
      if (std::find(joined.begin(), joined.end(), part.file) != joined.end()) continue;
      if (part.is_whole)
        if (const int code = read(&part, true); code != kDone) return code;
      add(part.taken, part.error);
    }
    if (samples > 0)
      std::printf("noise of all that is saved: about %.2f %% relative RMSE after %.0f samples per pixel\n",
                  100 * std::sqrt(squares) / samples, samples);
    return kDone;
  }

  int tell_joined(const std::vector<std::string>& parts, hd::Dictionary* stats) {
    if (const int code = describe(parts); code != kDone) return code;
    hd::host::RecordOptions options;
    options.cancel = &interrupted();
    options.diagnostics = console_.sink();
    hd::host::RecordResult result = hd::host::RecordFrame(session_.index(), &session_.scene, path_, options);
    if (const std::string text = noise_text(result.stats); !text.empty()) std::printf("%s\n", text.c_str());
    *stats = std::move(result.stats);
    return exit_code(result);
  }

  // Tells that tasks have not run, which a farm's merge finds out first.
  int check_all_there() {
    std::vector<std::string> absent;
    for (const std::string& part : a_.parts)
      if (!std::filesystem::exists(part)) absent.push_back(part);
    if (absent.empty()) return kDone;
    const std::string count = std::to_string(absent.size()) + " of " + std::to_string(a_.parts.size());
    return fail(absent[0], "there is no such file; parts missing: " + count + ". First " + way_to(absent[0]));
  }

  // The way to render a missing part: by its farm, if there is one.
  static std::string way_to(const std::string& part) {
    const std::filesystem::path folder = std::filesystem::path(part).parent_path();
    if (std::filesystem::exists(folder / "submit.sh")) return "run its tasks: sh " + shell_path(folder / "submit.sh");
    if (std::filesystem::exists(folder / "task.sh"))
      return "run its task: sh " + shell_path(folder / "task.sh") + " K, with the number of the part";
    return "render it with --samples A:B --checkpoint " + shell_path(part);
  }

  // Reads from the parts what frame they are of. showCheckpoints finds out if they belong together.
  int describe(const std::vector<std::string>& parts) {
    std::optional<hd::RenderSettingsDescription> frame;
    int64_t samples = 0;
    for (const std::string& part : parts) {
      std::shared_ptr<const hd::Dictionary> dictionary;
      if (const int code = describe_file(part, false, &dictionary); code != kDone) return code;
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
    for (const hd::RenderProduct& product : products_)
      if (!hd::host::CheckProductSize(product, frame->window(), console_.sink())) return kUsage;
    session_.scene.SetRenderSettings(path_, std::move(*frame));
    const hd::Dictionary files{{"files", hd::Array<std::string>(parts)}};
    return ended("merge", session_.delegate()->InvokeCommand("showCheckpoints", files));
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
    return exit_code(result);
  }

  int describe_file(const std::string& file, bool measure, std::shared_ptr<const hd::Dictionary>* description) {
    const hd::CommandResult described =
        session_.delegate()->InvokeCommand("describeCheckpoint", {{"file", file}, {"measure", measure}});
    *description = described.value.get_or(std::make_shared<const hd::Dictionary>());
    return ended(file, described);
  }

  int ended(const std::string& where, const hd::CommandResult& result) {
    if (!result.ok()) console_.error(where, result.fault);
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
