#include <cmath>
#include <filesystem>

#include "core/files/input_file.h"
#include "delegate/cli/commands.h"
#include "delegate/cli/exit_codes.h"
#include "delegate/cli/interrupt.h"
#include "delegate/cli/shell_word.h"
#include "delegate/support/size_text.h"
#include "delegate/tradeoff/name_pattern.h"
#include "delegate/tradeoff/report.h"
#include "delegate/tradeoff/study.h"

namespace alabaster::cli {
namespace {

namespace fs = std::filesystem;
using tradeoff::StudyOutcome;

template <class T>
std::string array_checksum(const hd::Array<T>& array) {
  return tradeoff::checksum(array.data(), array.size() * sizeof(T));
}

/// The checksum of an image's bytes, in memory or in a file. An image that cannot be read, which Sync has reported,
/// counts as empty.
std::string image_checksum(const hd::AssetPath& image) {
  if (image.bytes) return tradeoff::checksum(image.bytes->data(), image.bytes->size());
  const InputFile file(image.resolved, image.within);
  std::string bytes;
  if (!file || !file.read(&bytes)) bytes.clear();
  return tradeoff::checksum(bytes.data(), bytes.size());
}

std::string image_checksums(const std::map<hd::Token, hd::Value>& parameters) {
  std::string text;
  for (const auto& [name, value] : parameters)
    if (const auto* image = value.get<hd::AssetPath>()) text += " " + image_checksum(*image);
  return text;
}

/// A checksum of the scene's content, whichever file it came from: the renderer's dump of it, the shapes, and the
/// images of textures and lights. It does not cover the values of normals and UVs, creases, the wrapping and colour
/// space of textures, or the OCIO config.
std::string scene_hash(const SceneSession& session) {
  std::string text = session.delegate()->InvokeCommand("dumpScene", {}).value.text_or("");
  for (const auto& [path, light] : session.scene.GetLights()) text += image_checksums(light.parameters) + "\n";
  for (const auto& [path, network] : session.scene.GetMaterials())
    for (const auto& [node_path, node] : network.nodes) text += image_checksums(node.parameters) + "\n";
  for (const auto& [path, mesh] : session.scene.GetMeshes()) {
    text += path.str() + " " + array_checksum(mesh.topology.faceVertexIndices);
    if (const auto points = mesh.primvars.find("points"); points != mesh.primvars.end())
      if (const auto* held = points->second.value.get<hd::Array<hd::Vec3f>>()) text += " " + array_checksum(*held);
    text += "\n";
  }
  return tradeoff::checksum(text.data(), text.size());
}

class TradeoffCommand {
 public:
  explicit TradeoffCommand(const TradeoffArguments& arguments) : a_(arguments), console_(arguments.quiet) {}

  int run() {
    catch_interrupts();
    check_arguments();
    load();
    open_store();
    choose_identity();
    std::string problem;
    const StudyOutcome outcome = run_study(list_, budget_, &store_, hooks(), &problem);
    if (outcome == StudyOutcome::output_failed) console_.error("tradeoff", problem);
    const int code = outcome == StudyOutcome::finished        ? kDone
                     : outcome == StudyOutcome::cancelled     ? kInterrupted
                     : outcome == StudyOutcome::output_failed ? kOutput
                                                              : kRender;
    const int reported = report(outcome);
    return code == kDone ? reported : code;
  }

 private:
  void check_arguments() {
    console_.require_usage("--only", tradeoff::NamePattern(a_.only).fault());
    folder_ = a_.folder.empty() ? fs::path(a_.scene).stem().string() + "_tradeoff" : a_.folder;
  }

  void open_store() {
    std::vector<std::string> reports;
    for (const char* name :
         {"tradeoff.csv", "tradeoff.json", "tradeoff.md", "tradeoff.svg", "tradeoff.png", "pictures.png"})
      reports.push_back((folder_ / name).string());
    console_.require_usage("-o", input_overwritten(reports, session_, a_.scene));
    const std::string problem = store_.open(folder_ / "state", a_.restart);
    for (const std::string& note : store_.notes()) console_.note("note: " + note);
    console_.require(kOutput, folder_.string(), problem);
  }

