// Meshes (glTF 2.0, section 3.7): checks attributes against semantics and each other, and indices against vertex
// counts.
#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <set>

#include "delegate/gltf/gltf_document.h"

namespace alabaster::hd::gltf {
namespace {

struct Semantic {
  const char* name;
  const char* types;         // "|VEC3|"
  const char* target_types;  // of a morph target; empty: none
  bool numbered = false;     // NAME_n
  bool integers = false;     // allowed without an extension
  bool quantizable = false;  // integers allowed by KHR_mesh_quantization
};
constexpr Semantic kSemantics[] = {{"POSITION", "|VEC3|", "|VEC3|", false, false, true},
                                   {"NORMAL", "|VEC3|", "|VEC3|", false, false, true},
                                   {"TANGENT", "|VEC4|", "|VEC3|", false, false, true},
                                   {"TEXCOORD", "|VEC2|", "|VEC2|", true, true, true},
                                   {"COLOR", "|VEC3|VEC4|", "|VEC3|VEC4|", true, true, false},
                                   {"JOINTS", "|VEC4|", "", true, true, false},
                                   {"WEIGHTS", "|VEC4|", "", true, true, false}};

// The semantic of an attribute such as "TEXCOORD_0"; empty if glTF has none.
std::optional<Semantic> find_semantic(const std::string& attribute) {
  for (const Semantic& semantic : kSemantics) {
    const std::string prefix = semantic.name + std::string(semantic.numbered ? "_" : "");
    if (!semantic.numbered && attribute == prefix) return semantic;
    if (!semantic.numbered || attribute.compare(0, prefix.size(), prefix) != 0) continue;
    const std::string number = attribute.substr(prefix.size());
    if (number == "0" || (!number.empty() && number.size() < 4 && number[0] != '0' &&
                          std::all_of(number.begin(), number.end(), [](char c) { return c >= '0' && c <= '9'; })))
      return semantic;
  }
  return {};
}

// Extensions that are not read are not checked either.
void collect_texture_sets(const Json& value, std::set<int>* sets) {
  if (!value.is_object()) return;
  for (const auto& [name, child] : value.items()) {
    if (name.size() > 7 && name.ends_with("Texture") && child.is_object()) {
      const Json &own = at(child, "texCoord"), &moved = at(extension_of(child, "KHR_texture_transform"), "texCoord");
      sets->insert(moved.is_number_integer() ? moved.get<int>() : own.is_number_integer() ? own.get<int>() : 0);
    } else if (name != "extras") {
      collect_texture_sets(child, sets);
    }
  }
}

// The mappings of KHR_materials_variants.
const Json& mappings_of(const Json& primitive) {
  return at(extension_of(primitive, "KHR_materials_variants"), "mappings");
}

class MeshCheck : DocumentCheck {
 public:
  MeshCheck(const Json& root, Document* document, Report& report)
      : DocumentCheck(root, document, report), index_max_(document->accessors.size()) {
    for (const Json& name : list("extensionsRequired")) quantized_ |= name == "KHR_mesh_quantization";
    copies_.assign(list("meshes").size(), 0);
    const std::set<size_t> morphed = nodes_morphed(document->animation);
    for (size_t n = 0; n < list("nodes").size(); ++n) {
      const Json& node = list("nodes")[n];
      if (node.contains("mesh") && (node.contains("skin") || node.contains("weights") || morphed.contains(n)))
        ++copies_[node["mesh"].get<size_t>()];
    }
  }

  /// Bytes of all meshes when decoded.
  double run() {
    double total_bytes = 0;
    find_alike();
    for (size_t m = 0; m < list("meshes").size(); ++m) {
      const Json& mesh = list("meshes")[m];
      const std::string element = element_name("meshes", m);
      for (size_t p = 0; p < mesh["primitives"].size() && !report_.failed(); ++p)
        check_primitive(mesh["primitives"][p], element_name(element + ".primitives", p));
      check_target_counts(mesh, element);
      // Nodes with a skin, with weights or with animated ones have copies of their own. The others share one.
      total_bytes += double(decoded_bytes_) * double(copies_[m] + (document_.alike[m] == m ? 1 : 0));
      decoded_bytes_ = 0;
    }
    return total_bytes;
  }

