// The contract's factory over the hidden prims.
#pragma once

#include <unistd.h>

#include "delegate/api/render_delegate.h"
#include "delegate/rendering/delegate_state.h"

namespace alabaster::hd::rendering {

class RenderDelegateImpl final : public RenderDelegate {
 public:
  explicit RenderDelegateImpl(std::shared_ptr<DelegateState> delegate) : delegate_(std::move(delegate)) {}
  ~RenderDelegateImpl() override;
  /// A process that was forked from the one that made it has none of its threads.
  bool is_of_another_process() const { return getpid() != process_; }

  const std::vector<Token>& GetSupportedRprimTypes() const override;
  const std::vector<Token>& GetSupportedSprimTypes() const override;
  const std::vector<Token>& GetSupportedBprimTypes() const override;
  Rprim* CreateRprim(const Token& type, const Path& id) override;
  Sprim* CreateSprim(const Token& type, const Path& id) override;
  Sprim* CreateFallbackSprim(const Token& type) override { return CreateSprim(type, Path()); }
  Bprim* CreateBprim(const Token& type, const Path& id) override;
  Bprim* CreateFallbackBprim(const Token& type) override { return CreateBprim(type, Path()); }
  Instancer* CreateInstancer(const Path& id) override;
  void DestroyRprim(Rprim* prim) override { delete prim; }
  void DestroySprim(Sprim* prim) override { delete prim; }
  void DestroyBprim(Bprim* prim) override { delete prim; }
  void DestroyInstancer(Instancer* instancer) override { delete instancer; }

  std::unique_ptr<RenderPass> CreateRenderPass() override;
  RenderParam* GetRenderParam() override { return delegate_->param.get(); }
  void CommitResources() override;

  void SetRenderSetting(const Token& key, const Value& value) override;
  bool SetRenderSettings(const Dictionary& settings) override;
  Value GetRenderSetting(const Token& key) const override;
  std::vector<RenderSettingDescriptor> GetRenderSettingDescriptors() const override;
  uint32_t GetRenderSettingsVersion() const override { return delegate_->settings_version(); }
  Dictionary GetRenderStats() const override;

  void Pause() override;
  void Resume() override;
  bool IsPaused() const override { return delegate_->is_paused(); }
  void Stop() override;
  void Restart() override;
  bool IsStopped() const override { return delegate_->is_stopped(); }
  std::shared_ptr<const void> HoldStopped() override;

  AovDescriptor GetDefaultAovDescriptor(const Token& aov) const override;
  CommandResult InvokeCommand(const Token& command, const Dictionary& arguments) override;

 private:
  /// Runs an entry point; an exception becomes a report. Returns the result as far as `body` has made it.
  template <class Result, class Body>
  Result answer(const char* entry, Body&& body) const {
    Result result{};
    prims::guarded(delegate_->param->sink(), entry, [&] { body(result); });
    return result;
  }

  std::shared_ptr<DelegateState> delegate_;
  const pid_t process_ = getpid();
};

}  // namespace alabaster::hd::rendering
