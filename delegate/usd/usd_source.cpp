#include "delegate/usd/usd_source.h"

#include <algorithm>
#include <filesystem>

#include "core/files/real_path.h"
#include "delegate/archive/archive.h"
#include "delegate/host/product_writer.h"
#include "delegate/support/extension.h"
#include "delegate/support/process_usage.h"
#include "delegate/usd/usd_child.h"

namespace alabaster::hd::usd {
namespace {

using nlohmann::json;

/// The address space of a process that holds OpenUSD and nothing of a stage.
constexpr size_t kOpenUsdBytes = size_t(4) << 30;

class StageSource : public host::SceneSource {
 public:
  host::SourceFault Open(const std::string& file, const host::SourceOptions& options,
                         const DiagnosticSink& sink) override {
    return guarded(sink, [&] { open(file, options, sink); });
  }
  const host::SceneFacts& Facts() const override { return facts_; }
  host::SourceFault Pose(std::optional<double> time, const DiagnosticSink& sink, host::SceneEdits* edits) override {
    return guarded(sink, [&] { pose(time, sink, edits); });
  }

 private:
  template <class Work>
  host::SourceFault guarded(const DiagnosticSink& sink, const Work& work) {
    const auto fail = [&](const std::string& where, const std::string& text) {
      if (sink) sink({Severity::error, "usd", where.empty() ? file_ : where, text});
      return host::SourceFault::input;
    };
    try {
      work();
      return fault_;
    } catch (const Fault& fault) {
      fail(fault.where, fault.what());
      return fault.out_of_memory ? host::SourceFault::out_of_memory : host::SourceFault::input;
    } catch (const std::bad_alloc&) {
      fail({}, "Not enough memory to read the stage.");
      return host::SourceFault::out_of_memory;
    } catch (const std::exception& e) {
      return fail({}, std::string("It could not be read: ") + e.what());
    }
  }

  void open(const std::string& file, const host::SourceOptions& options, const DiagnosticSink& sink) {
    file_ = file, options_ = options;
    const host::StageOptions& stage = options.stage;
    for (const auto* choice : {&options.scene, &options.animation})
      if (!choice->empty())
        throw Fault("A stage has no scenes and animations of which '" + *choice + "' could be chosen: leave it out.");
    const std::string real = real_path(file);
    if (!options.within.empty() && !is_within(real, options.within)) throw Fault(outside_text(real));
    const std::string folder = std::filesystem::path(real).parent_path().string();
    memory_ = options.memory_limit ? options.memory_limit : support::default_memory_limit();
    ChildOptions child;
    child.folders = {allowed_folder(folder)};
    for (const auto* more : {&stage.search_paths, &stage.allowed_folders})
      for (const std::string& one : *more) {
        if (!std::filesystem::is_directory(one)) throw Fault("There is no folder '" + one + "' that it could use.");
        child.folders.push_back(allowed_folder(one));
      }
    if (!stage.session_layer.empty())
      child.folders.push_back(std::filesystem::path(real_path(stage.session_layer)).parent_path().string());
    child.everywhere = options.allow_outside;
    child.memory = memory_ + kOpenUsdBytes;
    if (stage.seconds > 0) child.seconds = stage.seconds;
    std::vector<std::string> search;
    for (const std::string& one : stage.search_paths) search.push_back(real_path(one));
    folders_ = child.folders;
    child_ = std::make_unique<Child>(child);
    if (child_->about().value("landlock", json()).is_null() && sink)
      sink({Severity::info, "usd.landlock", file_,
            "This kernel has no Landlock: files outside of the stage's folder are refused after they were opened."});
    const json& version = child_->about()["usd"];
    facts_.libraries["OpenUSD"] = std::to_string(version[1].get<int>()) + "." + std::to_string(version[2].get<int>());
    if (const json& mtlx = child_->about()["mtlx"]; mtlx.is_string())
      facts_.libraries["MaterialX"] = mtlx.get<std::string>();
    const Child::Answer opened =
        child_->ask({{"do", "open"},
                     {"file", real},
                     {"session", stage.session_layer.empty() ? "" : real_path(stage.session_layer)},
                     {"mask", stage.mask},
                     {"variants", options.variant},
                     {"search", search}});
    const json about = json::parse(contents(opened.file));
    facts_.files = about["layers"].get<std::vector<std::string>>();
    facts_.up = Token(about["up"].get<std::string>());
    facts_.metersPerUnit = about["metersPerUnit"].get<double>();
    facts_.timeCodesPerSecond = about["timeCodesPerSecond"].get<double>();
    facts_.varies = about["varies"].get<bool>();
    if (!about["range"].is_null()) facts_.range = {about["range"][0].get<double>(), about["range"][1].get<double>()};
    take_faults(about["faults"], sink);
  }

