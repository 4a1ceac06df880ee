// A small frame that tests of the delegate draw again and again.
#pragma once

#include <memory>
#include <string>

#include "testenv/support/stage.h"

namespace alabaster::hd {

/// A pass over the basic scene.
struct Drawing {
  explicit Drawing(int mib) : stage({{"memoryLimit", mib}, {"samples", 1}}) {
    stage.add_basic_scene();
    RenderBuffer* const buffer = stage.add_buffer("/color", 8, 8, Format::float32vec4);
    state = Stage::state_for(8, 8, "color", buffer);
    stage.index->SyncAll();
    pass = stage.delegate->CreateRenderPass();
  }
  bool draw() {
    stage.index->SyncAll();
    return Stage::finish(*pass, state) && pass->GetState() == PassState::converged;
  }
  std::string errors() {
    std::string all;
    for (const Diagnostic& d : stage.take_diagnostics())
      if (d.severity == Severity::error) all += d.where + ": " + d.text + "\n";
    return all;
  }
  Stage stage;
  RenderPassState state;
  std::unique_ptr<RenderPass> pass;
};

}  // namespace alabaster::hd
