#include <optional>

#include "delegate/c_api/values.h"
#include "delegate/support/lookup.h"
#include "delegate/support/nearest_name.h"

namespace alabaster::hd::c_api {
namespace {

using support::number_in;

template <class Call>
AlabasterStatus on_delegate(AlabasterDelegate* handle, const Call& call) {
  return with_data(handle, "delegate", [&](DelegateData& data) {
    const HostLock lock(data);
    call(data);
  });
}

/// The same, and `tell` with what `call` returns, without the locks: callbacks of two threads may call the library.
template <class Call, class Tell>
AlabasterStatus on_delegate(AlabasterDelegate* handle, const Call& call, const Tell& tell) {
  return with_data(handle, "delegate", [&](DelegateData& data) {
    const auto answer = [&] {
      const HostLock lock(data);
      return call(data);
    }();
    tell(answer);
  });
}

/// For what any thread may do at any time.
template <class Call>
AlabasterStatus at_any_time(AlabasterDelegate* handle, const Call& call) {
  return guarded_at_any_time([&] {
    const std::shared_ptr<DelegateData> data = required(handle, "delegate").data;
    data->process.check("the delegate");
    call(*data->delegate);
  });
}

AlabasterProgress progress_of(const host::RecordProgress& from) {
  return {sizeof(AlabasterProgress), from.fraction, from.seconds, from.samples_done, from.samples_total};
}

std::vector<RenderProduct> products_of(const AlabasterRecordOptions& in) {
  std::vector<RenderProduct> products;
  const auto aovs = items(in.aovs, in.aov_count, "aovs");
  for (const char* file : items(in.files, in.file_count, "files")) {
    RenderProduct product;
    product.file = text_or(file, "");
    if (product.file.ends_with(".exr") && !aovs.empty()) {
      product.vars.push_back(host::UsualRenderVar("color"));
      for (const char* aov : aovs) product.vars.push_back(host::UsualRenderVar(text_or(aov, "")));
    }
    products.push_back(std::move(product));
  }
  return products;
}

/// A delegate records while this lives.
class RecordingScope {
 public:
  explicit RecordingScope(DelegateData& data) : data_(data) { data_.records = true; }
  ~RecordingScope() { data_.records = false; }
  RecordingScope(const RecordingScope&) = delete;
  RecordingScope& operator=(const RecordingScope&) = delete;