 private:
  // The nodes whose morph weights an animation moves; -1: none does.
  std::set<size_t> nodes_morphed(int animation) const {
    std::set<size_t> nodes;
    if (animation < 0) return nodes;
    for (const Json& channel : list("animations")[size_t(animation)]["channels"])
      if (const Json& target = channel["target"]; target["path"] == "weights" && target.contains("node"))
        nodes.insert(target["node"].get<size_t>());
    return nodes;
  }

  // Meshes whose primitives have equal accessors, in one shape by their morph weights, are decoded once. Their
  // materials must agree in doubleSided, which is a part of the mesh, and in being there.
  void find_alike() {
    std::vector<size_t> first_accessor;
    std::map<AccessorView, size_t> accessors;
    for (const AccessorView& view : document_.accessors)
      first_accessor.push_back(accessors.try_emplace(view, first_accessor.size()).first->second);
    const auto accessors_of = [&](const Json& attributes) {
      Json all = Json::object();
      for (const auto& [name, index] : attributes.items()) all[name] = first_accessor[index.get<size_t>()];
      return all;
    };
    std::map<std::string, size_t> meshes;
    for (const Json& mesh : list("meshes")) {
      Json key = Json::array({at(mesh, "weights")});
      for (const Json& primitive : mesh["primitives"]) {
        Json targets = Json::array();
        for (const Json& target : at(primitive, "targets")) targets.push_back(accessors_of(target));
        const Json &indices = at(primitive, "indices"), &material = at(primitive, "material");
        key.push_back({accessors_of(primitive["attributes"]), targets, primitive.value("mode", 4),
                       indices.is_null() ? Json() : Json(first_accessor[indices.get<size_t>()]),
                       material.is_null() ? Json() : Json(is_double_sided(material)), mappings_of(primitive),
                       extension_of(primitive, "FB_ngon_encoding").is_null()});
      }
      document_.alike.push_back(meshes.try_emplace(key.dump(), document_.alike.size()).first->second);
    }
  }

  bool is_double_sided(const Json& material) const {
    return list("materials")[material.get<size_t>()].value("doubleSided", false);
  }

  void check_primitive(const Json& primitive, const std::string& element) {
    const Json& attributes = primitive["attributes"];
    const AccessorView* first = nullptr;
    std::map<int, size_t> views;  // buffer views without a stride -> attributes in them
    for (const auto& [name, index] : attributes.items()) {
      const AccessorView& view = accessor(index);
      const std::string place = element_name(element + ".attributes", name);
      check_attribute(name, view, place, false);
      if (!first) first = &view;
      if (view.count != first->count)
        report_.error("mesh.count", place,
                      "has " + std::to_string(view.count) + " elements, but other attributes have " +
                          std::to_string(first->count) + "; export the file again");
      if (find_semantic(name)) decoded_bytes_ += bytes_used(primitive, view);
      if (view.buffer_view >= 0 && !view.has_stride) ++views[view.buffer_view];
    }
    for (const auto& [view, users] : views)
      if (users > 1)
        report_.warning("bufferView.stride", element_name("bufferViews", size_t(view)),
                        "is shared by several attributes but has no byteStride");
    if (!attributes.contains("POSITION")) {
      report_.warning("mesh.points", element + ".attributes", "has no POSITION; the primitive is not drawn");
    } else if (!report_.failed()) {
      const AccessorView& positions = accessor(attributes["POSITION"]);
      check_bounds(positions, element + ".attributes.POSITION");
      check_finite(positions, element + ".attributes.POSITION");
    }
    check_targets(primitive, first, element);
    if (primitive.contains("indices") && first && !report_.failed())
      check_indices(primitive["indices"], first->count, element + ".indices");
    check_index_count(primitive, first ? first->count : 0, element);
    check_texture_sets(primitive, element);
    check_variants(primitive, element);
  }

  // At most, decoded: vertices that the indices leave out are not read.
  size_t bytes_used(const Json& primitive, const AccessorView& view) const {
    const Json& indices = at(primitive, "indices");
    const size_t most = indices.is_null() ? view.count : accessor(indices).count;
    return std::min(view.count, most) * view.components * sizeof(float);
  }

