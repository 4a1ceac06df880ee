#include "delegate/prims/scene_translation.h"

#include <algorithm>
#include <utility>

#include "core/geometry/reversed_edges.h"
#include "core/scene/scene_reports.h"
#include "delegate/prims/built_meshes.h"
#include "delegate/support/lookup.h"
#include "delegate/support/nearest_name.h"

namespace alabaster::hd::prims {
namespace {

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

// The categories that lights name, by number, and the sets of them that instances are in.
class CategorySets {
 public:
  explicit CategorySets(const Records& records) {
    for (const auto& [path, record] : records)
      if (const auto* light = std::any_cast<LightRecord>(&record); light && light->visible)
        for (const Token& name : {light->light_link, light->shadow_link})
          if (!name.empty()) numbers_[name];
    uint32_t last = 0;
    for (auto& [name, number] : numbers_) number = ++last;
    if (!empty()) of({});
  }
  bool empty() const { return numbers_.empty(); }
  /// 0: of none.
  uint32_t number(const Token& name) const { return support::value_in(numbers_, name); }
  /// Numbers in the order in which they are first asked for. 0 where no light is linked.
  uint32_t of(const std::vector<Token>& names) {
    if (empty()) return 0;
    std::set<uint32_t> set;
    for (const Token& name : names)
      if (const uint32_t one = number(name); one != 0) set.insert(one);
    std::vector<uint32_t> sorted(set.begin(), set.end());
    const auto [found, is_new] = known_.try_emplace(sorted, static_cast<uint32_t>(sets_.size()));
    if (is_new) sets_.push_back(std::move(sorted));
    return found->second;
  }
  std::vector<std::vector<uint32_t>> take() { return std::move(sets_); }
  std::vector<Token> names() const {
    std::vector<Token> all;
    for (const auto& [name, unused] : numbers_) all.push_back(name);
    return all;
  }

 private:
  std::map<Token, uint32_t> numbers_;
  std::map<std::vector<uint32_t>, uint32_t> known_;
  std::vector<std::vector<uint32_t>> sets_;
};

// The names of the light groups of lights and meshes.
std::vector<std::string> find_light_groups(const Records& records) {
  std::set<std::string> names;
  for (const auto& [path, record] : records) {
    if (const auto* light = std::any_cast<LightRecord>(&record); light && light->visible)
      names.insert(light->light_group);
    if (const auto* mesh = std::any_cast<MeshRecord>(&record)) names.insert(mesh->light_group);
  }
  names.erase("");
  return {names.begin(), names.end()};
}

// One pose stands still.
void place(std::vector<Matrix4d> poses, Matrix4d* first, std::vector<Matrix4d>* all) {
  *first = poses.front();
  all->clear();
  if (poses.size() > 1) *all = std::move(poses);
}

// The places that an instancer gives, behind the mesh's own transform.
class PointPlaces final : public InstancePlaces {
 public:
  PointPlaces(const Matrix4d& own, support::PlacementSource source) : own_(own), source_(std::move(source)) {}
  size_t size() const override { return source_.size(); }
  std::optional<Matrix4d> at(size_t number) const override {
    const support::Placement placed = source_[number];
    return placed.used ? std::optional(own_ * placed.matrix) : std::nullopt;
  }
  bool stand_alike(const InstancePlaces& other, size_t begin, size_t end) const override {
    const auto& points = static_cast<const PointPlaces&>(other);  // all places are of this kind
    return own_ == points.own_ && source_.stand_alike(points.source_, begin, end);
  }

 private:
  const Matrix4d own_;
  const support::PlacementSource source_;
};

// The primvars of the points that instances stand at.
class PointValues final : public InstanceValues {
 public:
  /// An instancer, from the innermost on, and the points of it that those further in stand at.
  struct Level {
    Array<int32_t> points;
    std::shared_ptr<const OtherPrimvars> primvars;  // null: none
  };
  /// Those of which is_read(name) says so.
  template <class IsRead>
  PointValues(std::vector<Level> levels, const IsRead& is_read) : levels_(std::move(levels)) {
    for (const Level& level : levels_) {
      columns_.emplace_back();
      if (!level.primvars) continue;
      for (const auto& [name, primvar] : level.primvars->by_name)
        if (is_read(name)) columns_.back().push_back({name.str(), numbers_of(primvar.value), &primvar});
    }
  }

