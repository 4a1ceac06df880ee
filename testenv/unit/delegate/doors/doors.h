// Ways into a scene: a host of C++ and one of C make, edit and remove prims by named fields, and both draw.
#pragma once

#include <gtest/gtest.h>

#include <deque>
#include <regex>

#include "delegate/c_api/alabaster.h"
#include "delegate/host/scene_fields.h"
#include "testenv/support/stage.h"

namespace alabaster::hd::doors {

using host::Fields;

constexpr int kSide = 16;

/// The numbers of prims are those of the order in which they came.
inline std::string without_numbers(const std::string& dump) {
  return std::regex_replace(dump, std::regex(" prim [0-9]+"), "");
}

class Door {
 public:
  Door() = default;
  Door(const Door&) = delete;
  Door& operator=(const Door&) = delete;
  virtual ~Door() = default;
  // "" or the fault.
  virtual std::string set(const Path& path, const Token& kind, const Fields& fields) = 0;
  virtual std::string edit(const Path& path, const Fields& fields) = 0;
  virtual void remove(const Path& path) = 0;
  /// Draws what there is, and goes on at once.
  virtual void draw() = 0;
  virtual std::string dump() = 0;
  virtual std::vector<float> picture() = 0;

  void set_all(const host::Prims& prims) {
    for (const auto& [path, prim] : prims) {
      const Token kind = host::TypeOf(prim);
      ASSERT_FALSE(kind.empty()) << path.str();
      ASSERT_EQ(set(path, kind, host::GetFields(path, prim)), "") << path.str();
    }
  }
};

class CppDoor : public Door {
 public:
  CppDoor() {
    buffer_ = stage.add_buffer("/b", kSide, kSide, Format::float32vec4);
    stage.index->SyncAll();
    pass_ = stage.delegate->CreateRenderPass();
    state_ = Stage::state_for(kSide, kSide, "color", buffer_);
    state_.windowPolicy = WindowPolicy::fit;
  }
  ~CppDoor() override { pass_.reset(); }

  std::string set(const Path& path, const Token& kind, const Fields& fields) override {
    return SetPrim(&stage.scene, path, kind, fields).fault;
  }
  std::string edit(const Path& path, const Fields& fields) override {
    return EditPrim(&stage.scene, path, fields).fault;
  }
  void remove(const Path& path) override { EXPECT_TRUE(stage.scene.Remove(path)); }
  void draw() override {
    stage.index->SyncAll();
    pass_->Execute(state_);
  }
  std::string dump() override { return without_numbers(stage.dump()); }
  std::vector<float> picture() override {
    stage.index->SyncAll();
    EXPECT_TRUE(Stage::finish(*pass_, state_));
    return Stage::pixels<float>(buffer_);
  }
  /// Without the buffer.
  host::Prims prims() const {
    host::Prims all = stage.scene.GetPrims();
    all.erase("/b");
    return all;
  }

  Stage stage{{{"samples", int64_t(2)}, {"threads", 2}}};

 private:
  RenderBuffer* buffer_ = nullptr;
  std::unique_ptr<RenderPass> pass_;
  RenderPassState state_;
};

/// Fields as the C interface takes them.
class CFields {
 public:
  explicit CFields(Fields fields) : fields_(std::move(fields)) {
    for (const auto& [name, value] : fields_) all_.push_back({text(name), of(value)});
  }
  const AlabasterParameter* data() const { return all_.data(); }
  size_t size() const { return all_.size(); }

 private:
  const char* text(std::string of) { return texts_.emplace_back(std::move(of)).c_str(); }

