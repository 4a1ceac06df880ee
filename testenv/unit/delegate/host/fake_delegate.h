// A RenderDelegate that draws nothing and records every call, so that tests can compare the host kit with the contract.
#pragma once

#include <mutex>
#include <string>
#include <vector>

#include "delegate/api/render_delegate.h"

namespace alabaster::hd {

struct Journal {
  std::mutex mutex;
  std::vector<std::string> lines;
  void add(const std::string& line) {
    const std::lock_guard lock(mutex);
    lines.push_back(line);
  }
  std::vector<std::string> take() {
    const std::lock_guard lock(mutex);
    return std::move(lines);
  }
};

template <class Base>
class FakePrim final : public Base {
 public:
  FakePrim(Path id, Journal* journal, DirtyBits leaves) : Base(id), journal_(journal), leaves_(leaves) {}
  DirtyBits GetInitialDirtyBitsMask() const override { return dirty::kAll; }
  void Sync(SceneDelegate*, RenderParam*, DirtyBits* bits) override {
    journal_->add("sync " + this->GetId().str() + (*bits == dirty::kAll ? "" : " " + std::to_string(*bits)));
    *bits = leaves_;
  }
  void Finalize(RenderParam*) override { journal_->add("finalize " + this->GetId().str()); }

 private:
  Journal* journal_;
  DirtyBits leaves_;
};

class FakeInstancer final : public Instancer {
 public:
  FakeInstancer(Path id, Journal* journal) : Instancer(id), journal_(journal) {}
  void Sync(SceneDelegate*, RenderParam*, DirtyBits* bits) override {
    journal_->add("sync " + GetId().str() + (*bits == dirty::kAll ? "" : " " + std::to_string(*bits)));
    *bits = dirty::kClean;
  }
  void Finalize(RenderParam*) override { journal_->add("finalize " + GetId().str()); }

 private:
  Journal* journal_;
};

class FakeDelegate final : public RenderDelegate {
 public:
  Journal journal;
  DirtyBits prims_leave = dirty::kClean;  // the dirty bits that Sync of an R-, S- or Bprim leaves

  const std::vector<Token>& GetSupportedRprimTypes() const override { return rprims_; }
  const std::vector<Token>& GetSupportedSprimTypes() const override { return sprims_; }
  const std::vector<Token>& GetSupportedBprimTypes() const override { return bprims_; }
  Rprim* CreateRprim(const Token& type, const Path& id) override { return create<Rprim>(rprims_, type, id); }
  Sprim* CreateSprim(const Token& type, const Path& id) override { return create<Sprim>(sprims_, type, id); }
  Sprim* CreateFallbackSprim(const Token& type) override { return CreateSprim(type, Path()); }
  Bprim* CreateBprim(const Token& type, const Path& id) override { return create<Bprim>(bprims_, type, id); }
  Bprim* CreateFallbackBprim(const Token& type) override { return CreateBprim(type, Path()); }
  Instancer* CreateInstancer(const Path& id) override { return new FakeInstancer(id, &journal); }
  void DestroyRprim(Rprim* prim) override { destroy(prim); }
  void DestroySprim(Sprim* prim) override { destroy(prim); }
  void DestroyBprim(Bprim* prim) override { destroy(prim); }
  void DestroyInstancer(Instancer* instancer) override {
    journal.add("destroy " + instancer->GetId().str());
    delete instancer;
  }
  std::unique_ptr<RenderPass> CreateRenderPass() override { return nullptr; }
  RenderParam* GetRenderParam() override { return nullptr; }
  void CommitResources() override { journal.add("commit"); }
  void SetRenderSetting(const Token&, const Value&) override {}
  bool SetRenderSettings(const Dictionary&) override { return true; }
  Value GetRenderSetting(const Token&) const override { return {}; }
  std::vector<RenderSettingDescriptor> GetRenderSettingDescriptors() const override { return {}; }
  uint32_t GetRenderSettingsVersion() const override { return 0; }
  Dictionary GetRenderStats() const override { return {}; }
  void Pause() override {}
  void Resume() override {}
  bool IsPaused() const override { return false; }
  void Stop() override {}
  void Restart() override {}
  bool IsStopped() const override { return false; }
  std::shared_ptr<const void> HoldStopped() override { return nullptr; }
  AovDescriptor GetDefaultAovDescriptor(const Token&) const override { return {}; }
  CommandResult InvokeCommand(const Token&, const Dictionary&) override {
    return {CommandStatus::unknown, "there are no commands", {}};
  }

 private:
  template <class Base>
  Base* create(const std::vector<Token>& types, const Token& type, const Path& id) {
    for (const Token& known : types)
      if (known == type) return new FakePrim<Base>(id, &journal, prims_leave);
    return nullptr;
  }
  template <class Base>
  void destroy(Base* prim) {
    journal.add("destroy " + prim->GetId().str());
    delete prim;
  }
  std::vector<Token> rprims_{"mesh"}, sprims_{"camera", "material", "rectLight", "domeLight"},
      bprims_{"renderSettings", "renderBuffer"};
};

}  // namespace alabaster::hd
