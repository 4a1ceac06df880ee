#include <limits>

#include "delegate/archive/archive.h"
#include "delegate/c_api/values.h"
#include "delegate/host/picker.h"
#include "delegate/host/snapshot.h"
#include "delegate/support/lookup.h"
#include "delegate/support/size_text.h"

namespace alabaster::hd::c_api {
namespace {

struct Mapping {
  std::shared_ptr<BufferData> buffer;
};

/// Resolves and maps, with the size that belongs to the pixels. The data is null if nothing is allocated.
AlabasterPixels map_pixels(BufferData& data) {
  data.owner->process.check("the buffer");
  const std::lock_guard lock(data.mutex);
  data.buffer->Resolve();
  AlabasterPixels pixels{};
  pixels.data = data.buffer->Map();
  pixels.width = data.buffer->GetWidth();
  pixels.height = data.buffer->GetHeight();
  pixels.format = int32_t(data.buffer->GetFormat());
  pixels.generation = data.buffer->GetGeneration();
  return pixels;
}

void allocate(BufferData& data, int32_t width, int32_t height, int32_t format) {
  if (format <= ALABASTER_FORMAT_NONE || format > ALABASTER_INT32)
    throw bad_argument("there is no format " + std::to_string(format));
  const Vec2i size(width, height);
  if (width < 1 || height < 1 || !data.buffer->Allocate({{width, height, 1}, Format(format)}))
    throw bad_argument("a buffer of " + support::size_text(width, height) + " pixels cannot be allocated");
  data.size = size;
}

/// The framing of `in`. Members that are null or 0 are those of the scene's render settings, whose path it returns.
Path frame_pass(const AlabasterFrame& in, const host::RetainedSceneDelegate& scene, RenderPassState& state) {
  Path path = settings_path(scene, in.settings);
  const auto settings = path.empty() ? RenderSettingsDescription() : scene.GetAllRenderSettings().at(path);
  if (in.width < 0 || in.height < 0)
    throw bad_argument("a frame of " + support::size_text(in.width, in.height) +
                       " pixels: width and height must be at least 1, or 0 for those of the render settings");
  const int width = in.width > 0 ? in.width : settings.width, height = in.height > 0 ? in.height : settings.height;
  Rect2i window = {in.window.min_x, in.window.min_y, in.window.max_x, in.window.max_y};
  if (window.empty()) window = in.width > 0 || in.height > 0 ? Rect2i{0, 0, width, height} : settings.window();
  constexpr int kReach = 1 << 20;  // pixels from the origin; the differences of edges are whole numbers then
  for (const int edge : {window.minX, window.minY, window.maxX, window.maxY})
    if (edge < -kReach || edge > kReach) throw bad_argument("the window exceeds 2^20 pixels");
  // Buffers are as large as the window; the display window is moved so that it starts at their corner.
  const Vec2f corner(float(window.minX), float(window.minY));
  state.camera = in.camera ? Path(in.camera) : settings.camera;
  state.framing.displayMin = -corner;
  state.framing.displayMax = Vec2f(float(width), float(height)) - corner;
  state.framing.dataWindow = {0, 0, window.width(), window.height()};
  state.framing.pixelAspectRatio = in.pixel_aspect > 0 ? float(in.pixel_aspect) : settings.pixelAspectRatio;
  if (in.window_policy < ALABASTER_MATCH_VERTICALLY || in.window_policy > ALABASTER_DONT_CONFORM)
    throw bad_argument("there is no window policy " + std::to_string(in.window_policy));
  state.windowPolicy = in.window_policy != 0 ? WindowPolicy(in.window_policy) : settings.windowPolicy;
  return path;
}

std::vector<Path> paths_of(const std::vector<Token>& names) {
  std::vector<Path> paths;
  for (const Token& name : names) paths.emplace_back(name.str());
  return paths;
}

void select(const AlabasterFrame& in, ValueReader& reader, RenderPassState& state) {
  if (in.free_camera_count > 0) {
    const host::Fields fields = reader.fields({in.free_camera, in.free_camera_count});
    const std::string fault = host::ReadCamera(fields, &state.freeCamera.emplace());
    if (!fault.empty()) throw bad_argument("free_camera: " + fault);
  }
  std::vector<Token> tags = reader.tokens(in.render_tags, "render_tags");
  if (in.render_tags.type != ALABASTER_NONE) state.renderTags = std::move(tags);
  state.collection = {paths_of(reader.tokens(in.roots, "roots")), paths_of(reader.tokens(in.excluded, "excluded"))};
}

void check_sizes(const RenderPassState& state, const std::vector<std::shared_ptr<BufferData>>& bound) {
  const Vec2i window(state.framing.dataWindow.width(), state.framing.dataWindow.height());
  for (size_t i = 0; i < bound.size(); ++i)
    if (bound[i]->size != window)
      throw bad_argument("the buffer of AOV '" + state.aovBindings[i].aovName.str() + "' has " +
                         support::size_text(bound[i]->size.x, bound[i]->size.y) + " pixels, but the frame has " +
                         support::size_text(window.x, window.y) +
                         ": buffer_resize it, or change the frame's width, height or window (frame_size)");
}

void start(PassData& pass, const AlabasterFrame& in, RenderPassState state) {
  DelegateData& owner = *pass.owner;
  refuse_while_recording(owner, "pass_start");
  if (!owner.scene) throw bad_argument("the delegate draws no scene");
  tell_other_colors(owner);
  tell_unmatched_instancers(owner);
  std::vector<std::shared_ptr<BufferData>> bound;
  for (const AlabasterBinding& binding : items(in.bindings, in.binding_count, "bindings")) {
    const std::string aov = text_or(binding.aov, "");
    if (!binding.buffer) throw bad_argument("the buffer of AOV '" + aov + "' is null");
    bound.push_back(binding.buffer->data);
    if (bound.back()->owner != pass.owner)
      throw bad_argument("the buffer of AOV '" + aov + "' belongs to another delegate");
    state.aovBindings.push_back({aov, bound.back()->buffer, {}});
  }
  const Path settings = frame_pass(in, owner.scene->scene, state);
  check_sizes(state, bound);
  if (!settings.empty()) owner.delegate->SetRenderSetting("renderSettingsPrimPath", settings);
  if (!owner.index->SyncAll())
    throw Failure(ALABASTER_OUT_OF_MEMORY, "the scene could not be synced: memory or threads ran out");
  pass.pass->Execute(state);
  pass.bound = std::move(bound);
  pass.state = std::move(state);
}

AlabasterStatus pass_create(AlabasterDelegate* handle, AlabasterPass** out) {
  return guarded([&] {
    auto& made = required(out, "pass");
    auto data = std::make_shared<PassData>();
    data->owner = required(handle, "delegate").data;
    const HostLock lock(*data->owner);
    data->pass = data->owner->delegate->CreateRenderPass();
    if (!data->pass) throw Failure(ALABASTER_OUT_OF_MEMORY, data->owner->reports->take_error("no pass can be made"));
    made = new AlabasterPass{std::move(data)};
  });
}

AlabasterStatus pass_start(AlabasterPass* handle, const AlabasterFrame* frame) {
  return guarded([&] {
    ValueReader reader(frame);
    const std::shared_ptr<PassData> data = required(handle, "pass").data;
    const auto in = sized(frame, "frame");
    RenderPassState state;
    select(in, reader, state);
    reader.take();
    const HostLock lock(*data->owner);
    start(*data, in, std::move(state));
  });
}

AlabasterStatus pass_wait(AlabasterPass* handle, double seconds, int32_t* over) {
  return guarded_at_any_time([&] {
    const std::shared_ptr<PassData> data = required(handle, "pass").data;
    data->owner->process.check("the pass");
    const bool ended = data->pass->WaitForConvergence(seconds < 0 ? std::numeric_limits<double>::infinity() : seconds);
    if (over) *over = ended;
    if (!ended || data->pass->GetState() != PassState::failed) return;
    const Dictionary stats = data->owner->delegate->GetRenderStats();
    const Value* error = support::find_in(stats, "error");
    throw Failure(ALABASTER_RENDER_FAILED, error ? error->text_or("") : "the render failed");
  });
}

AlabasterStatus pass_state(AlabasterPass* handle, int32_t* state) {
  return guarded_at_any_time([&] {
    const std::shared_ptr<PassData> data = required(handle, "pass").data;
    data->owner->process.check("the pass");
    RenderPass& pass = *data->pass;
    PassState now = pass.GetState();
    // The contract latches convergence at Execute; here the end of the render is enough.
    if (now == PassState::rendering && pass.WaitForConvergence(0) && pass.GetState() == now) now = PassState::converged;
    required(state, "state") = int32_t(now);
  });
}

AlabasterStatus frame_size(AlabasterDelegate* handle, const AlabasterFrame* frame, int32_t* width, int32_t* height) {
  return guarded([&] {
    ValueReader reader(frame);
    const std::shared_ptr<DelegateData> held = required(handle, "delegate").data;
    DelegateData& data = *held;
    const auto in = sized(frame, "frame");
    RenderPassState state;
    select(in, reader, state);
    reader.take();
    const HostLock lock(data);
    if (!data.scene) throw bad_argument("the delegate draws no scene");
    frame_pass(in, data.scene->scene, state);
    required(width, "width") = state.framing.dataWindow.width();
    required(height, "height") = state.framing.dataWindow.height();
  });
}

AlabasterStatus scene_write(AlabasterScene* handle, const char* file, const AlabasterFrame* frame,
                            const AlabasterParameter* parameters, size_t count) {
  return guarded([&] {
    const ParameterList given{parameters, count};
    ValueReader settings_reader(&given), reader(frame);
    const std::shared_ptr<SceneData> held = required(handle, "scene").data;
    SceneData& data = *held;
    std::map<Token, Value> settings;
    for (const auto& [name, value] : settings_reader.fields(given)) settings[Token(name)] = value;
    AlabasterFrame in{};
    RenderPassState state;
    if (frame) in = sized(frame, "frame"), select(in, reader, state);
    settings_reader.take();
    reader.take();
    const SceneLock lock(data);
    if (const Path path = frame_pass(in, data.scene, state); !path.empty()) {
      const RenderSettingsDescription& own = data.scene.GetAllRenderSettings().at(path);
      for (const auto& [name, value] : own.settings) settings.emplace(name, value);
      if (own.frame != 0) settings.emplace("frame", own.frame);  // where the settings name none, as in a render
      settings.emplace("renderSettingsPrimPath", path);          // its camera, where the frame has none
    }
    if (!data.loaded.color_config.empty()) settings.emplace("ocio", data.loaded.color_config);
    archive::SceneInfo info = data.loaded.info;
    info.settings = {}, info.color_config = {}, info.names = data.scene.GetNames();
    const std::string fault =
        archive::WritePass(&required(file, "file"), data.scene.GetPrims(), state, settings, std::move(info));
    if (!fault.empty()) throw Failure(ALABASTER_OUTPUT_FAILED, fault);
  });
}

AlabasterStatus buffer_create(AlabasterDelegate* handle, int32_t width, int32_t height, int32_t format,
                              AlabasterBuffer** out) {
  return guarded([&] {
    auto& made = required(out, "buffer");
    auto data = std::make_shared<BufferData>();
    data->owner = required(handle, "delegate").data;
    const HostLock lock(*data->owner);
    data->buffer = dynamic_cast<RenderBuffer*>(data->owner->delegate->CreateBprim("renderBuffer", "/buffer"));
    if (!data->buffer) throw std::bad_alloc();
    allocate(*data, width, height, format);
    made = new AlabasterBuffer{std::move(data)};
  });
}

AlabasterStatus buffer_resize(AlabasterBuffer* handle, int32_t width, int32_t height, int32_t format) {
  return with_data(handle, "buffer", [&](BufferData& data) {
    const HostLock lock(*data.owner);
    allocate(data, width, height, format);
  });
}

AlabasterStatus buffer_map(AlabasterBuffer* handle, AlabasterPixels* out) {
  return guarded([&] {
    const std::shared_ptr<BufferData> data = required(handle, "buffer").data;
    auto mapping = std::make_unique<Mapping>(Mapping{data});
    sized(out, "pixels");
    AlabasterPixels pixels = map_pixels(*data);
    if (!pixels.data) throw Failure(ALABASTER_NOT_FOUND, "the buffer has no pixels yet");
    pixels.mapping = mapping.release();
    answer(out, pixels, "pixels");
  });
}

AlabasterStatus pixels_unmap(AlabasterPixels* pixels) {
  return guarded([&] {
    std::unique_ptr<Mapping> mapping(static_cast<Mapping*>(sized(pixels, "pixels").mapping));
    if (!mapping) throw bad_argument("these pixels are not mapped");
    pixels->data = nullptr, pixels->mapping = nullptr;
    if (mapping->buffer->owner->process.is_another())
      static_cast<void>(mapping.release());  // it may be the last that keeps the buffer
    else
      mapping->buffer->buffer->Unmap();
  });
}

AlabasterStatus buffer_read(AlabasterBuffer* handle, void* memory, size_t bytes, int32_t y_down) {
  return with_data(handle, "buffer", [&](BufferData& data) {
    const AlabasterPixels pixels = map_pixels(data);
    if (!pixels.data) throw Failure(ALABASTER_NOT_FOUND, "the buffer has no pixels yet");
    const size_t rows = size_t(pixels.height), row = size_t(pixels.width) * FormatSize(Format(pixels.format));
    const bool fits = memory && bytes >= rows * row;
    for (size_t y = 0; fits && y < rows; ++y)
      std::memcpy(static_cast<uint8_t*>(memory) + y * row,
                  static_cast<const uint8_t*>(pixels.data) + (y_down ? rows - 1 - y : y) * row, row);
    data.buffer->Unmap();
    if (!fits) throw bad_argument("the pixels need " + std::to_string(rows * row) + " bytes");
  });
}

std::vector<host::PickHit> hits_in(PassData& data, const AlabasterRect& rect) {
  const HostLock lock(*data.owner);
  if (!data.owner->scene) throw bad_argument("the delegate draws no scene");
  const auto& bindings = data.state.aovBindings;
  if (std::none_of(bindings.begin(), bindings.end(), [](const AovBinding& b) {
        return b.aovName == Token("primId") && b.renderBuffer->GetFormat() == Format::int32;
      }))
    throw bad_argument("pick needs AOV primId, bound to a buffer of ALABASTER_INT32");
  return host::Pick(*data.owner->index, data.owner->scene->scene, data.state,
                    {rect.min_x, rect.min_y, rect.max_x, rect.max_y});
}

AlabasterStatus pick(AlabasterPass* handle, const AlabasterRect* rect, AlabasterVisitPick visit, void* user) {
  return with_data(handle, "pass", [&](PassData& data) {
    if (!visit) throw bad_argument("visit is null");
    const AlabasterRect in = required(rect, "rect");
    for (const host::PickHit& hit : hits_in(data, in)) {
      std::vector<AlabasterPickedInstance> instances;
      for (const host::PickedInstance& one : hit.instances)
        instances.push_back({one.instancer.str().c_str(), one.index});
      const AlabasterPick told = {sizeof told, hit.path.str().c_str(), hit.instanceId,  hit.face, hit.x,
                                  hit.y,       instances.data(),       instances.size()};
      visit(user, &told);
    }
  });
}

AlabasterStatus snapshot(AlabasterPass* handle, const char* file) {
  return with_data(handle, "pass", [&](PassData& data) {
    RenderProduct product;
    product.file = &required(file, "file");
    const HostLock lock(*data.owner);
    DelegateData& owner = *data.owner;
    owner.reports->take_error({});
    if (!host::WriteSnapshot(*owner.delegate, *data.pass, data.state, product, owner.colors, sink_of(owner.reports)))
      throw Failure(ALABASTER_OUTPUT_FAILED, owner.reports->take_error("the picture could not be written"));
  });
}

}  // namespace

void add_pass_functions(AlabasterApi* api) {
  api->pass_create = pass_create;
  api->pass_destroy = destroy_handle;
  api->pass_start = pass_start;
  api->pass_wait = pass_wait;
  api->pass_state = pass_state;
  api->frame_size = frame_size;
  api->scene_write = scene_write;
  api->buffer_create = buffer_create;
  api->buffer_destroy = destroy_handle;
  api->buffer_resize = buffer_resize;
  api->buffer_map = buffer_map;
  api->pixels_unmap = pixels_unmap;
  api->buffer_read = buffer_read;
  api->pick = pick;
  api->snapshot = snapshot;
}

}  // namespace alabaster::hd::c_api
