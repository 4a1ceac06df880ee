// Nodes, scenes, cameras and lights (glTF 2.0, sections 3.5, 3.10; KHR_lights_punctual), and what nodes do to meshes:
// skins, morph weights (section 3.7.3) and instances (EXT_mesh_gpu_instancing).
#include <algorithm>
#include <cmath>
#include <map>

#include "delegate/gltf/gltf_document.h"

namespace alabaster::hd::gltf {
namespace {

class NodeCheck : DocumentCheck {
 public:
  using DocumentCheck::DocumentCheck;

  void run() {
    check_trees();
    for (size_t n = 0; n < nodes().size(); ++n) {
      check_transform(nodes()[n], element_name("nodes", n));
      if (nodes()[n].contains("skin") && !nodes()[n].contains("mesh"))
        report_.warning("node.skin", element_name("nodes", n), "has a skin but no mesh");
    }
    if (report_.failed()) return;
    check_scenes();
    for (size_t c = 0; c < list("cameras").size(); ++c) check_camera(list("cameras")[c], element_name("cameras", c));
    check_lights();
    if (report_.failed()) return;
    for (size_t s = 0; s < list("skins").size(); ++s) check_skin(list("skins")[s], element_name("skins", s));
    for (size_t n = 0; n < nodes().size() && !report_.failed(); ++n)
      check_mesh_of(nodes()[n], element_name("nodes", n));
    hold_more(&document_.memory, instances_ * sizeof(Matrix4d), std::to_string(instances_) + " instances of nodes");
  }

 private:
  const Json& nodes() const { return list("nodes"); }

  // Each node has at most one parent and no node is its own ancestor. Not recursive: chains may be long.
  void check_trees() {
    std::vector<int64_t>& parents = document_.parents;
    parents.assign(nodes().size(), -1);
    for (size_t n = 0; n < nodes().size(); ++n)
      for (const Json& child : at(nodes()[n], "children")) {
        int64_t& parent = parents[child.get<size_t>()];
        if (parent >= 0 && parent != int64_t(n))
          report_.error("node.parents", element_name("nodes", child.get<size_t>()),
                        "is a child of nodes[" + std::to_string(parent) + "] and of nodes[" + std::to_string(n) +
                            "]; nodes must form trees, so duplicate the node");
        parent = int64_t(n);
      }
    if (report_.failed()) return;
    // Each node has at most one parent, so one that is not reached from a root lies on or below a cycle.
    trees_.assign(nodes().size(), -1);
    std::vector<size_t> open;
    for (size_t root = 0; root < nodes().size(); ++root) {
      if (parents[root] < 0) open.push_back(root);
      while (!open.empty()) {
        const size_t n = open.back();
        open.pop_back();
        if (trees_[n] >= 0) continue;  // a child listed twice
        trees_[n] = int64_t(root);
        for (const Json& child : at(nodes()[n], "children")) open.push_back(child.get<size_t>());
      }
    }
    if (const auto lost = std::find(trees_.begin(), trees_.end(), -1); lost != trees_.end())
      report_.error("node.cycle", element_name("nodes", size_t(lost - trees_.begin())),
                    "is its own descendant; break the cycle");
  }

  void check_transform(const Json& node, const std::string& element) {
    if (node.contains("matrix")) {
      const auto m = node["matrix"].get<std::vector<double>>();
      if (node.contains("translation") || node.contains("rotation") || node.contains("scale"))
        report_.warning("node.transform", element,
                        "has a matrix and translation, rotation or scale; the matrix is used");
      const double determinant = m[0] * (m[5] * m[10] - m[6] * m[9]) - m[4] * (m[1] * m[10] - m[2] * m[9]) +
                                 m[8] * (m[1] * m[6] - m[2] * m[5]);
      if (m[3] != 0 || m[7] != 0 || m[11] != 0 || m[15] != 1)
        report_.warning("node.transform", element + ".matrix", "the last row is not 0 0 0 1; it is replaced by that");
      if (determinant == 0)
        report_.warning("node.transform", element + ".matrix", "is singular, so everything below it is flat");
    }
    double length2 = 0;
    for (const Json& value : at(node, "rotation")) length2 += value.get<double>() * value.get<double>();
    if (node.contains("rotation") && !(std::abs(length2 - 1) < 1e-3))
      report_.warning("node.rotation", element + ".rotation", "is not a unit quaternion and is normalized");
  }

