// Checks what nodes do to meshes: skins, morph weights (glTF 2.0, section 3.7.3) and instances
// (EXT_mesh_gpu_instancing).
#include <map>

#include "delegate/gltf/gltf_document.h"
#include "delegate/gltf/gltf_morph.h"

namespace alabaster::hd::gltf {
namespace {

class NodeMeshCheck {
 public:
  NodeMeshCheck(const Json& root, const Document& document, Report& report)
      : root_(root), document_(document), report_(report) {}

  /// The number of instances.
  size_t run() {
    if (root_.contains("skins"))
      for (size_t s = 0; s < root_["skins"].size(); ++s) check_skin(root_["skins"][s], element_name("skins", s));
    if (!root_.contains("nodes")) return 0;
    for (size_t n = 0; n < root_["nodes"].size() && !report_.failed(); ++n) {
      const Json& node = root_["nodes"][n];
      const std::string element = element_name("nodes", n);
      const bool instanced = node.contains("extensions") && node["extensions"].contains("EXT_mesh_gpu_instancing");
      if (instanced)
        check_instances(node["extensions"]["EXT_mesh_gpu_instancing"]["attributes"],
                        element + ".extensions.EXT_mesh_gpu_instancing.attributes");
      if (instanced && !node.contains("mesh"))
        report_.warning("node.instances", element, "has instances but no mesh; nothing is drawn");
      if (!node.contains("mesh")) continue;
      check_weights(node, element);
      if (node.contains("skin")) check_skinned(node, element);
      if (node.contains("skin") && instanced)
        report_.warning("node.instances", element,
                        "has a skin, which places the mesh, and instances, which are ignored; remove one");
    }
    return instances_;
  }

 private:
  const AccessorView& accessor(const Json& index) const { return document_.accessors[index.get<size_t>()]; }

  // The number of its tree for every node. Nodes have one parent at most, and no node is its own ancestor.
  std::vector<size_t> find_trees() const {
    const Json& nodes = root_["nodes"];
    std::vector<char> is_child(nodes.size(), 0);
    for (const Json& node : nodes)
      for (const Json& child : node.value("children", Json::array())) is_child[child.get<size_t>()] = 1;
    std::vector<size_t> trees(nodes.size()), open;
    for (size_t root = 0; root < nodes.size(); ++root) {
      if (is_child[root]) continue;
      open.push_back(root);
      while (!open.empty()) {
        const size_t n = open.back();
        open.pop_back();
        trees[n] = root;
        if (nodes[n].contains("children"))
          for (const Json& child : nodes[n]["children"])
            if (trees[child.get<size_t>()] != root) open.push_back(child.get<size_t>());
      }
    }
    return trees;
  }

  void check_skin(const Json& skin, const std::string& element) {
    if (trees_.empty() && root_.contains("nodes")) trees_ = find_trees();
    std::optional<size_t> tree;
    if (skin.contains("skeleton")) tree = trees_[skin["skeleton"].get<size_t>()];
    for (const Json& joint : skin["joints"])
      if (tree && trees_[joint.get<size_t>()] != *tree) {
        report_.warning("skin.root", element, "its joints and its skeleton have no common root");
        break;
      } else {
        tree = trees_[joint.get<size_t>()];
      }
    if (!skin.contains("inverseBindMatrices")) return;
    const AccessorView& view = accessor(skin["inverseBindMatrices"]);
    const std::string place = element + ".inverseBindMatrices";
    const size_t joints = skin["joints"].size();
    if (view.type != "MAT4" || view.component_type != kFloat)
      return report_.error("skin.matrices", place, "must be MAT4 of floats; export the file again");
    if (view.count < joints)
      return report_.error("skin.matrices", place,
                           "has " + std::to_string(view.count) + " matrices, but the skin has " +
                               std::to_string(joints) + " joints; export the file again");
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

  void check_skinned(const Json& node, const std::string& element) {
    const size_t joints = root_["skins"][node["skin"].get<size_t>()]["joints"].size();
    const std::string mesh = element_name("meshes", node["mesh"].get<size_t>());
    const Json& primitives = root_["meshes"][node["mesh"].get<size_t>()]["primitives"];
    if (joints == 0)
      return report_.error("skin.joints", element_name("skins", node["skin"].get<size_t>()),
                           "has no joints; remove the skin from " + element);
    for (size_t p = 0; p < primitives.size(); ++p) {
      const Json& attributes = primitives[p]["attributes"];
      const std::string place = element_name(mesh + ".primitives", p) + ".attributes";
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

  void check_weights(const Json& node, const std::string& element) {
    if (!node.contains("weights")) return;
    const size_t targets = target_count(root_["meshes"][node["mesh"].get<size_t>()]);
    if (node["weights"].size() != targets)
      report_.warning("node.weights", element + ".weights",
                      std::to_string(node["weights"].size()) + " are given, but the mesh has " +
                          std::to_string(targets) + " morph targets; missing ones are 0");
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

  const Json& root_;
  const Document& document_;
  Report& report_;
  std::map<std::pair<size_t, size_t>, std::pair<size_t, size_t>> largest_joint_;  // and its vertex, by accessors
  std::vector<size_t> trees_;
  uint64_t instances_ = 0;
};

}  // namespace

void check_node_meshes(const Json& root, Report& report, Document* document) {
  const size_t instances = NodeMeshCheck(root, *document, report).run();
  hold_more(&document->memory, instances * sizeof(Matrix4d), std::to_string(instances) + " instances of nodes");
}

}  // namespace alabaster::hd::gltf
