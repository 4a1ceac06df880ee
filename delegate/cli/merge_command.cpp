#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <tuple>

#include "delegate/cli/commands.h"
#include "delegate/cli/exit_codes.h"
#include "delegate/cli/interrupt.h"
#include "delegate/cli/outputs.h"
#include "delegate/cli/picture_inputs.h"
#include "delegate/cli/render_options.h"
#include "delegate/cli/shell_word.h"
#include "delegate/support/lookup.h"

namespace alabaster::cli {
namespace {

using hd::host::RecordStatus;
using hd::support::number_in;

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
    session_.choose_colors(a_.ocio, console_.sink(), kUsage);
    require_inputs(a_.inputs, session_, {}, &console_);
    plan();
    session_.start(console_.sink());
    if (a_.outputs.empty()) return tell();
    check_all_there();
    describe(a_.parts);
    return write();
  }

 private:
  void plan() {
    for (const std::string& part : a_.parts) {
      std::vector<std::string> files = a_.outputs;
      files.push_back(part);
      console_.require_usage("merge", same_file_twice(files));
    }
    if (!a_.outputs.empty()) products_ = make_products(a_, {}, "merge", console_);
  }

  // How far the parts are, and the noise so far.
  int tell() {
    std::vector<PartState> saved;
    double share = 0;
    for (const std::string& file : a_.parts) {
      PartState part{.file = file};
      look_at(&part);
      share += part.share();
      if (part.end > 0) saved.push_back(std::move(part));
    }
    const auto whole = std::count_if(saved.begin(), saved.end(), [](const PartState& part) { return part.is_whole; });
    std::printf("%lld of %zu parts are whole, and %.0f %% of the samples are saved\n", static_cast<long long>(whole),
                a_.parts.size(), std::floor(100 * share / static_cast<double>(a_.parts.size())));
    tell_noise(std::move(saved));
    return kDone;
  }

  // Prints a line about a part; its end stays 0 where nothing is saved.
  void look_at(PartState* part) {
    if (!std::filesystem::exists(part->file)) {
      std::printf("%s: nothing is saved yet\n", printable(part->file).c_str());
      return;
    }
    read(part, false);
    if (!part->is_whole) read(part, true);  // only a part that goes on is read twice
    std::printf("%s: samples %lld to %lld, ", printable(part->file).c_str(), static_cast<long long>(part->first),
                static_cast<long long>(part->end - 1));
    if (part->is_whole)
      std::printf("whole\n");
    else
      std::printf("%.1f of %lld are saved\n", part->taken, static_cast<long long>(part->end - part->first));
  }

  void read(PartState* part, bool measure) {
    const auto dictionary = describe_file(part->file, measure);
    part->first = static_cast<int64_t>(number_in(*dictionary, "firstSample"));
    part->end = static_cast<int64_t>(number_in(*dictionary, "samples"));
    part->is_whole = dictionary->at("complete").get_or(false);
    part->taken = number_in(*dictionary, "meanSamples");
    part->error = number_in(*dictionary, "error.relativeRmse", -1);
  }