  // Faults of composition are those of missing images: the picture would lack something that the stage names.
  void take_faults(const json& faults, const DiagnosticSink& sink) {
    constexpr size_t kMost = 50;
    for (size_t i = 0; i < faults.size(); ++i) {
      const Fault fault = fault_of(faults[i]);
      std::string said = fault.where + ": " + fault.what();
      if (std::find(facts_.faults.begin(), facts_.faults.end(), said) != facts_.faults.end()) continue;
      if (i < kMost && sink) sink({Severity::error, "usd.composition", fault.where, fault.what()});
      facts_.faults.push_back(std::move(said));
    }
    if (!facts_.faults.empty() && !options_.keep_going) fault_ = host::SourceFault::input;
  }

  // The first pose is the scene; each later one is what differs from the one before.
  void pose(std::optional<double> time, const DiagnosticSink& sink, host::SceneEdits* edits) {
    if (is_posed_ && !facts_.varies) return;
    json at = nullptr;
    if (time) at = *time;
    if (!time && options_.stage.at_default_time) at = "default";
    const Child::Answer answer = child_->ask(is_posed_ ? json{{"do", "time"}, {"time", at}} : scene_request(at));
    take_faults(answer.text["faults"], sink);
    for (const json& warning : answer.text["warnings"]) warn(warning, sink);
    archive::ReadOptions read;
    read.allow_outside = options_.allow_outside;
    read.folders = folders_;
    read.memory_limit = memory_;
    read.is_answer = is_posed_;
    const archive::ReadResult result = archive::ReadSealedArchive(answer.file.get(), file_, edits, sink, read);
    if (!result.ok) {
      fault_ = result.out_of_memory ? host::SourceFault::out_of_memory : host::SourceFault::input;
      return;
    }
    drop_unknown_light_paths(edits, sink);
    if (!is_posed_) facts_.settings = result.info.settings, facts_.memory_bytes = result.memory_bytes;
    is_posed_ = true;
  }

  // Expressions of other renderers' settings are no fault of the stage.
  void drop_unknown_light_paths(host::SceneEdits* edits, const DiagnosticSink& sink) const {
    for (auto& [path, prim] : edits->prims) {
      auto* const settings = std::get_if<RenderSettingsDescription>(&prim);
      if (!settings) continue;
      for (RenderProduct& product : settings->products)
        std::erase_if(product.vars, [&, where = path.str()](const RenderVar& var) {
          const std::string fault = host::LightPathsFault(var);
          if (!fault.empty() && sink)
            sink({Severity::warning, "usd.unread", file_ + ": " + where,
                  "layer " + var.name + " is not written: " + fault});
          return !fault.empty();
        });
    }
  }

  json scene_request(const json& at) const {
    const host::StageOptions& stage = options_.stage;
    json request = {{"do", "scene"}, {"time", at}, {"refine", options_.refine_level}, {"aovs", host::ProductAovs()}};
    if (!stage.settings.empty()) request["settings"] = stage.settings;
    if (!stage.pass.empty()) request["pass"] = stage.pass;
    if (!stage.camera.empty()) request["camera"] = stage.camera;
    if (support::lower_extension(file_) == ".mtlx") request["library"] = true;
    if (stage.hides_domes) request["hides_domes"] = true;
    if (stage.recorded_width) request["record"] = true, request["width"] = *stage.recorded_width;
    if (stage.shutter) request["shutter"] = *stage.shutter;
    if (stage.next_frame) request["next_frame"] = *stage.next_frame;
    if (!stage.purposes.empty()) request["purposes"] = stage.purposes;
    return request;
  }

  void warn(const json& warning, const DiagnosticSink& sink) {
    const size_t count = warning[1].get<size_t>();
    const auto text = warning[0].get<std::string>();
    const std::string said = text + (count > 1 ? " (" + std::to_string(count) + " times; this is the first)" : "");
    facts_.unread.push_back(warning[2].get<std::string>() + ": " + said);
    if (sink) sink({Severity::warning, "usd.unread", file_ + ": " + warning[2].get<std::string>(), said});
  }

  std::string file_;
  host::SourceOptions options_;
  host::SceneFacts facts_;
  host::SourceFault fault_ = host::SourceFault::none;
  std::vector<std::string> folders_;
  size_t memory_ = 0;
  std::unique_ptr<Child> child_;
  bool is_posed_ = false;
};

}  // namespace

std::unique_ptr<host::SceneSource> MakeStageSource() {
  return std::make_unique<StageSource>();
}

bool is_stage(const std::string& extension) {
  return extension == ".usd" || extension == ".usda" || extension == ".usdc" || extension == ".usdz";
}

}  // namespace alabaster::hd::usd