  void check_scenes() {
    for (size_t s = 0; s < list("scenes").size(); ++s)
      for (const Json& node : at(list("scenes")[s], "nodes"))
        if (document_.parents[node.get<size_t>()] >= 0)
          report_.warning("scene.root", element_name("scenes", s),
                          "nodes[" + node.dump() + "] is not a root but the child of another node");
  }

  void check_camera(const Json& camera, const std::string& element) {
    const std::string type = camera["type"].get<std::string>();
    const Json& lens = at(camera, type);
    if (lens.is_null())
      return report_.error("camera", element_name(element, type), "is required and missing; export the file again");
    if (camera.contains("perspective") && camera.contains("orthographic"))
      report_.warning("camera", element, "has two projections; the one named by type is used");
    if (lens.contains("zfar") && lens["zfar"].get<double>() <= lens["znear"].get<double>())
      report_.warning("camera", element + ".zfar", "is not greater than znear; no far plane is used");
    for (const char* size : {"xmag", "ymag"})
      if (type == "orthographic" && lens[size].get<double>() <= 0)
        report_.warning("camera", element_name(element, size), "must be positive; the absolute value is used");
  }

  void check_lights() {
    const Json& lights = at(extension_of(root_, "KHR_lights_punctual"), "lights");
    if (std::any_of(lights.begin(), lights.end(), [](const Json& light) { return light.contains("range"); }))
      report_.info("light", "extensions.KHR_lights_punctual",
                   "range is not used: light falls with the square of the distance, however far");
    for (size_t l = 0; l < lights.size(); ++l) {
      if (lights[l]["type"] != "spot") continue;
      const std::string element = element_name("extensions.KHR_lights_punctual.lights", l) + ".spot";
      const Json& spot = at(lights[l], "spot");
      if (spot.is_null())
        report_.error("light", element, "is required and missing; export the file again");
      else if (spot.value("innerConeAngle", 0.0) >= spot.value("outerConeAngle", 0.7853981633974483))
        report_.warning("light", element, "innerConeAngle must be smaller than outerConeAngle; the edge is sharp");
    }
  }

  void check_skin(const Json& skin, const std::string& element) {
    const auto tree_of = [&](const Json& node) { return trees_[node.get<size_t>()]; };
    const Json& joints = skin["joints"];
    int64_t tree = skin.contains("skeleton") ? tree_of(skin["skeleton"]) : joints.empty() ? -1 : tree_of(joints[0]);
    if (std::any_of(joints.begin(), joints.end(), [&](const Json& joint) { return tree_of(joint) != tree; }))
      report_.warning("skin.root", element, "its joints and its skeleton have no common root");
    if (!skin.contains("inverseBindMatrices")) return;
    const AccessorView& view = accessor(skin["inverseBindMatrices"]);
    const std::string place = element + ".inverseBindMatrices";
    if (view.type != "MAT4" || view.component_type != kFloat)
      return report_.error("skin.matrices", place, "must be MAT4 of floats; export the file again");
    if (view.count < joints.size())
      return report_.error("skin.matrices", place,
                           "has " + std::to_string(view.count) + " matrices, but the skin has " +
                               std::to_string(joints.size()) + " joints; export the file again");
    if (const auto matrix = first_not_finite(view))
      return report_.error("skin.matrices", place,
                           "matrix " + std::to_string(*matrix) + " is not of finite numbers; export the file again");
    const std::vector<float> m = read_floats(view);
    for (size_t i = 0; i < m.size(); i += 16)
      if (m[i + 3] != 0 || m[i + 7] != 0 || m[i + 11] != 0 || m[i + 15] != 1)
        return report_.warning(
            "skin.matrices", place,
            "the last row of matrix " + std::to_string(i / 16) + " is not 0 0 0 1; it is replaced by that");
  }

  void check_mesh_of(const Json& node, const std::string& element) {
    const Json& instancing = extension_of(node, "EXT_mesh_gpu_instancing");
    const bool instanced = !instancing.is_null();
    if (instanced)
      check_instances(instancing["attributes"], element + ".extensions.EXT_mesh_gpu_instancing.attributes");
    if (instanced && !node.contains("mesh"))
      report_.warning("node.instances", element, "has instances but no mesh; nothing is drawn");
    if (!node.contains("mesh")) return;
    const size_t targets = target_count(list("meshes")[node["mesh"].get<size_t>()]),
                 weights = at(node, "weights").size();
    if (node.contains("weights") && weights != targets)
      report_.warning("node.weights", element + ".weights",
                      std::to_string(weights) + " are given, but the mesh has " + std::to_string(targets) +
                          " morph targets; missing ones are 0");
    if (!node.contains("skin")) return;
    check_skinned(node, element);
    if (instanced)
      report_.warning("node.instances", element,
                      "has a skin, which places the mesh, and instances, which are ignored; remove one");
  }

