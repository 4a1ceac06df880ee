// A picture that was kept to compare others with. It has numbers, not levels: it follows the display's view and
// exposure.
#pragma once

#include <vector>

#include "delegate/api/prims.h"

namespace alabaster::view {

/// A buffer that nothing renders into. Any thread.
class KeptPicture final : public hd::RenderBuffer {
 public:
  /// Null: `from` shows nothing yet.
  static std::shared_ptr<KeptPicture> copy(hd::RenderBuffer* from);

  hd::DirtyBits GetInitialDirtyBitsMask() const override { return hd::dirty::kClean; }
  void Sync(hd::SceneDelegate*, hd::RenderParam*, hd::DirtyBits*) override {}
  void Finalize(hd::RenderParam*) override {}
  bool Allocate(const hd::RenderBufferDescriptor&) override { return false; }
  int GetWidth() const override { return size_.x; }
  int GetHeight() const override { return size_.y; }
  hd::Format GetFormat() const override { return format_; }
  void Resolve() override {}
  const void* Map() override { return nullptr; }
  void Unmap() override {}
  bool IsMapped() const override { return false; }
  bool IsConverged() const override { return true; }
  uint64_t GetGeneration() const override { return number_; }
  /// Takes the formats float32 to float32vec4 and unorm8vec4, with the uppermost row first.
  bool ResolveTo(hd::PixelMemory* memory) override;

 private:
  KeptPicture();

  const uint64_t number_;  // no other kept picture has it, since memory that was shown one may be shown another
  hd::Vec2i size_{0, 0};
  hd::Format format_ = hd::Format::float32vec4;
  std::vector<float> pixels_;
};

}  // namespace alabaster::view