  std::vector<UvSetName> names() const override {
    std::vector<UvSetName> all;
    for (const auto& of_level : columns_)
      for (const Column& column : of_level) all.push_back(column.name);
    return all;
  }
  // The innermost counts. Instances are numbered with the points of the innermost fastest.
  int read(const UvSetName& name, size_t instance, Vec4f* numbers) const override {
    for (size_t i = 0; i < levels_.size(); ++i) {
      const Array<int32_t>& points = levels_[i].points;
      const int32_t point = points[instance % points.size()];
      instance /= points.size();
      for (const Column& column : columns_[i])
        if (column.name == name)
          if (const int count = column.read(point, numbers)) return count;
    }
    return 0;
  }
  bool are_alike(const InstanceValues& other) const override {
    const auto& values = static_cast<const PointValues&>(other);  // all are of this kind
    const auto same = [](const Level& a, const Level& b) { return a.points == b.points; };
    return columns_ == values.columns_ &&
           std::equal(levels_.begin(), levels_.end(), values.levels_.begin(), values.levels_.end(), same);
  }

 private:
  struct Column {
    UvSetName name;
    NumberArray numbers;
    const PulledPrimvar* primvar;
    bool operator==(const Column& other) const {
      return name == other.name && (primvar == other.primvar || *primvar == *other.primvar);
    }
    int read(int32_t point, Vec4f* out) const {
      const Array<int32_t>& indices = primvar->indices;
      const auto is_in = [](int32_t i, size_t size) { return i >= 0 && static_cast<size_t>(i) < size; };
      if (!indices.empty()) point = is_in(point, indices.size()) ? indices[static_cast<size_t>(point)] : -1;
      if (!is_in(point, numbers.count)) return 0;
      *out = Vec4f(0);
      std::copy_n(numbers.data + static_cast<size_t>(point) * numbers.width, numbers.width, &out->x);
      if (numbers.width == 3 && primvar->to_rendering) {
        const Rgb color = (*primvar->to_rendering)(Rgb(out->x, out->y, out->z));
        *out = Vec4f(color.r, color.g, color.b, 0);
      }
      return static_cast<int>(numbers.width);
    }
  };
  const std::vector<Level> levels_;
  std::vector<std::vector<Column>> columns_;  // by level
};

// Rays take a tenth more time in an array. From here on that is worth its edits, which then take 10 ms instead of 27
// (testenv/benchmark/results/edit_latency.md).
constexpr size_t kSmallestArray = 8192;

// The look of a mesh without a material: grey, or its own colours and opacities.
DisneyMaterial default_material(bool color, bool opacity) {
  DisneyMaterial material;
  material.name = "default";
  if (!color && !opacity) return material;
  const auto read = [&](const char* primvar, const char* parameter, Channel channel) {
    MaterialTexture texture;
    texture.lookup.primvar = primvar, texture.lookup.fallback = Vec4f(1);
    texture.uses.push_back({find_material_parameter(parameter), channel});
    material.textures.push_back(std::move(texture));
  };
  if (color) material.constants.base_color = Rgb(1.0f), read(kDisplayColor, "baseColor", Channel::rgb);
  if (opacity) read(kDisplayOpacity, "opacity", Channel::a);
  return material;
}

}  // namespace

support::HoldPlacements hold_placements_in(std::shared_ptr<MemoryBudget> budget) {
  return [budget = std::move(budget)](size_t count, const Path& prototype) {
    return std::make_shared<const MemoryReservation>(budget, MemoryUse::scene, count * sizeof(support::Placement),
                                                     std::to_string(count) + " instances of " + prototype.str());
  };
}

std::optional<Shutter> shutter_of(const Records& records) {
  std::optional<Shutter> all;
  for (const auto& [path, record] : records)
    if (const auto* camera = std::any_cast<CameraRecord>(&record))
      all = all ? united(*all, camera->shutter()) : camera->shutter();
  return all;
}

namespace {

// At the ends of a time.
std::vector<Matrix4d> at_ends(const alabaster::TimeSamples<Matrix4d>& samples, const Shutter& time) {
  return {interpolate(samples, time.open), interpolate(samples, time.close)};
}

}  // namespace

CameraParameters posed_camera(const CameraRecord& record, const Shutter& of_scene, const MotionTime& motion) {
  CameraParameters camera = record.camera;
  if (of_scene.length() > 0) {
    const auto share = [&](double time) {
      return static_cast<float>(std::clamp((time - of_scene.open) / of_scene.length(), 0.0, 1.0));
    };
    camera.opens = share(record.shutter().open), camera.closes = share(record.shutter().close);
  }
  open_lens(&camera);
  if (motion)
    camera.ends = record.motion.moves() ? at_ends(record.motion, *motion) : std::vector(2, camera.camera_to_world);
  if (!record.motion.moves()) return camera;
  std::vector<Matrix4d> poses = even_poses(record.motion, record.shutter());
  camera.camera_to_world = poses.front();
  if (poses.size() > 1) camera.poses = std::move(poses);
  return camera;
}

const OpenEdges::Kind& SceneTranslator::reversed_edges_of(const std::shared_ptr<const MeshPrototype>& mesh) {
  const auto [found, is_new] = reversed_edges_.try_emplace(mesh);
  if (is_new) found->second = find_reversed_edges(mesh->mesh);
  return found->second;
}

SceneTranslator::SceneTranslator(alabaster::DiagnosticSink sink) : sink_(std::move(sink)) {
  for (size_t i = 0; i < default_materials_.size(); ++i)
    default_materials_[i] = std::make_shared<const DisneyMaterial>(default_material((i & 1) != 0, (i & 2) != 0));
}

void SceneTranslator::warn(const char* code, const Path& where, const std::string& text) {
  found_.push_back({alabaster::Severity::warning, code, where.str(), text});
}

void SceneTranslator::fail(const char* code, const Path& where, const std::string& text) {
  found_.push_back({alabaster::Severity::error, code, where.str(), text});
}

// One translation.
struct SceneTranslator::Run {
  SceneTranslator& translator;
  const Parts& parts;
  const Records& records = parts.records;
  MaterialLookup materials{parts.records};
  BuiltMeshes::Lookup meshes{parts.meshes};
  support::Placements placements{
      [this](const Path& path) { return find_instancer(path); },
      [this](const char* code, const Path& where, const std::string& text) { warn_of_instancer(code, where, text); },
      hold_placements_in(parts.memory)};
  Translation out;
  CategorySets category_sets;
  static constexpr size_t kMostAnswers = 8;                       // of each map; each answer looks at all names
  std::map<Path, std::string> answers = {};                       // of nearest()
  std::map<Token, std::string> link_ends = {};                    // of check_link()
  std::optional<std::vector<std::string>> known_categories = {};  // sorted; none: not asked for yet
  // Open meshes with a clear interior, that of one subsurfaceSet or a mesh alone: as bodies that scatter, each set has
  // one report.
  struct OpenClear {
    std::string first;  // in the order of paths
    std::shared_ptr<const MeshPrototype> prototype;
    size_t others = 0;
  };
  using OpenClears = std::map<std::string, OpenClear>;
  OpenClears open_clear = {};
  uint32_t matted_instances = 0;  // those of scene.mattes

