#include "testenv/conformance/host.h"

#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <thread>

namespace conformance {

int repetitions(int full, int least) {
  return std::max(least, static_cast<int>(full * library().repeat));
}

Host::Host(int width, int height, Dictionary settings) : width_(width), height_(height) {
  DelegateOptions options;
  options.settings = std::move(settings);
  options.settings.insert({{"samples", 4}, {"threads", 2}, {"filter", "box"}});
  options.diagnostics = [this](const Diagnostic& d) {
    const std::lock_guard lock(mutex_);
    diagnostics_.push_back(d);
  };
  delegate = library().create(kAbiVersion, &options);
  if (!delegate) throw std::runtime_error("the library made no delegate");
  camera().transform.setTranslation(Vec3d(0, 0, 2));
  camera().parameters = {{"focalLength", 1.0f}, {"horizontalAperture", 1.0f}, {"verticalAperture", 1.0f}};
  state.camera = "/camera";
  pass = delegate->CreateRenderPass();
  resize(width, height);
}

Host::~Host() {
  pass.reset();
  for (const auto& [id, entry] : entries_) destroy(entry);
  library().destroy(delegate);
}

void Host::insert(const Path& id, Kind kind, const Token& type, DirtyBits bits) {
  if (const auto found = entries_.find(id); found != entries_.end()) {
    found->second.bits |= bits;
    return;
  }
  Entry entry{.kind = kind, .type = type};
  if (kind == Kind::rprim) {
    Rprim* rprim = delegate->CreateRprim(type, id);
    if (rprim) rprim->SetPrimId(next_prim_id_++);
    entry.prim = rprim;
  }
  if (kind == Kind::sprim) entry.prim = delegate->CreateSprim(type, id);
  if (kind == Kind::bprim) entry.prim = delegate->CreateBprim(type, id);
  if (kind == Kind::instancer) entry.instancer = delegate->CreateInstancer(id);
  if (!entry.prim && !entry.instancer) throw std::runtime_error("the delegate made no " + type.str());
  if (entry.prim) entry.bits = entry.prim->GetInitialDirtyBitsMask();
  entries_.emplace(id, entry);
}

Mesh& Host::mesh(const Path& id, DirtyBits bits) {
  insert(id, Kind::rprim, "mesh", bits);
  return scene.meshes[id];
}
InstancerData& Host::instancer(const Path& id, DirtyBits bits) {
  insert(id, Kind::instancer, Token(), bits);
  return scene.instancers[id];
}
MaterialNetwork& Host::material(const Path& id, DirtyBits bits) {
  insert(id, Kind::sprim, "material", bits);
  return scene.materials[id];
}
Light& Host::light(const Path& id, const Token& type, DirtyBits bits) {
  insert(id, Kind::sprim, type, bits);
  return scene.lights[id];
}
Camera& Host::camera(DirtyBits bits) {
  insert("/camera", Kind::sprim, "camera", bits);
  return scene.cameras["/camera"];
}
void Host::mark(const Path& id, DirtyBits bits) {
  entries_.at(id).bits |= bits;
}

void Host::destroy(const Entry& entry) {
  RenderParam* param = delegate->GetRenderParam();
  if (entry.instancer) {
    entry.instancer->Finalize(param);
    return delegate->DestroyInstancer(entry.instancer);
  }
  entry.prim->Finalize(param);
  if (entry.kind == Kind::rprim) delegate->DestroyRprim(static_cast<Rprim*>(entry.prim));
  if (entry.kind == Kind::sprim) delegate->DestroySprim(static_cast<Sprim*>(entry.prim));
  if (entry.kind == Kind::bprim) delegate->DestroyBprim(static_cast<Bprim*>(entry.prim));
}

void Host::remove(const Path& id) {
  destroy(entries_.at(id));
  entries_.erase(id);
  scene.meshes.erase(id), scene.instancers.erase(id), scene.materials.erase(id), scene.lights.erase(id);
}

int32_t Host::prim_id(const Path& id) const {
  return static_cast<const Rprim*>(entries_.at(id).prim)->GetPrimId();
}

void Host::set_prim_id(const Path& id, int32_t number) {
  static_cast<Rprim*>(entries_.at(id).prim)->SetPrimId(number);
  mark(id, dirty::kPrimId);
}

RenderBuffer& Host::bind(const Token& aov, Format format) {
  const Path id("/aov/" + aov.str());
  if (format == Format::invalid) format = delegate->GetDefaultAovDescriptor(aov).format;
  scene.buffers[id] = {{width_, height_, 1}, format};
  insert(id, Kind::bprim, "renderBuffer", dirty::kDescription);
  state.aovBindings.push_back({aov, static_cast<RenderBuffer*>(entries_.at(id).prim), {}});
  return *state.aovBindings.back().renderBuffer;
}

RenderBuffer& Host::buffer(const Token& aov) {
  for (const AovBinding& binding : state.aovBindings)
    if (binding.aovName == aov) return *binding.renderBuffer;
  return bind(aov, aov == Token("color") ? Format::float32vec4 : Format::invalid);
}

void Host::unbind(const Token& aov) {
  std::erase_if(state.aovBindings, [&](const AovBinding& binding) { return binding.aovName == aov; });
  remove("/aov/" + aov.str());
  scene.buffers.erase("/aov/" + aov.str());
}

void Host::resize(int width, int height) {
  width_ = width, height_ = height;
  state.framing = {{0, 0}, {static_cast<float>(width), static_cast<float>(height)}, {0, 0, width, height}, 1};
  for (auto& [id, description] : scene.buffers) {
    description.dimensions = {width, height, 1};
    mark(id, dirty::kDescription);
  }
}

void Host::sync_entry(const Path& id, Entry& entry) {
  RenderParam* param = delegate->GetRenderParam();
  if (entry.instancer) return entry.instancer->Sync(&scene, param, &entry.bits);
  if (entry.kind != Kind::rprim) return entry.prim->Sync(&scene, param, &entry.bits);
  if (entry.bits & dirty::kVisibility) entry.visible = scene.GetVisible(id);
  if (entry.visible) return entry.prim->Sync(&scene, param, &entry.bits);
  // An invisible prim hears of its visibility alone (hd/rprim.cpp); its other bits stay queued.
  DirtyBits now = entry.bits & dirty::kVisibility;
  const DirtyBits later = entry.bits & ~dirty::kVisibility;
  if (now) entry.prim->Sync(&scene, param, &now);
  entry.bits = now | later;
}

void Host::sync_kind(Kind kind, const Token& type) {
  std::vector<std::pair<const Path, Entry>*> work;
  for (auto& entry : entries_)
    if (entry.second.kind == kind && entry.second.type == type && entry.second.bits) work.push_back(&entry);
  std::atomic<size_t> next = 0;
  const auto loop = [&] {
    for (size_t i = next++; i < work.size(); i = next++) sync_entry(work[i]->first, work[i]->second);
  };
  std::vector<std::thread> threads;
  if (kind == Kind::rprim && work.size() > 1)
    for (int i = 1; i < sync_threads; ++i) threads.emplace_back(loop);
  loop();
  for (std::thread& thread : threads) thread.join();
}

void Host::sync() {
  for (const Token& type : delegate->GetSupportedBprimTypes()) sync_kind(Kind::bprim, type);
  for (const Token& type : delegate->GetSupportedSprimTypes()) sync_kind(Kind::sprim, type);
  sync_kind(Kind::instancer, Token());
  for (const Token& type : delegate->GetSupportedRprimTypes()) sync_kind(Kind::rprim, type);
  delegate->CommitResources();
}

bool Host::converge() {
  const auto end = std::chrono::steady_clock::now() + std::chrono::minutes(1);
  for (int left = 100; left > 0 && std::chrono::steady_clock::now() < end;) {
    pass->Execute(state);
    if (pass->IsConverged()) return true;
    if (pass->WaitForConvergence(1)) --left;
  }
  return false;
}

Picture Host::render(const Token& aov) {
  RenderBuffer& shown = buffer(aov);
  sync();
  if (!converge()) ADD_FAILURE() << "the render does not converge: " << text_stat("error");
  return read(shown);
}

void Host::take_up() {
  const double before = stat("sceneNumber");
  for (int i = 0; i < 20000; ++i) {
    pass->Execute(state);
    const PassState now = pass->GetState();
    if (now != PassState::preparing && now != PassState::idle) return;
    std::this_thread::sleep_for(std::chrono::microseconds(100));
  }
  ADD_FAILURE() << "scene " << before << " has no successor";
}

double Host::stat(const std::string& key) const {
  const Dictionary stats = delegate->GetRenderStats();
  const auto at = stats.find(key);
  return at == stats.end() ? -1 : at->second.number_or(-1);
}

std::string Host::text_stat(const std::string& key) const {
  const Dictionary stats = delegate->GetRenderStats();
  const auto at = stats.find(key);
  return at == stats.end() ? "" : at->second.text_or("");
}

std::vector<Diagnostic> Host::take_diagnostics() {
  const std::lock_guard lock(mutex_);
  return std::exchange(diagnostics_, {});
}

}  // namespace conformance