  void check_targets(const Json& primitive, const AccessorView* first, const std::string& element) {
    const Json& targets = at(primitive, "targets");
    for (size_t t = 0; t < targets.size() && first; ++t)
      for (const auto& [name, index] : targets[t].items()) {
        const AccessorView& view = accessor(index);
        const std::string place = element_name(element_name(element + ".targets", t), name);
        if (!primitive["attributes"].contains(name)) {
          report_.warning("mesh.targets", place, "moves an attribute that the primitive lacks; it is ignored");
        } else if (view.count != first->count) {
          report_.error("mesh.targets", place,
                        "has " + std::to_string(view.count) + " elements, but the primitive has " +
                            std::to_string(first->count) + " vertices; export the file again");
        }
        check_attribute(name, view, place, true);
        if (name == "POSITION") check_bounds(view, place);
        check_finite(view, place);
        if (find_semantic(name)) decoded_bytes_ += bytes_used(primitive, view);
      }
  }

  void check_target_counts(const Json& mesh, const std::string& element) {
    const size_t targets = target_count(mesh);
    for (const Json& primitive : mesh["primitives"])
      if (at(primitive, "targets").size() != targets)
        return report_.warning("mesh.targets", element + ".primitives",
                               "have different numbers of morph targets; weights are taken in the order of each");
    if (mesh.contains("weights") && mesh["weights"].size() != targets)
      report_.warning("mesh.targets", element + ".weights",
                      std::to_string(mesh["weights"].size()) + " are given, but there are " + std::to_string(targets) +
                          " morph targets; missing ones are 0");
  }

  void check_variants(const Json& primitive, const std::string& element) {
    std::set<size_t> seen;
    for (const Json& mapping : mappings_of(primitive))
      for (const Json& variant : mapping["variants"])
        if (!seen.insert(variant.get<size_t>()).second)
          report_.warning("mesh.variants", element, "maps variant " + variant.dump() + " twice");
  }

  void check_attribute(const std::string& name, const AccessorView& view, const std::string& place, bool is_target) {
    const auto semantic = find_semantic(name);
    if (!semantic) {
      if (name.empty() || name[0] != '_')
        report_.warning("mesh.attribute", place,
                        "is not a glTF attribute; begin the names of custom attributes with '_'");
      return;
    }
    const std::string_view types = is_target ? semantic->target_types : semantic->types;
    if (types.empty())
      return report_.warning("mesh.targets", place, "cannot be moved by a morph target; it is ignored");
    if (types.find("|" + view.type + "|") == std::string_view::npos)
      return report_.error(
          "mesh.attribute", place,
          "is of type " + view.type + ", not one of " + std::string(types) + "; export the file again");
    if (view.component_type == kFloat || semantic->integers) {
      if (semantic->numbered && view.component_type == kUnsignedInt)
        report_.error("mesh.attribute", place, "must not hold 32-bit integers; export the file again");
      check_normalization(name, view, place);
      if (!is_target) check_unit_length(name, view, place);
      return;
    }
    if (!semantic->quantizable || view.component_type == kUnsignedInt)
      return report_.error("mesh.attribute", place, "must hold floats; export the file again");
    if (!quantized_)
      report_.warning("mesh.attribute", place, "integers require KHR_mesh_quantization in extensionsRequired; add it");
  }

  void check_normalization(const std::string& name, const AccessorView& view, const std::string& place) {
    const bool joints = name.starts_with("JOINTS_");
    if (joints && (view.component_type != kUnsignedByte && view.component_type != kUnsignedShort))
      return report_.error("mesh.attribute", place,
                           "must hold 8-bit or 16-bit unsigned integers; export the file again");
    if (view.component_type == kFloat || view.normalized != joints || name.starts_with("TEXCOORD_")) return;
    report_.warning("mesh.attribute", place,
                    joints ? "must not be normalized; ignored" : "integers must be normalized; they are read as such");
  }

  void check_unit_length(const std::string& name, const AccessorView& view, const std::string& place) {
    if ((name != "NORMAL" && name != "TANGENT") || !view.data || !checked_.insert(&view).second) return;
    const std::vector<float> values = read_floats(view);
    for (size_t i = 0; i < view.count; ++i) {
      const float* v = &values[i * view.components];
      const float length2 = v[0] * v[0] + v[1] * v[1] + v[2] * v[2];
      const bool unit = std::abs(length2 - 1) < 0.02f, sign = view.components < 4 || std::abs(v[3]) == 1;
      if (unit && sign) continue;
      const bool is_direction = length2 > 0 && std::isfinite(length2);
      return report_.warning("mesh.unit", place,
                             "element " + std::to_string(i) +
                                 (is_direction ? " is not a unit vector (with sign 1 or -1) and is normalized"
                                               : " is zero or not finite, and is replaced by a computed one"));
    }
  }