  void load() {
    open_scene(a_, scene_load_options(a_), console_, console_.sink(), &session_);
    choose_display();
    if (!tradeoff::to_display({1, 1, {0, 0, 0}}, display_, session_.colors(), console_.sink())) throw Exit{kInput};
    session_.start(console_.sink());
    if (!session_.index()->SyncAll())
      console_.fail(kRender, a_.scene, "The scene could not be prepared: not enough memory or threads.");
    require(session_.fault_code());
    const auto& settings = session_.scene.GetAllRenderSettings().at(session_.file.settings);
    scene_size_ = {settings.width, settings.height};
    const auto configurations = [&](const std::string& only) {
      return tradeoff::make_configurations(tradeoff::traits_of(session_.scene, session_.delegate()), settings.settings,
                                           session_.delegate()->GetRenderSettingDescriptors(), only);
    };
    list_ = configurations(a_.only);
    for (const std::string& line : list_.skipped) console_.note("skipped: " + line);
    const tradeoff::NamePattern only(a_.only);
    if (list_.measured.size() == 1 && !only.matches(list_.measured.front().name)) {
      std::string known;
      for (const auto& configuration : configurations(".").measured)
        known += (known.empty() ? "" : ", ") + configuration.name;
      console_.usage_error("--only", "'" + a_.only + "' matches none of this scene's configurations: " + known + ".");
    }
    if (settings.crop) console_.note("note: the scene's crop is ignored: the whole frame is measured");
    renderer_.emplace(tradeoff::SceneRenderer::Scene{&session_.scene, session_.index(), session_.file.settings,
                                                     &interrupted(), console_.sink()});
  }

  /// Takes the display and view of the first product that has one; else the config's default.
  void choose_display() {
    const auto& all = session_.scene.GetAllRenderSettings();
    std::vector<hd::Path> paths{session_.file.settings};
    paths.insert(paths.end(), session_.file.further_settings.begin(), session_.file.further_settings.end());
    for (const hd::Path& path : paths)
      for (const hd::RenderProduct& product : all.at(path).products)
        if (fs::path(product.file).extension() != ".exr" && product.colorSpace.empty()) {
          display_ = product;
          return;
        }
  }

  void choose_identity() {
    tradeoff::StudyIdentity identity{a_.scene, scene_hash(session_), 0, 0, AlabasterVersions()};
    const auto& asked = a_.size;
    if (!store_.empty()) {
      const tradeoff::StudyIdentity& stored = store_.identity;
      const std::string remedy = ": start afresh with --restart, or choose another folder with -o DIR.";
      if (stored.versions != identity.versions)
        console_.usage_error(
            folder_.string(),
            "The folder holds a study made with another version of Alabaster or of its libraries" + remedy);
      if (stored.scene_hash != identity.scene_hash)
        console_.usage_error(
            folder_.string(),
            "The folder holds a study of another scene, or of an earlier version of " + stored.scene + remedy);
      if (asked && (asked->x != stored.width || asked->y != stored.height))
        console_.usage_error(
            "--size", "The folder holds a study at " + hd::support::size_option(stored.width, stored.height) + remedy);
      console_.note("resuming with " + std::to_string(store_.renders().size()) + " renders from an earlier run");
      identity.width = stored.width;
      identity.height = stored.height;
      set_worth_saving(true);
    } else {
      const auto size = asked ? asked : affordable();
      if (!size) throw Exit{interrupted() ? kInterrupted : kRender};
      identity.width = size->x;
      identity.height = size->y;
    }
    store_.identity = identity;
    renderer_->set_size(identity.width, identity.height);
  }

  /// The largest size that the budget allows, by a quick render of the base that measures the cost of a pixel.
  std::optional<hd::Vec2i> affordable() {
    constexpr uint64_t kSamples = 4;
    constexpr double kProbePixels = 96 * 96;
    const double shrink = std::min(1.0, std::sqrt(kProbePixels / (double(scene_size_.x) * double(scene_size_.y))));
    const hd::Vec2i size(std::max(1, int(scene_size_.x * shrink)), std::max(1, int(scene_size_.y * shrink)));
    renderer_->set_size(size.x, size.y);
    const auto frame = renderer_->render(list_.measured.front(), kSamples, 0);
    if (!frame) return std::nullopt;
    const double seconds = frame->cost.wall_seconds / (double(kSamples) * size.x * size.y);
    const hd::Vec2i chosen = tradeoff::affordable_size(scene_size_, seconds, list_.measured.size(), budget_);
    if (chosen != scene_size_)
      console_.note("measuring at " + hd::support::size_option(chosen.x, chosen.y) + " instead of " +
                    hd::support::size_option(scene_size_.x, scene_size_.y) +
                    " to fit the budget; --size overrides this");
    return chosen;
  }