  // The whole parts from sample 0 on without a gap make a frame, whose noise is known with its interval. The other
  // parts are pictures of their own: the error of the mean of independent pictures is the root of the sum of squares.
  void tell_noise(std::vector<PartState> saved) {
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
      const hd::Dictionary stats = tell_joined(joined);
      if (joined.size() == saved.size()) return;
      add(static_cast<double>(end), number_in(stats, "error.relativeRmse", -1));
    }
    for (PartState& part : saved) {
      if (std::find(joined.begin(), joined.end(), part.file) != joined.end()) continue;
      if (part.is_whole) read(&part, true);
      add(part.taken, part.error);
    }
    if (samples > 0)
      std::printf("noise of all that is saved: about %.2f %% relative RMSE after %.0f samples per pixel\n",
                  100 * std::sqrt(squares) / samples, samples);
  }

  hd::Dictionary tell_joined(const std::vector<std::string>& parts) {
    describe(parts);
    hd::host::RecordOptions options;
    options.cancel = &interrupted();
    options.diagnostics = console_.sink();
    const hd::host::RecordResult result = hd::host::RecordFrame(session_.index(), &session_.scene, path_, options);
    if (const std::string text = noise_text(result.stats); !text.empty()) std::printf("%s\n", text.c_str());
    require(exit_code(result));
    return result.stats;
  }

  // Tells that tasks have not run, which a farm's merge finds out first.
  void check_all_there() {
    std::vector<std::string> absent;
    for (const std::string& part : a_.parts)
      if (!std::filesystem::exists(part)) absent.push_back(part);
    if (absent.empty()) return;
    const std::string count = std::to_string(absent.size()) + " of " + std::to_string(a_.parts.size());
    console_.fail(kInput, absent[0], "there is no such file; parts missing: " + count + ". First " + way_to(absent[0]));
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
  void describe(const std::vector<std::string>& parts) {
    std::optional<hd::RenderSettingsDescription> frame;
    int64_t samples = 0;
    for (const std::string& part : parts) {
      const auto dictionary = describe_file(part, false);
      samples = std::max(samples, dictionary->at("samples").get_or(int64_t(0)));
      if (const auto* groups = dictionary->at("lightGroups").get<hd::Array<std::string>>())
        light_groups_.assign(groups->begin(), groups->end());
      std::optional<hd::host::FrameNote> note = hd::host::ReadFrameNote(dictionary->at("note").text_or(""));
      degraded_ = degraded_ || (note && note->degraded);
      if (note) compare_colors(part, *note);
      if (note) compare_products(part, note->frame.products);
      if (!frame && note) frame = std::move(note->frame), metadata_ = std::move(note->metadata);
      if (!frame)
        console_.fail(kInput, part,
                      "it does not say what frame it is of: only checkpoints of 'alabaster render' can be merged");
    }
    frame->settings["samples"] = samples;
    frame->settings["firstSample"] = int64_t(0);
    if (!products_.empty()) take_colors(shown_);
    frame->products = products_;
    session_.scene.SetRenderSettings(path_, std::move(*frame));
    const hd::Dictionary files{{"files", hd::Array<std::string>(parts)}};
    require_done("merge", session_.delegate()->InvokeCommand("showCheckpoints", files));
  }

  void compare_colors(const std::string& part, const hd::host::FrameNote& note) {
    if (first_part_.empty()) first_part_ = part, config_ = note.color_config, config_digest_ = note.color_digest;
    if (note.color_digest.empty() || config_digest_.empty())
      console_.fail(kInput, part,
                    "this part or " + first_part_ +
                        " does not tell its colour configuration, as those of an earlier version: render it again");
    if (note.color_digest != config_digest_)
      console_.fail(kInput, part,
                    "its colour configuration, '" + note.color_config + "', is not that of " + first_part_ + ", '" +
                        config_ + "': render one of them again with the other's");
  }

  // Parts without files, as a farm's, agree with all others.
  void compare_products(const std::string& part, const std::vector<hd::RenderProduct>& shown) {
    if (shown_.empty()) shown_ = shown, shown_by_ = part;
    const bool is_chosen = !a_.display.empty() || !a_.view.empty() || !a_.look.empty() || a_.exposure;
    for (const hd::RenderProduct& product : is_chosen ? std::vector<hd::RenderProduct>() : shown) {
      const hd::RenderProduct* const first = like(product, shown_);
      const auto colors = [](const hd::RenderProduct& p) {
        return std::tie(p.display, p.view, p.look, p.exposure, p.colorSpace);
      };
      if (first && !products_.empty() && colors(*first) != colors(product))
        console_.fail(kInput, part,
                      "it shows the frame with another display, view, look, exposure or colour space than " +
                          shown_by_ + ": choose with --display, --view, --look or --exposure");
    }
  }

  // The configuration and the display of the parts, where the command line names none.
  void take_colors(const std::vector<hd::RenderProduct>& shown) {
    const auto is_theirs = [&] {
      const auto inputs = hd::host::ReadColorInputs(session_.colors(), console_.sink());
      return inputs && inputs->all() == config_digest_;
    };
    if (a_.ocio.empty() && !config_.empty() && !is_theirs()) {  // $OCIO may name a copy of it
      session_.choose_colors(config_, console_.sink(), kInput);
      if (!is_theirs())
        console_.fail(kInput, config_,
                      "this colour configuration, a LUT of it or a variable that it names is not what the parts were "
                      "rendered with: restore it, or name a configuration with --ocio");
    }
    for (hd::RenderProduct& product : products_) {
      const hd::RenderProduct* const theirs = like(product, shown);
      if (!theirs) continue;
      if (product.dataType.empty()) product.dataType = theirs->dataType;
      if (product.compression.empty()) product.compression = theirs->compression;
      if (!a_.tiles) product.tiles = theirs->tiles;
      if (a_.display.empty() && a_.view.empty()) {
        product.display = theirs->display, product.view = theirs->view;
        product.colorSpace = theirs->colorSpace;
      }
      if (a_.look.empty()) product.look = theirs->look;
      if (!a_.exposure) product.exposure = theirs->exposure;
    }
  }

  // The product of that name; else the first of its kind. Null: there is none.
  static const hd::RenderProduct* like(const hd::RenderProduct& product, const std::vector<hd::RenderProduct>& all) {
    const auto name = [](const hd::RenderProduct& p) { return std::filesystem::path(p.file).filename(); };
    const auto is_exr = [](const hd::RenderProduct& p) { return p.file.ends_with(".exr"); };
    const hd::RenderProduct* found = nullptr;
    for (const hd::RenderProduct& other : all) {
      if (is_exr(other) != is_exr(product)) continue;
      if (name(other) == name(product)) return &other;
      if (!found) found = &other;
    }
    return found;
  }

  int write() {
    hd::host::RecordOptions options;
    options.colors = session_.colors();
    options.metadata = metadata_;
    options.light_groups = light_groups_;
    options.cancel = &interrupted();
    options.diagnostics = console_.sink();
    options.progress = [this](const hd::host::RecordProgress& progress) { console_.progress(progress); };
    options.writing = [] { set_writing(true); };
    options.plan = hd::host::PlanFrame(session_.scene, path_, *session_.delegate(), options);
    require(exit_code(options.plan, true));
    const hd::host::RecordResult result = hd::host::RecordFrame(session_.index(), &session_.scene, path_, options);
    console_.end_progress();
    for (const std::string& file : result.written) console_.note("wrote " + file);
    if (result.status == RecordStatus::done && degraded_) {
      console_.note("the parts were rendered with --keep-going, without all that their scene names");
      return kDegraded;
    }
    return exit_code(result);
  }

  std::shared_ptr<const hd::Dictionary> describe_file(const std::string& file, bool measure) {
    const hd::CommandResult described =
        session_.delegate()->InvokeCommand("describeCheckpoint", {{"file", file}, {"measure", measure}});
    require_done(file, described);
    return described.value.get_or(std::make_shared<const hd::Dictionary>());
  }

  void require_done(const std::string& where, const hd::CommandResult& result) {
    if (!result.ok()) console_.fail(exit_code(result.status), where, result.fault);
  }

  const MergeArguments& a_;
  Console console_;
  SceneSession session_;
  const hd::Path path_{"/merge"};
  std::vector<hd::RenderProduct> products_;
  hd::Dictionary metadata_;
  std::vector<std::string> light_groups_;
  bool degraded_ = false;
  std::string first_part_, config_, config_digest_, shown_by_;
  std::vector<hd::RenderProduct> shown_;  // by that part
};

}  // namespace

int run_merge(const MergeArguments& arguments) {
  return MergeCommand(arguments).run();
}

}  // namespace alabaster::cli