  // Places are counted before any is added.
  void add_mesh(const Path& path, const MeshRecord& mesh) {
    try {
      in_name_of(path.str(), [&] { add_placed(path, mesh); });
    } catch (const support::TooManyInstances& e) {
      translator.fail("instancer.size", path, e.what());
      out.faults[path] = e.what();
    }
  }

  void add_placed(const Path& path, const MeshRecord& mesh) {
    const BuiltMesh* const built = meshes.find(path);
    if (!parts.selection.includes(path, mesh.visible, mesh.render_tag) || !built || !built->prototype) return;
    InstanceDescription instance;
    const auto moved = parts.deformed.traced.find(path);
    instance.prototype = moved == parts.deformed.traced.end() ? built->prototype : moved->second;
    if (const auto ends = parts.deformed.ends.find(path); ends != parts.deformed.ends.end())
      instance.mesh_ends = ends->second;
    instance.slots = built->slots;
    instance.prim_id = mesh.prim_id;
    instance.name = path.str();
    instance.options = mesh.options;
    instance.values = values_of(mesh);
    for (const Path& id : mesh.materials) instance.materials.push_back(material(path, id, instance));
    const std::optional<OpenClears::value_type> open = check_closed(instance, mesh);
    check_direction(instance);
    instance.subsurface_set = set_of(instance, mesh);
    instance.category_set = category_sets.of(mesh.categories);
    instance.light_group = light_group(mesh.light_group);
    std::vector<Matrix4d> moving;
    if (mesh.motion.moves()) moving = even_poses(mesh.motion, parts.shutter);
    if (!mesh.instancer.empty()) {
      add_instances(path, mesh, moving.empty() ? std::vector{mesh.transform} : std::move(moving), std::move(instance));
    } else {
      add_mattes(path, mesh, 0);
      instance.object_to_world = mesh.transform;
      if (!moving.empty()) place(std::move(moving), &instance.object_to_world, &instance.poses);
      if (parts.motion && mesh.motion.moves()) instance.ends = at_ends(mesh.motion, *parts.motion);
      add(std::move(instance), mesh);
    }
    if (!mesh.display_name.empty()) out.display_names.emplace_back(path, mesh.display_name);
    if (open) note_open(*open);  // last: a mesh that is left out has no such report
  }