  AlabasterValue of(const Value& value) {
    if (value.empty()) return {};
    AlabasterValue made{value.type(), value.is_array() ? ALABASTER_ARRAY : ALABASTER_SCALAR,
                        value.data(), value.count(),
                        nullptr,      nullptr};
    if (const auto* held = value.get<std::shared_ptr<const TimeSamples<Value>>>()) {
      std::vector<AlabasterSample>& samples = samples_.emplace_back();
      for (size_t i = 0; i < (*held)->values.size(); ++i)
        samples.push_back({(*held)->times[i], of((*held)->values[i])});
      made.data = samples.data(), made.count = samples.size();
    } else if (GetTypeInfo(value.type()).bytes == 0) {
      made.data = value.is_array() ? names(value) : static_cast<const void*>(text(value.text_or("")));
    }
    return made;
  }
  const void* names(const Value& value) {
    std::vector<const char*>& all = names_.emplace_back();
    if (const auto* paths = value.get<Array<Path>>())
      for (const Path& path : *paths) all.push_back(text(path.str()));
    if (const auto* tokens = value.get<Array<Token>>())
      for (const Token& token : *tokens) all.push_back(text(token.str()));
    EXPECT_EQ(all.size(), value.count());
    return all.data();
  }

  const Fields fields_;  // whose numbers are pointed at
  std::deque<std::string> texts_;
  std::deque<std::vector<const char*>> names_;
  std::deque<std::vector<AlabasterSample>> samples_;
  std::vector<AlabasterParameter> all_;
};

class CDoor : public Door {
 public:
  CDoor() {
    const CFields settings({{"samples", 2}, {"threads", 2}});
    const AlabasterDelegateOptions options = {sizeof options, nullptr, nullptr, settings.data(), settings.size()};
    expect(api().scene_create(nullptr, nullptr, &scene));
    expect(api().delegate_create(&options, scene, &delegate_));
    expect(api().buffer_create(delegate_, kSide, kSide, ALABASTER_FLOAT32_4, &buffer_));
    expect(api().pass_create(delegate_, &pass_));
  }
  ~CDoor() override {
    api().pass_destroy(pass_);
    api().buffer_destroy(buffer_);
    api().delegate_destroy(delegate_);
    api().scene_destroy(scene);
  }

  std::string set(const Path& path, const Token& kind, const Fields& fields) override {
    const CFields given(fields);
    return fault(api().scene_set(scene, path.str().c_str(), kind.str().c_str(), given.data(), given.size()));
  }
  std::string edit(const Path& path, const Fields& fields) override {
    const CFields given(fields);
    return fault(api().scene_edit(scene, path.str().c_str(), given.data(), given.size()));
  }
  void remove(const Path& path) override { expect(api().remove(scene, path.str().c_str())); }
  void draw() override {
    const AlabasterBinding binding = {"color", buffer_};
    const char* const tags[] = {"geometry", "render"};
    AlabasterFrame frame = {};  // says all that render settings of the scene may
    frame.size = sizeof frame;
    frame.bindings = &binding, frame.binding_count = 1;
    frame.camera = "/camera";
    frame.width = frame.height = kSide;
    frame.window = {0, 0, kSide, kSide};
    frame.pixel_aspect = 1, frame.window_policy = ALABASTER_FIT;
    frame.render_tags = {ALABASTER_TOKEN, ALABASTER_ARRAY, tags, 2, nullptr, nullptr};
    expect(api().pass_start(pass_, &frame));
  }
  std::string dump() override {
    std::string text;
    const auto add = [](void* user, const char*, const AlabasterValue* value) {
      *static_cast<std::string*>(user) += static_cast<const char*>(value->data);
    };
    draw();
    expect(api().command(delegate_, "dumpScene", nullptr, 0, add, &text));
    return without_numbers(text);
  }
  std::vector<float> picture() override {
    draw();
    int32_t over = 0;
    expect(api().pass_wait(pass_, -1, &over));
    std::vector<float> pixels(size_t{4} * kSide * kSide);
    expect(api().buffer_read(buffer_, pixels.data(), pixels.size() * sizeof(float), 1));
    return pixels;
  }

  static const AlabasterApi& api() { return *alabaster_api(ALABASTER_API_VERSION); }
  AlabasterScene* scene = nullptr;

 private:
  static std::string fault(AlabasterStatus status) { return status == ALABASTER_OK ? "" : api().last_error(); }
  static void expect(AlabasterStatus status) { EXPECT_EQ(fault(status), ""); }

  AlabasterDelegate* delegate_ = nullptr;
  AlabasterBuffer* buffer_ = nullptr;
  AlabasterPass* pass_ = nullptr;
};

}  // namespace alabaster::hd::doors
