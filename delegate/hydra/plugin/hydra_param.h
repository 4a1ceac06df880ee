// The delegate, the rules and the drivers that the plug-in's prims, buffers and passes share.
#pragma once

#include <pxr/imaging/hd/renderDelegate.h>

#include <set>

#include "delegate/hydra/pass_driver.h"
#include "delegate/hydra/plugin/convert.h"
#include "delegate/hydra/plugin/hydra_products.h"
#include "delegate/hydra/plugin/hydra_scene.h"
#include "delegate/hydra/scene_capture.h"

namespace alabaster::hydra {

class HydraParam final : public pxr::HdRenderParam {
 public:
  /// `delegate` must outlive it.
  HydraParam(hd::RenderDelegate* delegate, const hd::DiagnosticSink& sink)
      : delegate_(delegate), sink_(sink), products_(delegate, sink) {}

  hd::RenderDelegate& delegate() const { return *delegate_; }
  /// Hydra's setting domeLightCameraVisibility. Lights that were synced before are dirty. Host thread, before Sync.
  void set_domes_visible(bool visible);
  /// A light that was synced, and where it is found.
  void add_light(const pxr::SdfPath& id, pxr::HdRenderIndex* index) { lights_[id] = index; }
  void remove_light(const pxr::SdfPath& id) { lights_.erase(id); }

  /// Setting alabaster:writeScene: a file that holds the scene of the last Execute. Host thread, before Sync.
  void set_scene_file(const std::string& file) {
    scene_file_ = file;
    if (!file.empty() && !capture_) capture_ = std::make_unique<SceneCapture>();
  }
  /// Null unless the scene is written.
  SceneCapture* capture() const { return capture_.get(); }
  void write_scene(const hd::RenderPassState& state) const;

  HydraScene scene(pxr::HdSceneDelegate* host, const pxr::SdfPath& id, const pxr::TfToken& light_type = {}) const {
    return {host, id, domes_visible_, light_type};
  }

  /// Those of the scene's active render settings prim.
  HydraProducts& products() { return products_; }
  /// Hydra's setting enableInteractive is false: products are to be written.
  bool is_batch = false;

  void error(const pxr::SdfPath& id, const char* code, const std::string& text) const {
    sink_({hd::Severity::error, code, id.GetString(), text});
  }
  void warn(const pxr::SdfPath& id, const char* code, const std::string& text) const {
    sink_({hd::Severity::warning, code, id.GetString(), text});
  }

  /// Drivers that may hold a buffer of the host's.
  void add(PassDriver* driver) { drivers_.insert(driver); }
  void remove(PassDriver* driver) { drivers_.erase(driver); }
  void forget(const hd::RenderBuffer* buffer) const {
    for (PassDriver* driver : drivers_) driver->Forget(buffer);
  }

 private:
  hd::RenderDelegate* delegate_;
  hd::DiagnosticSink sink_;
  HydraProducts products_;
  bool domes_visible_ = true;
  std::map<pxr::SdfPath, pxr::HdRenderIndex*> lights_;
  std::set<PassDriver*> drivers_;
  std::string scene_file_;
  std::unique_ptr<SceneCapture> capture_;
};

/// The param that Hydra hands to each Sync and Finalize.
inline HydraParam& ParamOf(pxr::HdRenderParam* param) {
  return *static_cast<HydraParam*>(param);
}

}  // namespace alabaster::hydra
