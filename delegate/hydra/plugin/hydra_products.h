// The products of a scene's render settings, as files, which hosts such as usdrecord expect of a batch render.
#pragma once

#include <pxr/imaging/hd/renderIndex.h>
#include <pxr/imaging/hd/renderSettings.h>

#include <atomic>
#include <map>
#include <optional>

#include "delegate/host/product_writer.h"
#include "delegate/hydra/pass_driver.h"
#include "delegate/hydra/plugin/convert.h"

namespace alabaster::hydra {

/// Renders products one after the other, each by a pass of its own, and writes each once it has converged. Host thread.
class HydraProducts {
 public:
  /// `delegate` must outlive it.
  HydraProducts(hd::RenderDelegate* delegate, hd::DiagnosticSink sink) : delegate_(delegate), sink_(std::move(sink)) {}
  ~HydraProducts() { stop(); }

  /// Those of the active render settings prim; none: there is none.
  void set(const pxr::HdRenderSettings::RenderProducts& products, const std::vector<hd::Token>& render_tags);
  bool empty() const { return products_.empty(); }
  /// A prim was synced or removed. Any thread. OpenUSD's own count of changes lies behind containers of its TBB, whose
  /// size this library does not know.
  void SceneChanged() { ++changes_; }

  /// Begins with what is not written yet, and from the start where the scene has changed since all were. The index has
  /// the cameras.
  void Execute(const pxr::HdRenderIndex& index);
  /// True when all are written, or were refused.
  bool IsConverged(const pxr::HdRenderIndex& index);

 private:
  struct Running {
    hd::host::ProductImage image;
    hd::RenderProduct product;
    std::map<hd::Token, hd::RenderBuffer*> buffers;  // by AOV
    std::unique_ptr<PassDriver> driver;
  };
  hd::RenderProduct to_product(const pxr::HdRenderSettings::RenderProduct& product) const;
  bool begin(const pxr::HdRenderSettings::RenderProduct& product, const pxr::HdRenderIndex& index);
  bool bind(const hd::RenderProduct& product, hd::RenderPassState* state);
  void write();
  void stop();
  void fault(const pxr::HdRenderSettings::RenderProduct& product, const std::string& text) const;

  hd::RenderDelegate* delegate_;
  hd::DiagnosticSink sink_;
  pxr::HdRenderSettings::RenderProducts products_;
  std::vector<hd::Token> render_tags_;
  size_t next_ = 0;  // the first that was not begun
  std::atomic<unsigned> changes_ = 0;
  unsigned changes_seen_ = 0;  // when the first was begun
  std::optional<Running> running_;
};

}  // namespace alabaster::hydra
