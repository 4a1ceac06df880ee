// A host of the C interface that does what it must not: wrong arguments, callbacks that call the library, and a second
// thread meanwhile.
#include <array>
#include <atomic>
#include <thread>
#include <tuple>
#include <vector>

#include "testenv/fuzz/c_api_arguments.h"

namespace alabaster::fuzz {
namespace {

constexpr int kMostSteps = 60, kDeepest = 3;

const AlabasterApi& api() {
  return *alabaster_api(ALABASTER_API_VERSION);
}

/// One host with its handles.
class Host final : CallArguments {
 public:
  explicit Host(Bytes bytes) : CallArguments(bytes) {
    check(api().scene_create(&Host::hear, this, &scene_));
    add_stage();
    AlabasterDelegateOptions options = {};
    options.size = sizeof options;
    options.report = &Host::hear, options.user = this;
    check(api().delegate_create(&options, scene_, &delegate_));
    check(api().pass_create(delegate_, &pass_));
    check(api().buffer_create(delegate_, kSide, kSide, ALABASTER_FLOAT32_4, &buffer_));
  }
  ~Host() override {
    over_ = true;
    if (other_.joinable()) other_.join();
    api().pass_destroy(pass_);
    api().buffer_destroy(buffer_);
    api().delegate_destroy(delegate_);
    api().scene_destroy(scene_);
    api().scene_destroy(spare_);
    api().scene_create(nullptr, nullptr, nullptr);  // destroys what callbacks have destroyed
    check_loans();
  }

  void run() {
    if (in_.flag()) other_ = std::thread([this] { watch(); });
    for (int i = 0; i < kMostSteps && !in_.empty(); ++i) step();
  }

 private:
  // Callbacks --------------------------------------------------------------------------------------
  static void hear(void* user, const AlabasterDiagnostic* diagnostic) {
    Host& host = *static_cast<Host*>(user);
    if (!diagnostic->text || !*diagnostic->text) broken("a report has a text");
    if (api().scene_clear(host.scene_) != ALABASTER_INVALID_ARGUMENT) broken("a report calls the library");
  }
  void came_back() override {
    if (api().scene_clear(scene_) != ALABASTER_INVALID_ARGUMENT) broken("a release calls the library");
    api().scene_destroy(spare_.exchange(nullptr));
  }
  static void visit(void* user, const char*, const AlabasterValue* value) {
    if (!value) broken("a visit has a value");
    static_cast<Host*>(user)->step_within();
  }
  static void visit_setting(void* user, const AlabasterSetting*) { static_cast<Host*>(user)->step_within(); }
  static void visit_pick(void* user, const AlabasterPick*) { static_cast<Host*>(user)->step_within(); }
  static int32_t progress(void* user, const AlabasterProgress*) {
    Host& host = *static_cast<Host*>(user);
    host.step_within();
    return ++host.told_ < 3;
  }
  void step_within() {
    if (depth_ >= kDeepest || in_.empty() || !in_.flag()) return;
    ++depth_;
    step();
    --depth_;
  }
  void watch() {
    std::vector<float> pixels(4 * kSide * kSide);
    AlabasterProgress progress = {};
    progress.size = sizeof progress;
    for (int i = 0; !over_; ++i) {
      int32_t state = 0;
      api().pass_state(pass_, &state);
      api().progress(delegate_, &progress);
      api().buffer_read(buffer_, pixels.data(), pixels.size() * sizeof(float), 1);
      api().pass_wait(pass_, 0, nullptr);
      if (i % 7 == 0) api().stop(delegate_);
      api().restart(delegate_);
    }
  }

