#include "delegate/prims/scene_translation.h"

#include <algorithm>

namespace alabaster::hd::sync {
namespace {

constexpr size_t kMaxInstances = size_t(1) << 27;  // of one prim: beyond it, memory for placements alone exceeds 16 GB

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

// One translation. Placements of an instancer are shared by all its prototypes.
struct SceneTranslator::Run {
  SceneTranslator& translator;
  const Records& records;
  std::map<Path, std::vector<Placement>> outer;  // of instancers, by path
  std::set<Path> visiting;
  Translation out;

  const InstancerRecord* instancer(const Path& path) const {
    const auto found = records.find(path);
    return found == records.end() ? nullptr : std::get_if<InstancerRecord>(&found->second);
  }

  /// Where an instancer itself stands: once if it has no parent.
  const std::vector<Placement>& outer_of(const Path& path, const InstancerRecord& record) {
    const auto known = outer.find(path);
    if (known != outer.end()) return known->second;
    std::vector<Placement> placements;
    if (record.parent.empty()) {
      placements.emplace_back();
    } else if (visiting.insert(path).second) {
      placements = place(path, record.parent, record.indices_in_parent);
      visiting.erase(path);
    } else {
      translator.report_once("instancer.cycle", path, "instancers contain each other; what they place is not drawn");
    }
    return outer.emplace(path, std::move(placements)).first->second;
  }

  /// point * instancer * outer, for each outer and, fastest, each inner index.
  std::vector<Placement> place(const Path& prototype, const Path& path, const Array<int32_t>& indices) {
    const InstancerRecord* record = instancer(path);
    if (!record) {
      translator.report_once("instancer.missing", prototype,
                             "instancer " + path.str() + " does not exist; the prim is not drawn");
      return {};
    }
    const std::vector<Placement> outside = outer_of(path, *record);
    std::vector<Placement> placements;
    if (!indices.empty() && outside.size() > kMaxInstances / indices.size()) {
      translator.report_once("instancer.size", prototype, "more than 2^27 instances; the prim is not drawn");
      return placements;
    }
    placements.reserve(outside.size() * indices.size());
    size_t dropped = 0;
    for (const Placement& o : outside) {
      const Matrix4d base = record->transform * o.matrix;
      for (const int32_t index : indices) {
        const bool exists = index >= 0 && (!record->points || static_cast<size_t>(index) < record->points->size());
        dropped += exists ? 0 : 1;
        const bool moved = exists && record->points;
        placements.push_back({moved ? (*record->points)[static_cast<size_t>(index)] * base : base, o.used && exists});
      }
    }
    if (dropped)
      translator.report_once("instancer.index", prototype,
                             "some instance indices name no point of " + path.str() + "; those instances are left out");
    return placements;
  }

  void add_mesh(const Path& path, const MeshRecord& mesh) {
    if (!mesh.visible || !mesh.prototype) return;
    InstanceDescription instance;
    instance.prototype = mesh.prototype;
    instance.prim_id = mesh.prim_id;
    instance.name = path.str();
    for (const Path& id : mesh.materials) instance.materials.push_back(material(path, id));
    check_closed(instance);
    instance.subsurface_set = set_of(instance, mesh);
    if (mesh.instancer.empty()) {
      instance.object_to_world = mesh.transform;
      add(std::move(instance), mesh);
      return;
    }
    const std::vector<Placement> placements = place(path, mesh.instancer, mesh.instance_indices);
    for (size_t i = 0; i < placements.size(); ++i) {
      if (!placements[i].used) continue;
      instance.object_to_world = mesh.transform * placements[i].matrix;
      instance.instance_id = static_cast<int32_t>(i);
      add(instance, mesh);
    }
  }

  // Named sets and those of a material never meet. Of several materials the first that scatters says which.
  static std::string set_of(const InstanceDescription& instance, const MeshRecord& mesh) {
    if (mesh.subsurface_set.empty() || !scatters(instance)) return {};
    if (mesh.subsurface_set != "byMaterial") return "named " + mesh.subsurface_set;
    size_t slot = 0;
    while (!instance.materials[slot]->scatters()) ++slot;
    return "material " + mesh.materials[slot].str();
  }

  void check_closed(const InstanceDescription& instance) {
    if (instance.prototype->mesh.closed || !scatters(instance)) return;
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
  Run run{*this, records, {}, {}, {}};
  for (const auto& [path, record] : records) {
    if (const auto* mesh = std::get_if<MeshRecord>(&record)) run.add_mesh(path, *mesh);
    if (const auto* light = std::get_if<LightRecord>(&record)) {
      run.out.scene.lights.push_back(light->light);
      run.out.light_paths.push_back(path);
    }
  }
  return std::move(run.out);
}

}  // namespace alabaster::hd::sync