  void add_mattes(const Path& path, const MeshRecord& mesh, size_t instances) {
    MatteNames names{mesh.prim_id, mesh.crypto_object, mesh.crypto_asset, 0};
    if (mesh.options.crypto_instances) {
      if (instances <= kMostInstanceMattes - matted_instances)
        matted_instances += names.instances = static_cast<uint32_t>(instances);
      else
        translator.warn("mesh.cryptoInstances", path,
                        "its " + std::to_string(instances) +
                            " instances share one matte, because a frame has mattes of " +
                            std::to_string(kMostInstanceMattes) + " instances at most and other meshes have " +
                            std::to_string(matted_instances) + "; take cryptoInstances from meshes with many");
    }
    if (names != MatteNames{mesh.prim_id, {}, {}, 0}) out.scene.mattes.push_back(std::move(names));
  }

  // Without its poses.
  static size_t instance_bytes(const InstanceDescription& instance, const MeshRecord& mesh) {
    return sizeof instance + instance.name.size() + instance.subsurface_set.size() +
           mesh.materials.size() * (sizeof instance.materials[0] + sizeof(Path));
  }

  // Empty: they stand still.
  static std::vector<double> sample_times(const std::vector<const InstancerRecord*>& instancers) {
    std::vector<double> times;
    for (const InstancerRecord* one : instancers)
      for (const auto& own : {times_of_turns({one->motion.times, one->motion.values}), one->moving_points.times})
        times.insert(times.end(), own.begin(), own.end());
    return times;
  }

  void add_instances(const Path& path, const MeshRecord& mesh, const std::vector<Matrix4d>& own,
                     InstanceDescription instance) {
    support::PlacementSource placed = placements.source(path, mesh.instancer, mesh.instance_indices);
    add_mattes(path, mesh, placed.size());
    const auto instancers = instancers_of(mesh.instancer);
    const std::vector<double> times = sample_times(instancers);
    const bool has_categories =
        !category_sets.empty() &&
        std::any_of(instancers.begin(), instancers.end(), [](const auto* one) { return one->categories != nullptr; });
    const bool has_ends = parts.motion && (mesh.motion.moves() || !times.empty());
    const bool stands_still = own.size() == 1 && times.empty() && !has_ends && !instance.mesh_ends;
    if (placed.size() >= kSmallestArray && stands_still && !has_categories) {
      out.array_materials.push_back(mesh.materials);
      out.scene.arrays.push_back({std::move(instance), std::make_shared<PointPlaces>(own.front(), std::move(placed))});
      return;
    }
    const std::string text = std::to_string(placed.size()) + " instances of " + path.str();
    const auto hold = [&](size_t more) { out.memory->resize(out.memory->bytes() + more, text); };
    hold(placed.size() * instance_bytes(instance, mesh));
    const MemoryReservation samples_memory(
        parts.memory, MemoryUse::scene,
        times.empty() ? 0 : (times.size() + mesh.motion.times.size()) * placed.size() * sizeof(Matrix4d), text);
    const PlacedSamples samples = times.empty() ? PlacedSamples() : place_at(times, path, mesh);
    for (size_t i = 0; i < placed.size(); ++i) {
      const support::Placement at = placed[i];
      if (!at.used) continue;
      std::vector<Matrix4d> moved = own;
      for (Matrix4d& pose : moved) pose = pose * at.matrix;
      if (has_ends) {
        instance.ends = at_ends(samples.times.empty() ? mesh.motion : samples.of(i), *parts.motion);
        if (samples.times.empty())
          for (Matrix4d& end : instance.ends) end = end * at.matrix;
      }
      place(samples.times.empty() ? std::move(moved) : even_poses(samples.of(i), parts.shutter),
            &instance.object_to_world, &instance.poses);
      hold((instance.poses.size() + instance.ends.size()) * sizeof(Matrix4d));
      instance.instance_id = static_cast<int32_t>(i);
      if (has_categories) instance.category_set = category_sets.of(categories_of(mesh, i));
      add(InstanceDescription(instance), mesh);
    }
  }