  void check_bounds(const AccessorView& view, const std::string& place) {
    if (!view.has_bounds) report_.warning("mesh.bounds", place, "the accessor lacks min and max, which glTF requires");
  }

  void check_finite(const AccessorView& view, const std::string& place) {
    if (view.component_type != kFloat || !checked_.insert(&view).second) return;
    if (const auto element = first_not_finite(view))
      report_.error("mesh.points", place,
                    "element " + std::to_string(*element) + " is not a finite number; export the file again");
  }

  void check_indices(const Json& index, size_t vertex_count, const std::string& place) {
    const AccessorView& view = accessor(index);
    if (view.type != "SCALAR" || (view.component_type != kUnsignedByte && view.component_type != kUnsignedShort &&
                                  view.component_type != kUnsignedInt))
      return report_.error("mesh.indices", place, "must be scalars of an unsigned integer type; export the file again");
    if (view.normalized) report_.warning("mesh.indices", place, "must not be normalized; ignored");
    if (view.has_stride)
      report_.warning("mesh.indices", place, "the buffer view of indices must not have a byteStride");
    auto& largest = index_max_[index.get<size_t>()];
    if (!largest) {
      const std::vector<uint32_t> indices = read_indices(view);
      largest = *std::max_element(indices.begin(), indices.end());
    }
    decoded_bytes_ += view.count * sizeof(uint32_t);
    if (*largest >= vertex_count)
      report_.error("mesh.indices", place,
                    "index " + std::to_string(*largest) + " is not below the vertex count " +
                        std::to_string(vertex_count) + "; export the file again");
  }

  void check_index_count(const Json& primitive, size_t vertex_count, const std::string& element) {
    const size_t count = primitive.contains("indices") ? accessor(primitive["indices"]).count : vertex_count;
    const int mode = primitive.value("mode", 4);
    if (mode == 4 && count % 3 != 0)
      report_.warning("mesh.indices", element,
                      "the number of vertices is not a multiple of three; the rest is ignored");
    if (mode > 4 && count < 3) report_.warning("mesh.indices", element, "has no complete triangle");
  }

  void check_texture_sets(const Json& primitive, const std::string& element) {
    std::set<size_t> materials;
    if (primitive.contains("material")) materials.insert(primitive["material"].get<size_t>());
    for (const Json& mapping : mappings_of(primitive)) materials.insert(mapping["material"].get<size_t>());
    for (const size_t material : materials) {
      const auto [sets, is_new] = texture_sets_.try_emplace(material);
      if (is_new) collect_texture_sets(list("materials")[material], &sets->second);
      for (const int set : sets->second)
        if (!primitive["attributes"].contains("TEXCOORD_" + std::to_string(set)))
          report_.warning("mesh.texcoord", element,
                          "has no TEXCOORD_" + std::to_string(set) + ", which materials[" + std::to_string(material) +
                              "] uses; (0, 0) is used instead");
    }
  }

  std::vector<std::optional<uint32_t>> index_max_;  // by accessor
  std::set<const AccessorView*> checked_;
  std::map<size_t, std::set<int>> texture_sets_;  // by material
  std::vector<size_t> copies_;                    // by mesh: nodes that deform it
  uint64_t decoded_bytes_ = 0;                    // of the mesh that is checked
  bool quantized_ = false;
};

}  // namespace

size_t target_count(const Json& mesh) {
  const Json& primitives = mesh["primitives"];
  return primitives.empty() ? 0 : at(primitives[0], "targets").size();
}

// Reading a mesh takes its vectors beside its arrays.
void check_meshes(const Json& root, Report& report, Document* document) {
  constexpr double kMost = 0x1p60;
  document->facts.memory_bytes = static_cast<size_t>(std::min(MeshCheck(root, document, report).run(), kMost));
  hold_more(&document->memory, 2 * document->facts.memory_bytes, "the geometry of its meshes");
}

}  // namespace alabaster::hd::gltf
