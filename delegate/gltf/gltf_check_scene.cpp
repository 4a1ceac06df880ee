// Checks nodes, scenes, cameras and lights (glTF 2.0, sections 3.5, 3.10; KHR_lights_punctual).
#include <algorithm>
#include <cmath>

#include "delegate/gltf/gltf_document.h"

namespace alabaster::hd::gltf {
namespace {

// Each node has at most one parent and no node is its own ancestor. Not recursive: chains may be long.
void check_trees(const Json& nodes, Report& report, std::vector<int64_t>* parents) {
  parents->assign(nodes.size(), -1);
  for (size_t n = 0; n < nodes.size(); ++n) {
    if (!nodes[n].contains("children")) continue;
    for (const Json& child : nodes[n]["children"]) {
      int64_t& parent = (*parents)[child.get<size_t>()];
      if (parent >= 0 && parent != int64_t(n))
        report.error("node.parents", element_name("nodes", child.get<size_t>()),
                     "is a child of nodes[" + std::to_string(parent) + "] and of nodes[" + std::to_string(n) +
                         "]; nodes must form trees, so duplicate the node");
      parent = int64_t(n);
    }
  }
  if (report.failed()) return;
  // Each node has at most one parent, so one that is not reached from a root lies on or below a cycle.
  std::vector<char> reached(nodes.size(), 0);
  std::vector<size_t> open;
  for (size_t n = 0; n < nodes.size(); ++n)
    if ((*parents)[n] < 0) open.push_back(n);
  while (!open.empty()) {
    const size_t n = open.back();
    open.pop_back();
    if (reached[n]) continue;  // a child listed twice
    reached[n] = 1;
    if (nodes[n].contains("children"))
      for (const Json& child : nodes[n]["children"]) open.push_back(child.get<size_t>());
  }
  for (size_t n = 0; n < nodes.size(); ++n)
    if (!reached[n])
      return report.error("node.cycle", element_name("nodes", n), "is its own descendant; break the cycle");
}

void check_transform(const Json& node, const std::string& element, Report& report) {
  if (node.contains("matrix")) {
    const auto m = node["matrix"].get<std::vector<double>>();
    if (node.contains("translation") || node.contains("rotation") || node.contains("scale"))
      report.warning("node.transform", element, "has a matrix and translation, rotation or scale; the matrix is used");
    const double determinant =
        m[0] * (m[5] * m[10] - m[6] * m[9]) - m[4] * (m[1] * m[10] - m[2] * m[9]) + m[8] * (m[1] * m[6] - m[2] * m[5]);
    if (m[3] != 0 || m[7] != 0 || m[11] != 0 || m[15] != 1)
      report.warning("node.transform", element + ".matrix", "the last row is not 0 0 0 1; it is replaced by that");
    if (determinant == 0)
      report.warning("node.transform", element + ".matrix", "is singular, so everything below it is flat");
  }
  if (node.contains("rotation")) {
    double length2 = 0;
    for (const Json& value : node["rotation"]) length2 += value.get<double>() * value.get<double>();
    if (!(std::abs(length2 - 1) < 1e-3))
      report.warning("node.rotation", element + ".rotation", "is not a unit quaternion and is normalized");
  }
}

void check_scenes(const Json& root, const std::vector<int64_t>& parents, Report& report) {
  if (!root.contains("scenes")) return;
  for (size_t s = 0; s < root["scenes"].size(); ++s) {
    const Json& scene = root["scenes"][s];
    if (!scene.contains("nodes")) continue;
    for (const Json& node : scene["nodes"])
      if (parents[node.get<size_t>()] >= 0)
        report.warning("scene.root", element_name("scenes", s),
                       "nodes[" + std::to_string(node.get<size_t>()) + "] is not a root but the child of another node");
  }
}

void check_cameras(const Json& cameras, Report& report) {
  for (size_t c = 0; c < cameras.size(); ++c) {
    const Json& camera = cameras[c];
    const std::string element = element_name("cameras", c), type = camera["type"].get<std::string>();
    if (!camera.contains(type)) {
      report.error("camera", element_name(element, type), "is required and missing; export the file again");
      continue;
    }
    if (camera.contains("perspective") && camera.contains("orthographic"))
      report.warning("camera", element, "has two projections; the one named by type is used");
    const Json& lens = camera[type];
    if (lens.contains("zfar") && lens["zfar"].get<double>() <= lens["znear"].get<double>())
      report.warning("camera", element + ".zfar", "is not greater than znear; no far plane is used");
    if (type == "orthographic")
      for (const char* size : {"xmag", "ymag"})
        if (lens[size].get<double>() <= 0)
          report.warning("camera", element_name(element, size), "must be positive; the absolute value is used");
  }
}

void check_lights(const Json& root, Report& report) {
  if (!root.contains("extensions") || !root["extensions"].contains("KHR_lights_punctual")) return;
  const Json& lights = root["extensions"]["KHR_lights_punctual"]["lights"];
  if (std::any_of(lights.begin(), lights.end(), [](const Json& light) { return light.contains("range"); }))
    report.info("light", "extensions.KHR_lights_punctual",
                "range is not used: light falls with the square of the distance, however far");
  for (size_t l = 0; l < lights.size(); ++l) {
    if (lights[l]["type"] != "spot") continue;
    const std::string element = element_name("extensions.KHR_lights_punctual.lights", l) + ".spot";
    if (!lights[l].contains("spot")) {
      report.error("light", element, "is required and missing; export the file again");
    } else if (lights[l]["spot"].value("innerConeAngle", 0.0) >=
               lights[l]["spot"].value("outerConeAngle", 0.7853981633974483)) {
      report.warning("light", element, "innerConeAngle must be smaller than outerConeAngle; the edge is sharp");
    }
  }
}

}  // namespace

void check_scene(const Json& root, Report& report) {
  std::vector<int64_t> parents;
  if (root.contains("nodes")) {
    const Json& nodes = root["nodes"];
    check_trees(nodes, report, &parents);
    for (size_t n = 0; n < nodes.size(); ++n) {
      const std::string element = element_name("nodes", n);
      check_transform(nodes[n], element, report);
      if (nodes[n].contains("skin") && !nodes[n].contains("mesh"))
        report.warning("node.skin", element, "has a skin but no mesh");
    }
  }
  if (report.failed()) return;
  check_scenes(root, parents, report);
  if (root.contains("cameras")) check_cameras(root["cameras"], report);
  check_lights(root, report);
}

}  // namespace alabaster::hd::gltf