  // Null: no instancer has any that the mesh's materials or AOVs read.
  InstanceValuesPtr values_of(const MeshRecord& mesh) {
    std::vector<PointValues::Level> levels;
    const Array<int32_t>* points = &mesh.instance_indices;
    bool any = false;
    for (const InstancerRecord* one : instancers_of(mesh.instancer)) {
      levels.push_back({*points, one->primvars});
      points = &one->indices_in_parent;
      any = any || one->primvars;
    }
    if (!any) return nullptr;
    const auto is_read = [&](const Token& name) {
      const auto reads = [&](const Path& id) {
        const MaterialRecord* const record = materials.find(id);
        return record && record->material ? record->material->reads(name.str())
                                          : name == Token(kDisplayColor) || name == Token(kDisplayOpacity);
      };
      return std::binary_search(parts.shown_primvars.begin(), parts.shown_primvars.end(), name) ||
             std::any_of(mesh.materials.begin(), mesh.materials.end(), reads);
    };
    const auto values = std::make_shared<const PointValues>(std::move(levels), is_read);
    return values->names().empty() ? nullptr : InstanceValuesPtr(values);
  }

  // The mesh's, and those of its instance at each level.
  std::vector<Token> categories_of(const MeshRecord& mesh, size_t instance) const {
    std::vector<Token> all = mesh.categories;
    const Array<int32_t>* indices = &mesh.instance_indices;
    for (const auto* at = find_instancer(mesh.instancer); at && !indices->empty(); at = find_instancer(at->parent)) {
      const auto point = static_cast<size_t>((*indices)[instance % indices->size()]);
      instance /= indices->size();
      if (at->categories && point < at->categories->size())
        all.insert(all.end(), (*at->categories)[point].begin(), (*at->categories)[point].end());
      indices = &at->indices_in_parent;
    }
    return all;
  }

  // Its number; 0: none.
  uint32_t light_group(const std::string& name) const {
    const auto& names = out.scene.light_groups;
    return name.empty() ? 0
                        : static_cast<uint32_t>(std::lower_bound(names.begin(), names.end(), name) - names.begin()) + 1;
  }

  void add_light(const Path& path, const LightRecord& light) {
    LightParameters& made = out.scene.lights.emplace_back(light.light);
    if (light.motion.moves()) place(even_poses(light.motion, parts.shutter), &made.light_to_world, &made.poses);
    made.light_link = category_sets.number(light.light_link);
    made.shadow_link = category_sets.number(light.shadow_link);
    made.group = light_group(light.light_group);
    out.light_paths.push_back(path);
    check_link(path, "lightLink", light.light_link);
    check_link(path, "shadowLink", light.shadow_link);
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

  PlacedSamples place_at(std::vector<double> times, const Path& path, const MeshRecord& mesh) const {
    const std::vector<double> own_times = times_of_turns(mesh.motion);
    times.insert(times.end(), own_times.begin(), own_times.end());
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
          {}, hold_placements_in(parts.memory));
      const Matrix4d own = mesh.motion.moves() ? interpolate(mesh.motion, time) : mesh.transform;
      samples.matrices.emplace_back();
      for (const support::Placement& placed : then.place(path, mesh.instancer, mesh.instance_indices))
        samples.matrices.back().push_back(own * placed.matrix);
    }
    return samples;
  }

  const InstancerRecord* find_instancer(const Path& path) const { return find_record<InstancerRecord>(records, path); }

  // The instancer, and those that place it: from the innermost on.
  std::vector<const InstancerRecord*> instancers_of(Path path) const {
    std::vector<const InstancerRecord*> all;
    for (std::set<Path> seen; !path.empty() && seen.insert(path).second;) {
      all.push_back(find_instancer(path));
      if (!all.back()) return all.pop_back(), all;
      path = all.back()->parent;
    }
    return all;
  }