  tradeoff::StudyHooks hooks() {
    tradeoff::StudyHooks hooks;
    hooks.render = [this](const tradeoff::Configuration& configuration, uint64_t samples, uint32_t seed) {
      const bool denoise = a_.denoise && configuration.name != list_.reference.name;
      auto frame = renderer_->render(configuration, samples, seed, denoise);
      set_writing(true);  // the picture is about to be stored
      return frame;
    };
    hooks.cancelled = [] { return interrupted().load(); };
    hooks.note = [this](const std::string& text) { console_.note(text); };
    hooks.stored = [] {
      set_worth_saving(true);
      set_writing(false);
    };
    hooks.progress = [this](const tradeoff::StudyProgress& p) {
      const auto samples = static_cast<unsigned long long>(p.job.samples);
      const auto left = static_cast<long>(std::lround(p.seconds_left));
      const char* const name = p.configuration.c_str();
      console_.note(p.total == 0 ? formatted("[%zu] %s, 1 sample, to measure its cost", p.number, name)
                                 : formatted("[%zu/%zu] %s, %llu samples; %ld:%02ld left", p.number, p.total, name,
                                             samples, left / 60, left % 60));
    };
    return hooks;
  }

  int report(StudyOutcome outcome) {
    // All pictures are safe and nothing is being written: a signal may end the program.
    set_worth_saving(false);
    set_writing(false);
    console_.note("analysing " + std::to_string(store_.renders().size()) + " renders");
    const tradeoff::DisplayFunction display = [this](const tradeoff::Image& image) {
      return tradeoff::to_display(image, display_, session_.colors(), console_.sink());
    };
    std::string problem;
    const auto result = analyse(store_, list_, display, &problem);
    if (!result) {
      if (outcome == StudyOutcome::finished)
        console_.error(a_.scene, problem);
      else
        console_.note("nothing to report yet; run the same command again to resume");
      return kInput;
    }
    if (result->rows.empty()) return nothing_measured(outcome);
    const tradeoff::ReportContext context{command_line(),
                                          render_command(),
                                          store_.identity,
                                          scene_size_.x,
                                          scene_size_.y,
                                          store_.spent,
                                          outcome == StudyOutcome::finished};
    std::vector<std::string> problems;
    set_writing(true);
    for (const std::string& file : write_report(*result, list_, context, folder_, &problems))
      console_.note("wrote " + file);
    for (const std::string& text : problems) console_.error("tradeoff", text);
    if (outcome == StudyOutcome::cancelled) console_.note("interrupted; run the same command again to resume");
    return problems.empty() ? kDone : kOutput;
  }

  /// Reports a study that has a reference, but no two replicas of any other configuration.
  int nothing_measured(StudyOutcome outcome) {
    const double minutes = 1.2 * tradeoff::least_budget(list_, store_) / 60;
    const std::string problem = "The budget was too short to render anything but the reference twice. Give it " +
                                formatted(minutes < 10 ? "%.2g" : "%.0f", minutes) +
                                " minutes or more; the renders so far are kept.";
    if (outcome == StudyOutcome::finished) console_.usage_error("--budget", problem);
    console_.note("nothing to report yet; run the same command again to resume");
    return kInput;
  }

  /// The command for the frame that the study is about, to which flags are added.
  std::string render_command() const {
    std::string text = "alabaster render " + shell_path(a_.scene) + " -o frame.exr";
    for (const std::string& entry : a_.overrides) text += " " + shell_word("--set=" + entry);
    return text;
  }

  std::string command_line() const {
    std::string text = "alabaster tradeoff " + shell_path(a_.scene);
    for (const std::string& word : a_.options) text += " " + shell_word(word);
    return text;
  }

  const TradeoffArguments& a_;
  Console console_;
  SceneSession session_;
  fs::path folder_;
  const double budget_ = 60 * a_.budget;  // seconds
  tradeoff::StudyStore store_;
  tradeoff::ConfigurationList list_;
  std::optional<tradeoff::SceneRenderer> renderer_;
  hd::Vec2i scene_size_{0, 0};
  hd::RenderProduct display_;
};

}  // namespace

int run_tradeoff(const TradeoffArguments& arguments) {
  return TradeoffCommand(arguments).run();
}

}  // namespace alabaster::cli