  void check_skinned(const Json& node, const std::string& element) {
    const size_t skin = node["skin"].get<size_t>(), mesh = node["mesh"].get<size_t>();
    const size_t joints = list("skins")[skin]["joints"].size();
    const Json& primitives = list("meshes")[mesh]["primitives"];
    if (joints == 0)
      return report_.error("skin.joints", element_name("skins", skin),
                           "has no joints; remove the skin from " + element);
    for (size_t p = 0; p < primitives.size(); ++p) {
      const Json& attributes = primitives[p]["attributes"];
      const std::string place = element_name(element_name("meshes", mesh) + ".primitives", p) + ".attributes";
      if (!attributes.contains("JOINTS_0") || !attributes.contains("WEIGHTS_0"))
        report_.warning("skin.attributes", place,
                        "lack JOINTS_0 or WEIGHTS_0, so the skin of " + element + " does not move the primitive");
      for (int set = 0;; ++set) {
        const std::string number = std::to_string(set);
        if (!attributes.contains("JOINTS_" + number) || !attributes.contains("WEIGHTS_" + number)) break;
        check_influences(attributes["JOINTS_" + number], attributes["WEIGHTS_" + number], joints, place);
      }
    }
  }

  // The joints of influences without weight may be any number.
  void check_influences(const Json& joints, const Json& weights, size_t count, const std::string& place) {
    const auto [found, is_new] =
        largest_joint_.try_emplace({joints.get<size_t>(), weights.get<size_t>()}, std::pair<size_t, size_t>());
    if (is_new) {
      const std::vector<float> j = read_floats(accessor(joints)), w = read_floats(accessor(weights));
      for (size_t i = 0; i < std::min(j.size(), w.size()); ++i) {
        if (!(w[i] >= 0 && w[i] <= std::numeric_limits<float>::max()))
          return report_.error("skin.weights", place,
                               "the weights of vertex " + std::to_string(i / 4) +
                                   " are not finite numbers from 0 up; export the file again");
        if (w[i] > 0 && size_t(j[i]) > found->second.first) found->second = {size_t(j[i]), i / 4};
      }
    }
    if (found->second.first >= count)
      report_.error("skin.joints", place,
                    "vertex " + std::to_string(found->second.second) + " follows joint " +
                        std::to_string(found->second.first) + ", but the skin has " + std::to_string(count) +
                        "; export the file again");
  }

  void check_instances(const Json& attributes, const std::string& element) {
    std::optional<size_t> count;
    for (const auto& [name, index] : attributes.items()) {
      const AccessorView& view = accessor(index);
      const std::string place = element_name(element, name);
      if (view.count != count.value_or(view.count))
        return report_.error("node.instances", place, "has another number of elements; export the file again");
      count = view.count;
      const bool rotation = name == "ROTATION";
      if (name != "TRANSLATION" && name != "SCALE" && !rotation) continue;  // of the application's own
      const bool integers = rotation && view.normalized && component_size(view.component_type) < 4;
      if (view.type != (rotation ? "VEC4" : "VEC3") || (view.component_type != kFloat && !integers))
        return report_.error("node.instances", place,
                             rotation ? "must be VEC4 of floats or normalized integers; export the file again"
                                      : "must be VEC3 of floats; export the file again");
      if (const auto instance = first_not_finite(view))
        return report_.error("node.instances", place,
                             "instance " + std::to_string(*instance) + " is not finite; export the file again");
    }
    instances_ += count.value_or(0);
  }

  std::map<std::pair<size_t, size_t>, std::pair<size_t, size_t>> largest_joint_;  // and its vertex, by accessors
  std::vector<int64_t> trees_;                                                    // the root of each node's tree
  uint64_t instances_ = 0;
};

}  // namespace

void check_nodes(const Json& root, Report& report, Document* document) {
  NodeCheck(root, document, report).run();
}

}  // namespace alabaster::hd::gltf