  // A named set and the set of a material never meet. Among several materials the first that scatters names the set.
  // What does not scatter is in named ones: bones.
  static std::string set_of(const InstanceDescription& instance, const MeshRecord& mesh) {
    return set_of(scattering_slots(instance), mesh);
  }
  static std::string set_of(const std::vector<size_t>& slots, const MeshRecord& mesh) {
    if (mesh.subsurface_set.empty()) return {};
    if (mesh.subsurface_set != "byMaterial") return "named " + mesh.subsurface_set;
    return slots.empty() ? std::string() : "material " + mesh.materials[slots.front()].str();
  }

  // Bodies that scatter are reported as the unions that they are (core/scene/scene_reports.h). A sheet that spreads
  // light alone may be open: both of its sides are lit. Returns a clear mesh that is open, with the name of its set.
  std::optional<OpenClears::value_type> check_closed(const InstanceDescription& instance, const MeshRecord& mesh) {
    const std::vector<size_t> clear = used_slots(instance, [](const DisneyMaterial& material) {
      const DisneyParameters& p = material.constants;
      return !p.thin && (p.spec_trans > 0 || (p.diff_trans > 0 && p.attenuation_distance > 0));
    });
    if (clear.empty() || !scattering_slots(instance).empty()) return std::nullopt;
    if (instance.prototype->mesh.closed) {
      check_winding(instance);
      return std::nullopt;
    }
    const std::string set = set_of(clear, mesh);
    return OpenClears::value_type(set.empty() ? instance.name : set, OpenClear{instance.name, instance.prototype});
  }
  void note_open(const OpenClears::value_type& open) {
    const auto [body, is_new] = open_clear.insert(open);
    if (!is_new) ++body->second.others;
  }

  void report_open_clear() {
    for (const auto& [set, body] : open_clear)
      translator.warn("mesh.open", Path(body.first),
                      "a clear material in a mesh that is not closed: all that lies behind it is in its interior, "
                      "which absorbs nothing and which light reaches by refraction alone" +
                          describe_open_edges(body.prototype->interior.open_edges(body.prototype->mesh)) +
                          "; or make the material `thin`" + describe_open_fellows(body.others));
  }

  // The winding of a face says which of its sides is in the interior.
  void check_winding(const InstanceDescription& instance) {
    if (!instance.prototype->mesh.outward) return;  // then the path of a ray says where it is
    const OpenEdges::Kind& edges = translator.reversed_edges_of(instance.prototype);
    if (edges.count == 0) return;
    translator.warn("mesh.winding", Path(instance.name),
                    "a clear material in a mesh whose faces do not all wind alike: the interior is taken to lie on the "
                    "wrong side of some. At " +
                        std::to_string(edges.count) + " of its edges they run in one direction, one from " +
                        Value(edges.first[0]).to_string() + " to " + Value(edges.first[1]).to_string() +
                        ": turn the faces that wind against the others");
  }

  // Few faces without a direction, such as those at a pole, show nowhere.
  void check_direction(const InstanceDescription& instance) {
    const auto is_anisotropic = [](const auto& material) { return material->constants.anisotropic > 0; };
    if (std::none_of(instance.materials.begin(), instance.materials.end(), is_anisotropic)) return;
    const Mesh& shape = instance.prototype->mesh;
    const TriangleSlots& slots = instance.triangle_slots();
    size_t faces = 0, without = 0;
    for (uint32_t i = 0; i < shape.triangles.size(); ++i) {
      const size_t slot = slots.empty() ? 0 : static_cast<size_t>(slots[i]);
      if (!is_anisotropic(instance.materials[slot < instance.materials.size() ? slot : 0])) continue;
      ++faces;
      without += !has_direction_of_u(shape, i);
    }
    if (without * 1000 <= faces) return;
    translator.warn("mesh.direction", Path(instance.name),
                    "anisotropic reflection on " + std::to_string(without) + " of " + std::to_string(faces) +
                        " triangles whose texture coordinates give no direction: it is brushed about the y axis of "
                        "the mesh's space; give the mesh texture coordinates (st), whose u is the direction");
  }

  void add(InstanceDescription&& instance, const MeshRecord& mesh) {
    out.scene.instances.push_back(std::move(instance));
    out.material_paths.insert(out.material_paths.end(), mesh.materials.begin(), mesh.materials.end());
  }

