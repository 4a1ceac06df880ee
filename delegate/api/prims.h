// Prims: the index creates them through the RenderDelegate and syncs them. They hold no pointer to an index and never
// look other prims up: they record paths, and RenderDelegate::CommitResources resolves them.
#pragma once

#include <span>

#include "delegate/api/scene_delegate.h"

namespace alabaster::hd {

/// Opaque; owned by the delegate; the only channel from a prim to the renderer.
class ALABASTER_API RenderParam {
 public:
  virtual ~RenderParam();
};

class ALABASTER_API Instancer {
 public:
  explicit Instancer(Path id) : id_(id) {}
  virtual ~Instancer();
  const Path& GetId() const { return id_; }
  /// Pulls the instancer's transform and instance primvars: hydra:instanceTransforms, ...Translations, ...Rotations,
  /// ...Scales, and values that looks read. Point p: proto * M * S * R * T * instancerTransform * parent...
  virtual void Sync(SceneDelegate* scene, RenderParam* param, DirtyBits* bits) = 0;
  virtual void Finalize(RenderParam* param) = 0;

 private:
  Path id_;
};

/// Common to R-, S- and Bprims. Sync converts what is dirty and leaves *bits clean, but for bits that are still
/// dirty. An exception of the scene delegate is reported; *bits stay as they were, and the next Sync tries again.
/// Finalize comes exactly once, before destruction.
class ALABASTER_API Prim {
 public:
  explicit Prim(Path id) : id_(id) {}
  virtual ~Prim();
  const Path& GetId() const { return id_; }
  virtual DirtyBits GetInitialDirtyBitsMask() const = 0;
  virtual void Sync(SceneDelegate* scene, RenderParam* param, DirtyBits* bits) = 0;
  virtual void Finalize(RenderParam* param) = 0;

 private:
  Path id_;
};

/// Rprims may be synced in parallel, each by one thread.
class ALABASTER_API Rprim : public Prim {
 public:
  using Prim::Prim;
  /// Assigned by the index before the first Sync; may change (kPrimId). 0 is valid, 24 bits.
  void SetPrimId(int32_t id) { prim_id_ = id; }
  int32_t GetPrimId() const { return prim_id_; }

 private:
  int32_t prim_id_ = 0;
};

class ALABASTER_API Sprim : public Prim {
 public:
  using Prim::Prim;
};

class ALABASTER_API Bprim : public Prim {
 public:
  using Prim::Prim;
};

/// Changes pixels on their way to a caller's memory: a display transform (host/display_transform.h), or the host's own.
class ALABASTER_API PixelTransform {
 public:
  virtual ~PixelTransform();
  /// In place: four floats a pixel, RGBA, premultiplied. A buffer of fewer components has 0 for those that it lacks,
  /// and alpha 1. Called by several threads at once. Must not throw.
  virtual void Apply(std::span<float> rgba) const = 0;
};

/// Memory of the caller's that shows a buffer, for RenderBuffer::ResolveTo.
struct PixelMemory {
  void* pixels = nullptr;
  size_t rowBytes = 0;  // from the begin of a row to that of the next; at least a row of pixels
  Vec2i size{0, 0};
  Format format = Format::invalid;
  bool yDown = true;                          // the uppermost row comes first
  const PixelTransform* transform = nullptr;  // null: none
  /// The picture that the memory holds. ResolveTo sets it, and then writes only what has changed since. The caller sets
  /// it to 0 wherever it has changed the pixels, another field or the transform, or takes another buffer.
  uint64_t shown = 0;
};

/// Host-readable pixels. Rows run BOTTOM-UP. The delegate writes, the host maps.
class ALABASTER_API RenderBuffer : public Bprim {
 public:
  using Bprim::Bprim;
  /// Takes effect at the next Execute; never invalidates a live mapping; an equal description is a no-op.
  virtual bool Allocate(const RenderBufferDescriptor& description) = 0;
  virtual int GetWidth() const = 0;
  virtual int GetHeight() const = 0;
  virtual Format GetFormat() const = 0;
  /// Makes Map show what has been rendered so far. Any thread.
  virtual void Resolve() = 0;
  /// The pixels as last resolved, alive until the matching Unmap whatever happens to the buffer meanwhile. Null if
  /// nothing is allocated, or if memory ran out in Resolve and does so again. Any thread; nests. Unmap before
  /// destroying: pixels that are still mapped then live until the delegate dies.
  virtual const void* Map() = 0;
  virtual void Unmap() = 0;
  virtual bool IsMapped() const = 0;
  /// Latched at Execute, together with the pass.
  virtual bool IsConverged() const = 0;
  /// Rises with every Resolve that changed pixels: a host may skip uploads.
  virtual uint64_t GetGeneration() const = 0;
  /// Resolve, then writes the tiles that `memory` does not show yet, in its format, on the threads of the caller's TBB
  /// arena. Size and pixels are those of one moment: where the buffer has another size, nothing is written, and
  /// memory->size becomes the buffer's (0 x 0 before Allocate). True if the memory shows the picture. Any thread.
  virtual bool ResolveTo(PixelMemory* memory) = 0;
};

struct AovBinding {
  Token aovName;
  RenderBuffer* renderBuffer = nullptr;  // the host's: alive until the pass ends, converges or is rebound
  Value clearValue;
  bool operator==(const AovBinding&) const = default;
};

/// The arguments of Execute. A copyable value.
struct RenderPassState {
  Path camera;                                  // a camera Sprim; empty: the RenderSettings' camera
  std::optional<CameraDescription> freeCamera;  // in its place
  /// Render tags of the meshes that are drawn. Empty: all but `hidden`.
  std::vector<Token> renderTags{"geometry", "render"};
  Collection collection;
  Framing framing;
  WindowPolicy windowPolicy = WindowPolicy::matchVertically;
  std::vector<AovBinding> aovBindings;
  bool operator==(const RenderPassState&) const = default;
};

/// A render that Stop ended stays `stopped` after Restart, until the next Execute begins it again.
enum class PassState { idle, preparing, rendering, paused, stopped, converged, failed };

/// Execute never renders in the calling thread: it restarts the render that is running only if something differs that
/// its picture depends on, and returns. Other render tags, or another collection, are another
/// scene of the same meshes: nothing is synced or refined for it, and passes may differ in them. Meshes that no pass
/// has drawn yet are refined when one does. If the scene is being built, the render begins once it is there.
class ALABASTER_API RenderPass {
 public:
  virtual ~RenderPass();
  virtual void Execute(const RenderPassState& state) = 0;
  /// True one Execute after the final pixels can be resolved; also true after a failure (see GetState).
  virtual bool IsConverged() const = 0;
  virtual PassState GetState() const = 0;
  /// Waits until the render is over (true: the next Execute latches it) or for `seconds`, or infinity. Any thread.
  virtual bool WaitForConvergence(double seconds) = 0;
};

}  // namespace alabaster::hd
