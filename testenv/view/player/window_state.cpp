#include "testenv/view/player/window_state.h"

#include <nlohmann/json.hpp>

namespace alabaster::view {

using nlohmann::json;

std::string window_state(const Stage& stage, FrameTimes* times) {
  const ViewSession& session = *stage.session;
  const ViewStatus& status = stage.status;
  const ScreenScale scale = scale_of(stage.window);
  json state{{"samples", status.samples},     {"samplesTotal", status.samples_total}, {"noise", status.noise},
             {"seconds", status.seconds},     {"state", int(status.state)},           {"paused", session.paused()},
             {"aov", session.aov()},          {"exposure", session.exposure()},       {"display", session.display()},
             {"view", session.display_view()}};
  state["size"] = {session.size().x, session.size().y};
  state["scale"] = {scale.content, scale.density};
  state["denoiser"] = status.denoiser;
  for (int i = 0; i < 16; ++i) state["camera"].push_back(session.camera().transform[i / 4][i % 4]);
  if (const auto& picked = stage.picture->picked()) {
    state["picked"] = {{"mesh", picked->hit.path.str()},
                       {"material", picked->material.str()},
                       {"face", picked->hit.face},
                       {"instances", picked->hit.instances.size()}};
  }
  if (const KeptLook* const kept = session.kept_look())
    state["kept"] = {{"samples", kept->samples}, {"isFraming", session.is_kept_framing()}};
  state["filesChanged"] = stage.reload->has_changed();
  state["messages"] = json::array();
  for (const Messages::Entry& entry : stage.messages->all())
    state["messages"].push_back(entry.diagnostic.where + ": " + entry.diagnostic.text);
  const FrameTimes::Summary frames = times->take();
  state["frames"] = {{"count", frames.frames},
                     {"perSecond", frames.per_second},
                     {"workMedianMs", frames.work_median},
                     {"workP95Ms", frames.work_p95},
                     {"intervalP95Ms", frames.interval_p95},
                     {"intervalWorstMs", frames.interval_worst}};
  return state.dump(-1, ' ', false, json::error_handler_t::replace);
}

}  // namespace alabaster::view