  const std::shared_ptr<const DisneyMaterial>& material(const Path& prim, const Path& id,
                                                        const InstanceDescription& instance) {
    const std::vector<UvSetName> by_instance = instance.values ? instance.values->names() : std::vector<UvSetName>();
    const auto has = [&](const UvSetName& name) {
      return instance.prototype->mesh.primvar(name) ||
             std::find(by_instance.begin(), by_instance.end(), name) != by_instance.end();
    };
    const auto& own = translator.default_materials_[(has(kDisplayColor) ? 1u : 0u) | (has(kDisplayOpacity) ? 2u : 0u)];
    if (id.empty()) return own;
    if (const MaterialRecord* record = materials.find(id); record && record->material) {
      if (!record->display_name.empty()) out.display_names.emplace_back(id, record->display_name);
      return record->material;
    }
    translator.warn("mesh.material", prim,
                    "material " + id.str() + " does not exist; the default is used" + nearest<MaterialRecord>(id));
    return own;
  }

  void warn_of_instancer(const char* code, const Path& where, const std::string& text) {
    std::string end;
    if (std::string_view(code) == "instancer.missing") {
      const auto* mesh = find_record<MeshRecord>(records, where);
      const InstancerRecord* inner = find_instancer(where);
      end = nearest<InstancerRecord>(mesh ? mesh->instancer : inner ? inner->parent : Path());
    }
    translator.warn(code, where, text + end);
  }

  /// The end of a sentence about a path that no record of this kind has.
  template <class T>
  std::string nearest(const Path& path) {
    if (const auto known = answers.find(path); known != answers.end()) return known->second;
    if (answers.size() == kMostAnswers) return {};
    std::vector<std::string> names;
    for (const auto& [name, record] : records)
      if (std::any_cast<T>(&record)) names.push_back(name.str());
    if constexpr (std::is_same_v<T, MaterialRecord>)
      for (const Edit& edit : parts.unread)
        if (edit.waits_for_use) names.push_back(edit.id.str());
    return answers[path] = support::DidYouMean(path.str(), names);
  }

  // A light may name a category that no mesh has. A warning is given only where a similar category exists.
  void check_link(const Path& path, const char* parameter, const Token& category) {
    if (category.empty()) return;
    if (!known_categories) known_categories = find_categories();
    const std::string& name = category.str();
    if (std::binary_search(known_categories->begin(), known_categories->end(), name)) return;
    auto end = link_ends.find(category);
    if (end == link_ends.end()) {
      if (link_ends.size() == kMostAnswers) return;
      end = link_ends.emplace(category, support::DidYouMean(name, *known_categories)).first;
    }
    if (!end->second.empty())
      translator.warn("light.link", path,
                      std::string(parameter) + " names category '" + name + "', which no mesh has" + end->second);
  }
  std::vector<std::string> find_categories() const {
    std::set<std::string> all;
    const auto add_all = [&](const std::vector<Token>& names) {
      for (const Token& name : names) all.insert(name.str());
    };
    for (const auto& [path, record] : records) {
      if (const auto* mesh = std::any_cast<MeshRecord>(&record)) add_all(mesh->categories);
      const auto* instancer = std::any_cast<InstancerRecord>(&record);
      if (instancer && instancer->categories)
        for (const std::vector<Token>& of_instance : *instancer->categories) add_all(of_instance);
    }
    return {all.begin(), all.end()};
  }
};

Translation SceneTranslator::translate(const Parts& parts) {
  std::erase_if(reversed_edges_, [](const auto& entry) { return entry.first.expired(); });
  found_.clear();
  Run run{.translator = *this, .parts = parts, .out = {}, .category_sets = CategorySets(parts.records)};
  run.out.shutter = parts.shutter, run.out.motion = parts.motion;
  run.out.scene.light_groups = find_light_groups(parts.records);
  run.out.memory = std::make_shared<MemoryReservation>(parts.memory, MemoryUse::scene);
  for (const auto& [path, record] : parts.records) {
    if (const auto* mesh = std::any_cast<MeshRecord>(&record)) run.add_mesh(path, *mesh);
    if (const auto* light = std::any_cast<LightRecord>(&record); light && light->visible) run.add_light(path, *light);
  }
  run.report_open_clear();
  run.out.scene.category_sets = run.category_sets.take();
  run.out.categories = run.category_sets.names();
  faults_.report(sink_, std::move(found_));
  return std::move(run.out);
}

}  // namespace alabaster::hd::prims
