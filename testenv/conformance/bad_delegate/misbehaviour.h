// A delegate that misbehaves in the way that the environment variable CONFORMANCE_BAD names. It passes everything
// else on to the good delegate that it is linked with. misbehaviours.py lists the names and the tests that must notice.
#pragma once

#include <array>
#include <atomic>
#include <map>
#include <memory>
#include <mutex>
#include <set>
#include <string>
#include <vector>

#include "delegate/api/render_delegate.h"

namespace bad {

using namespace alabaster::hd;

/// CONFORMANCE_BAD holds `name`. Several may be given, separated by commas.
bool is(const char* name);

/// Everything that the wrappers of one delegate share.
struct Memory {
  RenderDelegate* real = nullptr;
  std::atomic<bool> paused = false;
  std::atomic<bool> must_restart = false;  // at the next Execute
  std::atomic<bool> poisoned = false;      // a mesh was invalid
  std::atomic<bool> waiting = false;       // a pass was executed and has not converged since
  std::atomic<int> network_syncs = 0;
  std::mutex mutex;          // of all below: Rprims are synced in parallel
  std::set<Path> materials;  // that exist
  std::map<Path, std::map<Token, std::pair<PrimvarDescriptor, Value>>> primvars;
  std::map<Path, std::map<std::string, Value>> first;  // answers by prim and question
  std::vector<std::vector<char>> leaked;
  std::vector<std::vector<uint8_t>> kept;  // pixels that may still be mapped
  std::shared_ptr<std::atomic<bool>> holds_workers = std::make_shared<std::atomic<bool>>(false);  // of the host's TBB

  void hold_workers();
  /// The first answer that was not empty.
  Value latched(const Path& id, const std::string& question, const Value& answer);
};

/// Answers as the host does, but for the misbehaviour. Lives for one Sync.
class Scene final : public SceneDelegate {
 public:
  Scene(SceneDelegate* host, Memory* memory) : host_(host), memory_(memory) {}

  MeshTopology GetMeshTopology(const Path& id) override;
  SubdivTags GetSubdivTags(const Path& id) override { return host_->GetSubdivTags(id); }
  DisplayStyle GetDisplayStyle(const Path& id) override { return host_->GetDisplayStyle(id); }
  Matrix4d GetTransform(const Path& id) override { return host_->GetTransform(id); }
  bool GetVisible(const Path& id) override;
  bool GetDoubleSided(const Path& id) override { return is("ignores_sides") || host_->GetDoubleSided(id); }
  Token GetRenderTag(const Path& id) override;
  std::vector<Token> GetCategories(const Path& id) override { return host_->GetCategories(id); }
  std::vector<std::vector<Token>> GetInstanceCategories(const Path& id) override {
    return host_->GetInstanceCategories(id);
  }
  Path GetMaterialId(const Path& id) override;
  std::vector<PrimvarDescriptor> GetPrimvarDescriptors(const Path& id) override;
  Value GetPrimvar(const Path& id, const Token& name, Array<int32_t>* indices) override;
  TimeSamples<Matrix4d> SampleTransform(const Path& id) override;
  TimeSamples<Value> SamplePrimvar(const Path& id, const Token& name) override {
    return host_->SamplePrimvar(id, name);
  }
  TimeSamples<Matrix4d> SampleInstancerTransform(const Path& id) override {
    return host_->SampleInstancerTransform(id);
  }
  Path GetInstancerId(const Path& id) override;
  Matrix4d GetInstancerTransform(const Path& id) override { return host_->GetInstancerTransform(id); }
  Array<int32_t> GetInstanceIndices(const Path& id, const Path& prototype) override;
  MaterialNetwork GetMaterialResource(const Path& id) override;
  Value GetLightParamValue(const Path& id, const Token& name) override;
  Value GetCameraParamValue(const Path& id, const Token& name) override;
  RenderBufferDescriptor GetRenderBufferDescriptor(const Path& id) override {
    return host_->GetRenderBufferDescriptor(id);
  }
  RenderSettingsDescription GetRenderSettings(const Path& id) override { return host_->GetRenderSettings(id); }

 private:
  SceneDelegate* host_;
  Memory* memory_;
};

/// Knows the AOV that it is bound to, and keeps pixels of its own where it spoils them.
class Buffer final : public RenderBuffer {
 public:
  Buffer(const Path& id, RenderBuffer* real, Memory* memory) : RenderBuffer(id), real(real), memory_(memory) {}
  DirtyBits GetInitialDirtyBitsMask() const override { return real->GetInitialDirtyBitsMask(); }
  void Sync(SceneDelegate* scene, RenderParam* param, DirtyBits* bits) override;
  void Finalize(RenderParam* param) override { real->Finalize(param); }
  bool Allocate(const RenderBufferDescriptor& description) override;
  int GetWidth() const override { return real->GetWidth(); }
  int GetHeight() const override { return real->GetHeight(); }
  Format GetFormat() const override { return real->GetFormat(); }
  void Resolve() override;
  const void* Map() override;
  void Unmap() override { real->Unmap(); }
  bool IsMapped() const override { return real->IsMapped(); }
  bool IsConverged() const override { return real->IsConverged() && !is("buffers_never_converge"); }
  uint64_t GetGeneration() const override;
  bool ResolveTo(PixelMemory* memory) override;

  std::vector<uint8_t> take_own() { return std::move(own_); }

  RenderBuffer* const real;
  Token aov;

 private:
  void spoil(std::vector<uint8_t>* pixels) const;
  void average(std::vector<uint8_t>* pixels) const;
  bool may_allocate(const RenderBufferDescriptor& description);
  Memory* memory_;
  std::vector<uint8_t> own_;
  RenderBufferDescriptor wanted_;
  int allocations_ = 0;
  mutable std::atomic<uint64_t> asked_ = 0;
};

class Pass final : public RenderPass {
 public:
  Pass(std::unique_ptr<RenderPass> real, Memory* memory) : real_(std::move(real)), memory_(memory) {}
  void Execute(const RenderPassState& state) override;
  bool IsConverged() const override;
  PassState GetState() const override { return lied_ ? PassState::converged : real_->GetState(); }
  bool WaitForConvergence(double seconds) override { return real_->WaitForConvergence(seconds); }

 private:
  RenderPassState translated(const RenderPassState& state) const;
  std::unique_ptr<RenderPass> real_;
  Memory* memory_;
  mutable std::atomic<bool> lied_ = false;  // about convergence
};

}  // namespace bad
