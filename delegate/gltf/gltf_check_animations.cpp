// Checks animations (glTF 2.0, section 3.11) and finds their lengths. A fault of an animation that is not used is only
// a warning.
#include <cmath>
#include <map>
#include <set>

#include "delegate/gltf/gltf_document.h"

namespace alabaster::hd::gltf {
namespace {

class AnimationCheck : DocumentCheck {
 public:
  using DocumentCheck::DocumentCheck;

  // Removes channels that change nothing. Returns the time of the last key.
  double run(Json& animation, const std::string& element, bool used) {
    used_ = used;
    double last = 0;
    for (size_t s = 0; s < animation["samplers"].size(); ++s)
      last = std::max(
          last, check_times(animation["samplers"][s]["input"], element_name(element + ".samplers", s) + ".input"));
    std::set<std::string> targets;
    Json kept = Json::array();
    for (size_t c = 0; c < animation["channels"].size(); ++c) {
      const Json& channel = animation["channels"][c];
      const std::string place = element_name(element + ".channels", c);
      if (!moves_something(channel, place) || !check_channel(animation, channel, place)) continue;
      if (targets.insert(channel["target"]["node"].dump() + channel["target"]["path"].dump()).second) {
        kept.push_back(channel);
      } else {
        report_.warning("animation.target", place, "moves what another channel moves already; it is ignored");
      }
    }
    animation["channels"] = std::move(kept);
    return last;
  }

 private:
  // Returns false.
  bool fault(const std::string& place, const std::string& text) {
    if (used_)
      report_.error("animation", place, text + "; export the file again");
    else
      report_.warning("animation", place, text + "; the animation is not used");
    return false;
  }

  // The last time; 0 after a fault.
  double check_times(const Json& index, const std::string& place) {
    const AccessorView& view = accessor(index);
    const auto [last, is_new] = last_time_.try_emplace(index.get<size_t>(), 0);
    if (!is_new) return last->second;
    if (view.type != "SCALAR" || view.component_type != kFloat) return fault(place, "must be scalars of floats");
    count_bytes(view, place);
    const std::vector<float> times = read_floats(view);
    for (size_t k = 0; k < times.size(); ++k)
      if (!std::isfinite(times[k]) || times[k] < 0 || (k > 0 && times[k] <= times[k - 1]))
        return fault(place, "time " + std::to_string(k) + " is not finite, negative or not after the one before");
    return last->second = double(times.back());
  }

  void count_bytes(const AccessorView& view, const std::string& place) {
    hold_more(&document_.memory, view.count * view.components * sizeof(float), place);
  }

  bool moves_something(const Json& channel, const std::string& place) {
    const Json& target = channel["target"];
    const std::string path = target["path"];
    const auto left_out = [&](const std::string& why) {
      report_.warning("animation.target", place, why);
      return false;
    };
    if (path == "pointer")
      return left_out("KHR_animation_pointer is not supported; the target of the channel stays as it is");
    if (path != "translation" && path != "rotation" && path != "scale" && path != "weights")
      return left_out("'" + path.substr(0, 60) + "' cannot be animated; the channel is ignored");
    if (!target.contains("node")) return left_out("has no node; the channel is ignored");
    const Json& node = list("nodes")[target["node"].get<size_t>()];
    const std::string name = element_name("nodes", target["node"].get<size_t>());
    if (path != "weights" && node.contains("matrix"))
      return left_out(name + " has a matrix, which cannot be animated; the channel is ignored");
    if (path == "weights" && targets_of(node) == 0)
      return left_out(name + " has no morph targets; the channel is ignored");
    return true;
  }

  size_t targets_of(const Json& node) const {
    return node.contains("mesh") ? target_count(list("meshes")[node["mesh"].get<size_t>()]) : 0;
  }

  bool check_channel(const Json& animation, const Json& channel, const std::string& place) {
    const size_t index = channel["sampler"].get<size_t>(), count = animation["samplers"].size();
    if (index >= count)
      return fault(place + ".sampler",
                   std::to_string(index) + " is out of range: the animation has " + std::to_string(count));
    const Json& sampler = animation["samplers"][index];
    const AccessorView &times = accessor(sampler["input"]), &values = accessor(sampler["output"]);
    const bool spline = sampler.value("interpolation", "LINEAR") == "CUBICSPLINE";
    const std::string path = channel["target"]["path"], output = place + " (sampler " + std::to_string(index) + ")";
    const bool weights = path == "weights", rotation = path == "rotation";
    const bool integers = (weights || rotation) && values.normalized && component_size(values.component_type) < 4;
    const char* type = weights ? "SCALAR" : rotation ? "VEC4" : "VEC3";
    if (values.type != type || (values.component_type != kFloat && !integers))
      return fault(output, "the values of " + path + " must be " + type + " of floats" +
                               (weights || rotation ? " or normalized integers" : ""));
    const size_t each =
        (spline ? 3 : 1) * (weights ? targets_of(list("nodes")[channel["target"]["node"].get<size_t>()]) : 1);
    if (values.count != times.count * each)
      return fault(output, "has " + std::to_string(times.count) + " times and " + std::to_string(values.count) +
                               " values, not " + std::to_string(times.count * each));
    if (spline && times.count < 2)
      report_.warning("animation", output, "a spline needs two keys; the value of the only one is held");
    if (!checked_values_.insert(&values).second) return true;
    count_bytes(values, output);
    if (const auto element = first_not_finite(values))
      return fault(output, "value " + std::to_string(*element) + " is not a finite number");
    return true;
  }

  bool used_ = false;
  std::map<size_t, double> last_time_;  // by accessor
  std::set<const AccessorView*> checked_values_;
};

}  // namespace

void check_animations(Json& root, Report& report, Document* document) {
  if (!root.contains("animations")) return;
  Json animations = std::move(root["animations"]), used = Json::array();
  AnimationCheck check(root, document, report);
  for (size_t a = 0; a < animations.size() && !report.failed(); ++a) {
    const bool is_used = int(a) == document->animation;
    document->facts.animations[a].seconds = check.run(animations[a], element_name("animations", a), is_used);
    if (is_used) used.push_back(std::move(animations[a]));
  }
  root["animations"] = std::move(used);
}

}  // namespace alabaster::hd::gltf
