#include "delegate/prims/scene_translation.h"

#include <algorithm>

namespace alabaster::hd::prims {
namespace {

const DisneyMaterial* find_material(const Records& records, const Path& path) {
  const auto found = records.find(path);
  const auto* record = found == records.end() ? nullptr : std::get_if<MaterialRecord>(&found->second);
  return record ? record->material.get() : nullptr;
}

}  // namespace

SceneTranslator::SceneTranslator(alabaster::DiagnosticSink sink) : sink_(std::move(sink)) {
  auto material = std::make_shared<DisneyMaterial>();
  material->name = "default";
  default_material_ = std::move(material);
}

void SceneTranslator::report_once(const char* code, const Path& where, const std::string& text) {
  if (reported_.emplace(code + where.str(), text).second)
    alabaster::report(sink_, alabaster::Severity::warning, code, where.str(), text);
}

// One translation.
struct SceneTranslator::Run {
  SceneTranslator& translator;
  const Records& records;
  support::Placements placements{[this](const Path& path) -> const InstancerRecord* {
                                   const auto found = records.find(path);
                                   return found == records.end() ? nullptr
                                                                 : std::get_if<InstancerRecord>(&found->second);
                                 },
                                 [this](const char* code, const Path& where, const std::string& text) {
                                   translator.report_once(code, where, text);
                                 }};
  Translation out;

  void add_mesh(const Path& path, const MeshRecord& mesh) {
    if (!mesh.visible || !mesh.prototype) return;
    InstanceDescription instance;
    instance.prototype = mesh.prototype;
    instance.prim_id = mesh.prim_id;
    instance.name = path.str();
    instance.double_sided = mesh.double_sided;
    for (const Path& id : mesh.materials) instance.materials.push_back(material(path, id));
    check_closed(instance);
    instance.subsurface_set = set_of(instance, mesh);
    if (mesh.instancer.empty()) {
      instance.object_to_world = mesh.transform;
      add(std::move(instance), mesh);
      return;
    }
    const std::vector<support::Placement> placed = placements.place(path, mesh.instancer, mesh.instance_indices);
    for (size_t i = 0; i < placed.size(); ++i) {
      if (!placed[i].used) continue;
      instance.object_to_world = mesh.transform * placed[i].matrix;
      instance.instance_id = static_cast<int32_t>(i);
      add(instance, mesh);
    }
  }

  // A named set and the set of a material never meet. Among several materials the first that scatters names the set.
  static std::string set_of(const InstanceDescription& instance, const MeshRecord& mesh) {
    const std::vector<size_t> slots = scattering_slots(instance);
    if (mesh.subsurface_set.empty() || slots.empty()) return {};
    if (mesh.subsurface_set != "byMaterial") return "named " + mesh.subsurface_set;
    return "material " + mesh.materials[slots.front()].str();
  }

  void check_closed(const InstanceDescription& instance) {
    if (instance.prototype->mesh.closed || scattering_slots(instance).empty()) return;
    translator.report_once(
        "mesh.open", Path(instance.name),
        "subsurface scattering in a mesh that is not closed: the medium goes on behind it without "
        "end, and light that does not come back is lost (stats: walk.lostEnergy); close the mesh, or "
        "bind a material without scatterDistance");
  }

  void add(InstanceDescription instance, const MeshRecord& mesh) {
    out.scene.instances.push_back(std::move(instance));
    out.material_paths.insert(out.material_paths.end(), mesh.materials.begin(), mesh.materials.end());
  }

  std::shared_ptr<const DisneyMaterial> material(const Path& prim, const Path& id) {
    if (id.empty()) return translator.default_material_;
    if (find_material(records, id)) return std::get<MaterialRecord>(records.at(id)).material;
    translator.report_once("mesh.material", prim, "material " + id.str() + " does not exist; the default is used");
    return translator.default_material_;
  }
};

Translation SceneTranslator::translate(const Records& records) {
  Run run{.translator = *this, .records = records, .out = {}};
  for (const auto& [path, record] : records) {
    if (const auto* mesh = std::get_if<MeshRecord>(&record)) run.add_mesh(path, *mesh);
    if (const auto* light = std::get_if<LightRecord>(&record); light && light->visible) {
      run.out.scene.lights.push_back(light->light);
      run.out.light_paths.push_back(path);
    }
  }
  return std::move(run.out);
}

}  // namespace alabaster::hd::prims