  // Calls ------------------------------------------------------------------------------------------
  void check(AlabasterStatus status) {
    if (status < ALABASTER_OK || status > ALABASTER_INTERNAL) broken("a call ends with a status of the header");
    if (status != ALABASTER_OK && !*api().last_error()) broken("a call that fails says why");
    if (status == ALABASTER_INTERNAL) broken(std::string("nothing fails inside: ") + api().last_error());
  }
  void add_stage() {
    static constexpr float kCorners[] = {-1, -1, 0, 1, -1, 0, 1, 1, 0, -1, 1, 0};
    static constexpr int32_t kCounts[] = {4}, kIndices[] = {0, 1, 2, 3};
    static constexpr double kAway[] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 6, 1};
    const auto array = [](int32_t type, const void* data, size_t count) {
      return AlabasterValue{type, 1, data, count, nullptr, nullptr};
    };
    const auto scalar = [](int32_t type, const void* data) {
      return AlabasterValue{type, 0, data, 1, nullptr, nullptr};
    };
    const auto set = [&](const char* path, const char* kind, const std::vector<AlabasterParameter>& fields) {
      const AlabasterStatus status = api().scene_set(scene_, path, kind, fields.data(), fields.size());
      if (status != ALABASTER_OK) broken(std::string("the stage can be set: ") + api().last_error());
    };
    set("/mesh", "mesh",
        {{"faceVertexCounts", array(ALABASTER_INT, kCounts, 1)},
         {"faceVertexIndices", array(ALABASTER_INT, kIndices, 4)},
         {"primvars:points", array(ALABASTER_FLOAT3, kCorners, 4)}});
    set("/many", "instancer",
        {{"primvars:hydra:instanceTranslations", array(ALABASTER_FLOAT3, kCorners, 4)},
         {"prototypes:/mesh", array(ALABASTER_INT, kIndices, 4)}});
    set("/wax", "material",
        {{"surface.type", scalar(ALABASTER_TOKEN, "AlabasterDisney")},
         {"image.type", scalar(ALABASTER_TOKEN, "AlabasterTexture")}});
    set("/lamp", "sphereLight", {});
    set("/dome", "domeLight", {});
    set("/camera", "camera", {{"transform", scalar(ALABASTER_MATRIX, kAway)}});
    static constexpr int32_t kSamples = 1;
    set("/settings", "renderSettings",
        {{"camera", scalar(ALABASTER_PATH, "/camera")},
         {"width", scalar(ALABASTER_INT, &kSide)},
         {"height", scalar(ALABASTER_INT, &kSide)},
         {"samples", scalar(ALABASTER_INT, &kSamples)}});
  }