 private:
  DelegateData& data_;
};

std::optional<Failure> failure_of(host::RecordStatus status, Reports& reports) {
  switch (status) {
    case host::RecordStatus::input_failed:
      return Failure(ALABASTER_INPUT_FAILED, reports.take_error("the scene cannot be rendered"));
    case host::RecordStatus::render_failed:
      return Failure(ALABASTER_RENDER_FAILED, reports.take_error("the render failed"));
    case host::RecordStatus::output_failed:
      return Failure(ALABASTER_OUTPUT_FAILED, reports.take_error("a file could not be written"));
    case host::RecordStatus::interrupted:
      return Failure(ALABASTER_INTERRUPTED, "the render was cancelled or stopped");
    case host::RecordStatus::degraded:
      return Failure(ALABASTER_DEGRADED, "the picture lacks whatever the faults of the scene leave out");
    default:
      return std::nullopt;
  }
}

void check_settings(const Dictionary& settings) {
  for (const auto& [name, value] : settings) {
    if (name == "ocio" || name == "renderSettingsPrimPath") {  // of the delegate, not of the renderer
      if (!value.empty() && value.text_or("\1") == "\1") throw bad_argument("'" + name + "' must be a text");
      continue;
    }
    if (const std::string fault = host::CheckSetting(name, value); !fault.empty()) throw bad_argument(fault);
  }
}

AlabasterStatus delegate_create(const AlabasterDelegateOptions* given, AlabasterScene* scene, AlabasterDelegate** out) {
  return guarded([&] {
    ValueReader reader(given);
    auto& handle = required(out, "delegate");
    const auto in = given ? sized(given, "options") : AlabasterDelegateOptions{};
    auto data = std::make_shared<DelegateData>();
    data->reports = std::make_shared<Reports>(in.report, in.user);
    DelegateOptions options;
    options.settings = reader.dictionary({in.settings, in.setting_count}, "settings");
    check_settings(options.settings);
    options.diagnostics = sink_of(data->reports);
    reader.take();
    if (scene) scene->data->process.check("the scene");
    if (const auto ocio = options.settings.find("ocio"); ocio != options.settings.end())
      data->colors.ocio = ocio->second.text_or("");
    data->names_colors = !data->colors.ocio.empty();
    if (scene && !data->names_colors) {
      const SceneLock lock(*scene->data);
      const description::SceneFile& loaded = scene->data->loaded;
      data->colors.ocio = loaded.color_config, data->colors.within = loaded.color_config_within;
      if (!loaded.color_config.empty())
        options.settings["ocio"] = AssetPath{loaded.color_config, loaded.color_config, {}, loaded.color_config_within};
    }
    data->delegate = CreateAlabasterRenderDelegate(kAbiVersion, &options);
    if (!data->delegate) throw Failure(ALABASTER_INPUT_FAILED, data->reports->take_error("the renderer cannot start"));
    data->index = std::make_unique<host::RenderIndex>(data->delegate);
    if (scene) data->show(scene->data);
    handle = new AlabasterDelegate{std::move(data)};
  });
}

AlabasterStatus show(AlabasterDelegate* handle, AlabasterScene* scene) {
  return on_delegate(handle, [&](DelegateData& data) {
    refuse_while_recording(data, "show");
    data.show(scene ? scene->data : nullptr);
  });
}

void apply(DelegateData& data, const Dictionary& settings) {
  check_settings(settings);
  const HostLock lock(data);
  if (!data.delegate->SetRenderSettings(settings)) throw Failure(ALABASTER_OUT_OF_MEMORY, "memory ran out");
}

AlabasterStatus set_setting(AlabasterDelegate* handle, const char* key, const AlabasterValue* value) {
  return guarded([&] {
    ValueReader reader(value);
    const std::shared_ptr<DelegateData> data = required(handle, "delegate").data;
    const Dictionary read = {{&required(key, "key"), reader.value(required(value, "value"), key)}};
    reader.take();
    apply(*data, read);
  });
}

AlabasterStatus set_settings(AlabasterDelegate* handle, const AlabasterParameter* settings, size_t count) {
  return guarded([&] {
    const ParameterList given{settings, count};
    ValueReader reader(&given);
    const std::shared_ptr<DelegateData> data = required(handle, "delegate").data;
    const Dictionary read = reader.dictionary(given, "settings");
    reader.take();
    apply(*data, read);
  });
}

AlabasterStatus get_setting(AlabasterDelegate* handle, const char* key, AlabasterVisit visit, void* user) {
  const auto read = [&](DelegateData& data) {
    check_settings({{&required(key, "key"), Value()}});
    return data.delegate->GetRenderSetting(Token(key));
  };
  return on_delegate(handle, read, [&](const Value& value) { visit_value(key, value, visit, user); });
}

AlabasterStatus get_settings(AlabasterDelegate* handle, AlabasterVisitSetting visit, void* user) {
  const auto tell = [&](const std::vector<RenderSettingDescriptor>& settings) {
    for (const RenderSettingDescriptor& setting : settings) {
      const ValueView value(setting.defaultValue), minimum(setting.minimum), maximum(setting.maximum);
      std::vector<const char*> choices;
      for (const std::string& choice : setting.choices) choices.push_back(choice.c_str());
      const AlabasterSetting told = {sizeof(AlabasterSetting),
                                     setting.key.str().c_str(),
                                     setting.name.c_str(),
                                     setting.documentation.c_str(),
                                     value.get(),
                                     minimum.get(),
                                     maximum.get(),
                                     choices.data(),
                                     choices.size()};
      visit(user, &told);
    }
  };
  const auto read = [&](DelegateData& data) {
    if (!visit) throw bad_argument("visit is null");
    return data.delegate->GetRenderSettingDescriptors();
  };
  return on_delegate(handle, read, tell);
}

AlabasterStatus aov_format(AlabasterDelegate* handle, const char* aov, int32_t* format) {
  return on_delegate(handle, [&](DelegateData& data) {
    const Token name(&required(aov, "aov"));
    required(format, "format") = int32_t(data.delegate->GetDefaultAovDescriptor(name).format);
    if (*format == ALABASTER_FORMAT_NONE) fail(ALABASTER_NOT_FOUND, host::NoSuchAov(name.str()).c_str());
  });
}

AlabasterStatus stats(AlabasterDelegate* handle, AlabasterVisit visit, void* user) {
  return at_any_time(handle,
                     [&](RenderDelegate& delegate) { visit_dictionary(delegate.GetRenderStats(), visit, user); });
}

AlabasterStatus progress(AlabasterDelegate* handle, AlabasterProgress* out) {
  return at_any_time(handle, [&](RenderDelegate& delegate) {
    const Dictionary stats = delegate.GetRenderStats();
    answer(out,
           AlabasterProgress{0, number_in(stats, "fractionDone"), number_in(stats, "totalClockTime"),
                             uint64_t(number_in(stats, "numCompletedSamples")),
                             uint64_t(number_in(stats, "samplesTotal"))},
           "progress");
  });
}

AlabasterStatus status_of(CommandStatus status) {
  switch (status) {
    case CommandStatus::done:
      return ALABASTER_OK;
    case CommandStatus::unknown:
      return ALABASTER_NOT_FOUND;
    case CommandStatus::invalid:
      return ALABASTER_INVALID_ARGUMENT;
    case CommandStatus::failed:
      return ALABASTER_INPUT_FAILED;
    case CommandStatus::out_of_memory:
      return ALABASTER_OUT_OF_MEMORY;
  }
  return ALABASTER_INTERNAL;
}

AlabasterStatus command(AlabasterDelegate* handle, const char* name, const AlabasterParameter* arguments, size_t count,
                        AlabasterVisit visit, void* user) {
  return guarded([&] {
    const ParameterList given{arguments, count};
    ValueReader reader(&given);
    const std::shared_ptr<DelegateData> data = required(handle, "delegate").data;
    const Token command(&required(name, "name"));
    const Dictionary read = reader.dictionary(given, "arguments");
    reader.take();
    if (!visit) throw bad_argument("visit is null");
    const CommandResult result = [&] {
      const HostLock lock(*data);
      return data->delegate->InvokeCommand(command, read);
    }();
    if (!result.ok()) throw Failure(status_of(result.status), result.fault);
    visit_value(name, result.value, visit, user);
  });
}

template <void (RenderDelegate::*kControl)()>
AlabasterStatus control(AlabasterDelegate* handle) {
  return at_any_time(handle, [](RenderDelegate& delegate) { (delegate.*kControl)(); });
}

AlabasterStatus record(AlabasterDelegate* handle, const AlabasterRecordOptions* given, AlabasterVisit visit,
                       void* user) {
  struct Recorded {
    std::vector<std::string> files;
    std::optional<Failure> failure;
  };
  const auto record_files = [&](DelegateData& data) {
    const auto in = given ? sized(given, "options") : AlabasterRecordOptions{};
    refuse_while_recording(data, "record");
    if (!data.scene) throw bad_argument("the delegate draws no scene");
    tell_other_colors(data);
    tell_unmatched_instancers(data);
    const Path settings = settings_path(data.scene->scene, in.settings);
    if (settings.empty()) throw Failure(ALABASTER_NOT_FOUND, "the scene has no render settings");
    const RecordingScope scope(data);
    std::atomic<bool> cancel{false};
    host::RecordOptions options;
    options.products = products_of(in);
    options.colors = data.colors;
    options.keep_going = in.keep_going != 0;
    options.cancel = &cancel;
    options.diagnostics = sink_of(data.reports);
    if (in.progress)
      options.progress = [&](const host::RecordProgress& now) {
        const AlabasterProgress told = progress_of(now);
        if (in.progress(in.user, &told) == 0) cancel = true;
      };
    data.reports->take_error({});
    host::RecordResult result = host::RecordFrame(data.index.get(), &data.scene->scene, settings, options);
    return Recorded{std::move(result.written), failure_of(result.status, *data.reports)};
  };
  return on_delegate(handle, record_files, [&](const Recorded& recorded) {
    if (visit)
      for (const std::string& file : recorded.files) visit_value("file", file, visit, user);
    if (recorded.failure) throw *recorded.failure;
  });
}

}  // namespace

void tell_other_colors(DelegateData& data) {
  const std::string& config = data.scene->loaded.color_config;
  if (data.names_colors || config == data.colors.ocio || config.empty() || config == data.told_colors) return;
  data.told_colors = config;
  const std::string own = data.colors.ocio.empty() ? "$OCIO or the built-in one" : "'" + data.colors.ocio + "'";
  sink_of(data.reports)({Severity::warning, "scene.ocio", config,
                         "the scene names this OpenColorIO configuration, but was loaded after the renderer was made "
                         "with " +
                             own +
                             ", which counts; make the renderer after the scene is loaded, or name the "
                             "configuration in its setting ocio"});
}

namespace {

using host::InstancerDescription;
using host::MeshDescription;

/// The instancer of a mesh, or the one that an instancer stands in.
const Path* instancer_of(const host::Prims& prims, const Path& id) {
  if (const auto* mesh = host::FindPrim<MeshDescription>(prims, id)) return &mesh->instancer;
  const auto* inner = host::FindPrim<InstancerDescription>(prims, id);
  return inner ? &inner->parent : nullptr;
}

/// What is wrong with the first prototype that does not name the instancer; "" if none is.
std::string fault_of_prototypes(const host::Prims& prims, const Path& id, const InstancerDescription& instancer) {
  for (const auto& [prototype, indices] : instancer.indices) {
    const Path* named = instancer_of(prims, prototype);
    if (indices.empty() || (named && *named == id)) continue;
    const std::string text = "prototypes:" + prototype.str() + ": ";
    if (named)
      return text + "it does not name this instancer (its field '" +
             (host::FindPrim<MeshDescription>(prims, prototype) ? "instancer" : "parent") +
             "'); its instances are not drawn";
    std::vector<std::string> those_that_name_it, others;
    for (const auto& prim : prims)
      if (const Path* other = instancer_of(prims, prim.first))
        (*other == id ? those_that_name_it : others).push_back(prim.first.str());
    return text + "there is no mesh or instancer of that path; its instances are not drawn" +
           support::DidYouMean(prototype.str(), those_that_name_it, support::DidYouMean(prototype.str(), others));
  }
  return {};
}

}  // namespace

void tell_unmatched_instancers(DelegateData& data) {
  const std::set<Path> changed = std::exchange(data.scene->unmatched, {});
  if (changed.empty()) return;
  const host::Prims& prims = data.scene->scene.GetPrims();
  std::set<Path>& told = data.scene->told_instancers;
  const auto tell = [&](const Path& instancer, const std::string& fault) {
    if (told.insert(instancer).second)
      sink_of(data.reports)({Severity::warning, "instancer.prototype", instancer.str(), fault});
  };
  for (const Path& id : changed) {
    const auto* instancer = host::FindPrim<InstancerDescription>(prims, id);
    if (!instancer) continue;
    const std::string fault = fault_of_prototypes(prims, id, *instancer);
    if (fault.empty())
      told.erase(id);
    else
      tell(id, fault);
  }
  for (const Path& id : changed) {
    const Path* named = instancer_of(prims, id);
    const auto* instancer = named ? host::FindPrim<InstancerDescription>(prims, *named) : nullptr;
    if (instancer && !instancer->indices.contains(id))
      tell(*named, id.str() + " names this instancer, which has no prototypes:" + id.str() + "; it is not drawn");
  }
}

void add_delegate_functions(AlabasterApi* api) {
  api->delegate_create = delegate_create;
  api->delegate_destroy = destroy_handle;
  api->show = show;
  api->set_setting = set_setting;
  api->set_settings = set_settings;
  api->get_setting = get_setting;
  api->get_settings = get_settings;
  api->aov_format = aov_format;
  api->stats = stats;
  api->progress = progress;
  api->command = command;
  api->stop = control<&RenderDelegate::Stop>;
  api->restart = control<&RenderDelegate::Restart>;
  api->pause = control<&RenderDelegate::Pause>;
  api->resume = control<&RenderDelegate::Resume>;
  api->record = record;
}

}  // namespace alabaster::hd::c_api
