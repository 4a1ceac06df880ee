#include "delegate/prims/scene_translation.h"

#include <algorithm>

#include "delegate/prims/mesh_build.h"

namespace alabaster::hd::prims {
namespace {

const DisneyMaterial* find_material(const Records& records, const Path& path) {
  const auto found = records.find(path);
  const auto* record = found == records.end() ? nullptr : std::get_if<MaterialRecord>(&found->second);
  return record ? record->material.get() : nullptr;
}

support::InstancePoints points_at(const hd::TimeSamples<support::InstancePoints>& samples, double time) {
  std::vector<Matrix4d> points;
  points.reserve(samples.values.front()->size());
  alabaster::TimeSamples<Matrix4d> point{samples.times, {}};
  for (size_t i = 0; i < samples.values.front()->size(); ++i) {
    point.values.clear();
    for (const support::InstancePoints& then : samples.values) point.values.push_back((*then)[i]);
    points.push_back(interpolate(point, time));
  }
  auto arrays = std::make_shared<support::InstanceArrays>();
  arrays->transforms = std::move(points);
  return arrays;
}

// One pose stands still.
void place(std::vector<Matrix4d> poses, InstanceDescription* instance) {
  instance->object_to_world = poses.front();
  instance->poses.clear();
  if (poses.size() > 1) instance->poses = std::move(poses);
}

}  // namespace

Shutter shutter_of(const Records& records) {
  std::optional<Shutter> all;
  for (const auto& [path, record] : records)
    if (const auto* camera = std::get_if<CameraRecord>(&record)) {
      const Shutter own = camera->shutter();
      all = all ? Shutter{std::min(all->open, own.open), std::max(all->close, own.close)} : own;
    }
  return all.value_or(Shutter());
}

CameraParameters posed_camera(const CameraRecord& record, const Shutter& scene) {
  CameraParameters camera = record.camera;
  if (scene.length() > 0) {
    const auto share = [&](double time) {
      return static_cast<float>(std::clamp((time - scene.open) / scene.length(), 0.0, 1.0));
    };
    camera.opens = share(record.shutter().open), camera.closes = share(record.shutter().close);
  }
  if (!record.motion.moves()) return camera;
  std::vector<Matrix4d> poses = even_poses(record.motion, record.shutter());
  camera.camera_to_world = poses.front();
  if (poses.size() > 1) camera.poses = std::move(poses);
  return camera;
}

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
  const Shutter& shutter;
  const BuiltMeshes& meshes;
  const DeformedMeshes& deformed;
  support::Placements placements{[this](const Path& path) { return find_instancer(path); },
                                 [this](const char* code, const Path& where, const std::string& text) {
                                   translator.report_once(code, where, text);
                                 }};
  Translation out;

  void add_mesh(const Path& path, const MeshRecord& mesh) {
    const MeshBuild* const built = meshes.find(path);
    if (!mesh.visible || !built || !built->prototype) return;
    InstanceDescription instance;
    const auto moved = deformed.find(path);
    instance.prototype = moved == deformed.end() ? built->prototype : moved->second;
    instance.prim_id = mesh.prim_id;
    instance.name = path.str();
    instance.double_sided = mesh.double_sided;
    for (const Path& id : mesh.materials) instance.materials.push_back(material(path, id));
    check_closed(instance);
    instance.subsurface_set = set_of(instance, mesh);
    const std::vector<Matrix4d> own =
        mesh.motion.moves() ? even_poses(mesh.motion, shutter) : std::vector<Matrix4d>{mesh.transform};
    if (mesh.instancer.empty()) {
      place(own, &instance);
      add(std::move(instance), mesh);
      return;
    }
    const std::vector<support::Placement> placed = placements.place(path, mesh.instancer, mesh.instance_indices);
    const std::vector<double> times = instancer_times(mesh.instancer);
    const PlacedSamples samples = times.empty() ? PlacedSamples() : place_at(times, path, mesh);
    for (size_t i = 0; i < placed.size(); ++i) {
      if (!placed[i].used) continue;
      std::vector<Matrix4d> poses = own;
      for (Matrix4d& pose : poses) pose = pose * placed[i].matrix;
      place(samples.times.empty() ? std::move(poses) : even_poses(samples.of(i), shutter), &instance);
      instance.instance_id = static_cast<int32_t>(i);
      add(instance, mesh);
    }
  }

  // The instances of a mesh at the times of all samples that move them.
  struct PlacedSamples {
    std::vector<double> times;
    std::vector<std::vector<Matrix4d>> matrices;  // by time and instance
    alabaster::TimeSamples<Matrix4d> of(size_t instance) const {
      alabaster::TimeSamples<Matrix4d> samples{times, {}};
      for (const auto& all : matrices) samples.values.push_back(all[instance]);
      return samples;
    }
  };

  // The sample times of all instancers that place a prim, from the innermost on. Empty: they stand still.
  std::vector<double> instancer_times(Path path) const {
    std::vector<double> times;
    for (std::set<Path> seen; !path.empty() && seen.insert(path).second;) {
      const auto* instancer = find_instancer(path);
      if (!instancer) break;
      for (const auto* own : {&instancer->motion.times, &instancer->moving_points.times})
        times.insert(times.end(), own->begin(), own->end());
      path = instancer->parent;
    }
    return times;
  }

  PlacedSamples place_at(std::vector<double> times, const Path& path, const MeshRecord& mesh) const {
    times.insert(times.end(), mesh.motion.times.begin(), mesh.motion.times.end());
    std::sort(times.begin(), times.end());
    times.erase(std::unique(times.begin(), times.end()), times.end());
    PlacedSamples samples{times, {}};
    for (const double time : times) {
      std::map<Path, InstancerRecord> posed;
      support::Placements then(
          [&](const Path& id) -> const InstancerRecord* {
            const auto* record = find_instancer(id);
            if (!record || (record->motion.values.empty() && record->moving_points.values.empty())) return record;
            InstancerRecord& moved = posed.emplace(id, *record).first->second;
            if (!record->motion.values.empty())
              moved.transform = interpolate({record->motion.times, record->motion.values}, time);
            if (!record->moving_points.values.empty()) moved.points = points_at(record->moving_points, time);
            return &moved;
          },
          {});
      const Matrix4d own = mesh.motion.moves() ? interpolate(mesh.motion, time) : mesh.transform;
      samples.matrices.emplace_back();
      for (const support::Placement& placed : then.place(path, mesh.instancer, mesh.instance_indices))
        samples.matrices.back().push_back(own * placed.matrix);
    }
    return samples;
  }

  const InstancerRecord* find_instancer(const Path& path) const {
    const auto found = records.find(path);
    return found == records.end() ? nullptr : std::get_if<InstancerRecord>(&found->second);
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

Translation SceneTranslator::translate(const Records& records, const Shutter& shutter, const BuiltMeshes& meshes,
                                       const DeformedMeshes& deformed) {
  Run run{
      .translator = *this, .records = records, .shutter = shutter, .meshes = meshes, .deformed = deformed, .out = {}};
  run.out.shutter = shutter;
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