  void step() {
    switch (in_.choice(4)) {
      case 0:
        return check(set_prim());
      case 1:
        return check(edit_prim());
      case 2:
        return check(call_delegate());
      default:
        return check(call_pass());
    }
  }
  /// Sets a prim by fields of its kind; now and then by those of another.
  AlabasterStatus set_prim() {
    const Kind& kind = kKinds[in_.choice(static_cast<int>(std::size(kKinds)))];
    const auto [first, count] = fields(kind.fields);
    return api().scene_set(or_null(scene_), text(), in_.choice(8) == 7 ? text() : kind.name, first, count);
  }
  AlabasterStatus edit_prim() {
    AlabasterScene* const scene = or_null(scene_);
    switch (in_.choice(8)) {
      case 0:
      case 1:
      case 2:
      case 3: {
        const int kind = in_.choice(static_cast<int>(std::size(kKinds)));
        const auto [first, count] = fields(kKinds[kind].fields);
        return api().scene_edit(scene, in_.choice(4) == 3 ? text() : kPaths[kind], first, count);
      }
      case 4: {
        const auto first = static_cast<size_t>(in_.choice(9));
        const char* const primvar = in_.choice(4) == 3 ? text() : "hydra:instanceTranslations";
        if (in_.choice(8) == 7) return api().scene_set_instances(scene, text(), primvar, first, nullptr);
        const auto made = in_.flag() ? value() : lent_or_not(of_type(ALABASTER_FLOAT3, ALABASTER_ARRAY));
        return api().scene_set_instances(scene, in_.choice(4) == 3 ? text() : "/many", primvar, first, &made);
      }
      case 5:
        return api().remove(scene, text());
      case 6:
        return api().get_prims(scene, or_null(&Host::visit), this);
      default:
        if (in_.choice(4) == 3) check(api().scene_clear(scene_)), add_stage();
        return make_spare();
    }
  }
  AlabasterStatus make_spare() {
    AlabasterScene* made = nullptr;
    const AlabasterStatus status = api().scene_create(&Host::hear, this, &made);
    api().scene_destroy(spare_.exchange(made));
    return status;
  }
  AlabasterStatus call_delegate() {
    AlabasterDelegate* const delegate = or_null(delegate_);
    switch (in_.choice(9)) {
      case 0:
        return api().show(delegate, in_.flag() ? scene_ : nullptr);
      case 1: {
        const auto made = value();
        return api().set_setting(delegate, in_.flag() ? text() : "seed", &made);
      }
      case 2:
        return api().get_setting(delegate, text(), or_null(&Host::visit), this);
      case 3:
        return api().get_settings(delegate, or_null(&Host::visit_setting), this);
      case 4:
        return api().stats(delegate, or_null(&Host::visit), this);
      case 5: {
        const auto [first, count] = parameters();
        return api().command(delegate, text(), first, count, or_null(&Host::visit), this);
      }
      case 6: {
        int32_t format = 0;
        return api().aov_format(delegate, text(), or_null(&format));
      }
      case 7: {
        auto options = sized<AlabasterDelegateOptions>();
        std::tie(options.settings, options.setting_count) = parameters();
        AlabasterDelegate* made = nullptr;
        const AlabasterStatus status = api().delegate_create(&options, nullptr, &made);
        api().delegate_destroy(made);
        return status;
      }
      default:
        return record(delegate);
    }
  }
  AlabasterStatus record(AlabasterDelegate* delegate) {
    const std::string file = scratch_folder() + "/c_api.exr";
    const char *const files[] = {file.c_str(), nullptr}, *const aovs[] = {text(), "depth"};
    auto options = sized<AlabasterRecordOptions>();
    std::tie(options.files, options.file_count) = items(files, 2);
    std::tie(options.aovs, options.aov_count) = items(aovs, 2);
    options.keep_going = in_.byte();
    options.progress = or_null(&Host::progress), options.user = this;
    if (depth_ == 0) told_ = 0;
    return api().record(delegate, in_.choice(8) == 7 ? nullptr : &options, &Host::visit, this);
  }
  AlabasterStatus call_pass() {
    AlabasterPass* const pass = or_null(pass_);
    switch (in_.choice(9)) {
      case 0:
      case 1: {
        const auto made = frame(or_null(buffer_));
        return api().pass_start(pass, &made);
      }
      case 2: {
        const auto made = frame(or_null(buffer_));
        int32_t width = 0, height = 0;
        return api().frame_size(or_null(delegate_), &made, or_null(&width), &height);
      }
      case 3: {
        const auto made = frame(or_null(buffer_));
        const std::string file = scratch_folder() + "/c_api.alab";
        const auto [first, count] = parameters();
        return api().scene_write(or_null(scene_), file.c_str(), &made, first, count);
      }
      default:
        return call_buffer(pass);
    }
  }
  AlabasterStatus call_buffer(AlabasterPass* pass) {
    AlabasterBuffer* const buffer = or_null(buffer_);
    switch (in_.choice(6)) {
      case 0:
        return api().pass_wait(pass, 0.001 * in_.choice(20), nullptr);
      case 1:
        return api().buffer_resize(buffer, in_.choice(9), in_.choice(9), in_.choice(13));
      case 2: {
        auto pixels = sized<AlabasterPixels>();
        const AlabasterStatus status = api().buffer_map(buffer, &pixels);
        if (status == ALABASTER_OK) check(api().pixels_unmap(&pixels));
        return status;
      }
      case 3: {
        auto memory = sized<AlabasterMemory>();
        std::array<float, 4 * 8 * 8> pixels;
        memory.pixels = or_null(pixels.data()), memory.row_bytes = 16 * 8;
        memory.width = in_.choice(9), memory.height = in_.choice(9), memory.format = in_.choice(13);
        return api().buffer_show(buffer, &memory);
      }
      case 4: {
        const AlabasterRect rect = {in_.choice(9) - 2, 0, in_.choice(9), kSide};
        return api().pick(pass, or_null(&rect), or_null(&Host::visit_pick), this);
      }
      default:
        return api().snapshot(pass, in_.choice(4) == 3 ? nullptr : (scratch_folder() + "/c_api.png").c_str());
    }
  }

  static constexpr const char* kPaths[] = {"/mesh", "/many", "/wax", "/lamp", "/camera", "/settings"};  // of kKinds
  AlabasterScene* scene_ = nullptr;
  std::atomic<AlabasterScene*> spare_{nullptr};  // a callback may destroy it
  AlabasterDelegate* delegate_ = nullptr;
  AlabasterPass* pass_ = nullptr;
  AlabasterBuffer* buffer_ = nullptr;
  int depth_ = 0, told_ = 0;
  std::atomic<bool> over_{false};
  std::thread other_;
};

}  // namespace

void run_c_api(Bytes input) {
  Host(input).run();
}

}  // namespace alabaster::fuzz
