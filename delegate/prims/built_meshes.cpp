#include "delegate/prims/built_meshes.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <set>

namespace alabaster::hd::prims {
namespace {

bool is_shown(const support::Selection& selection, const Path& path, const MeshRecord& mesh) {
  return selection.includes(path, mesh.visible, mesh.render_tag);
}

// By the mesh's slots; empty if no material of it displaces.
Displacements displacements_of(const MeshRecord& mesh, MaterialLookup& materials) {
  const auto displaces = [&](const Path& path) {
    const MaterialRecord* record = materials.find(path);
    return record && record->material->displacement;
  };
  Displacements all;
  if (std::none_of(mesh.materials.begin(), mesh.materials.end(), displaces)) return all;
  for (const Path& path : mesh.materials)
    all.push_back(displaces(path) ? materials.find(path)->material->displacement : std::nullopt);
  return all;
}

// Those that its materials and AOVs read, but for those that every mesh has.
NamedPrimvars primvars_of(const MeshRecord& mesh, MaterialLookup& materials, const MeshView& view) {
  std::set<Token> names(view.primvars.begin(), view.primvars.end());
  for (const Path& path : mesh.materials)
    if (const MaterialRecord* const record = materials.find(path); record && record->material)
      for (const UvSetName& name : record->material->primvars()) names.emplace(name.text());
  names.erase(kDisplayColor), names.erase(kDisplayOpacity);
  if (names.empty()) return {};
  return {{names.begin(), names.end()}, mesh.other_primvars};
}

// One that deforms is the same mesh at all times.
bool is_diced(const PulledMesh& mesh) {
  return mesh.point_samples.times.size() < 2 && mesh.style.refineLevel > 0 && is_refined(mesh);
}

// Where the instances of a mesh stand at the frame's time. Faults of instancers are the translation's to report.
std::vector<Matrix4d> placements_of(const Path& path, const MeshRecord& mesh, support::Placements& placements) {
  if (mesh.instancer.empty()) return {mesh.transform};
  std::vector<Matrix4d> all;
  try {
    for (const support::Placement& placed : placements.place(path, mesh.instancer, mesh.instance_indices))
      if (placed.used) all.push_back(mesh.transform * placed.matrix);
  } catch (const support::TooManyInstances&) {
    all.clear();
  }
  return all;
}

MeshRequest request_of(const Path& path, const MeshRecord& mesh, MaterialLookup& materials, const MeshView& view,
                       support::Placements& placements) {
  MeshRequest request{displacements_of(mesh, materials), primvars_of(mesh, materials, view), {}, {}};
  if (view.dicing.edge_length > 0 && is_diced(*mesh.source)) {
    request.dicing = view.dicing;
    request.placements = placements_of(path, mesh, placements);
  }
  return request;
}

// None: it was cancelled.
std::optional<MeshResult> build_one(const MeshJob& job, SceneParam* param, const CancelToken& cancel) {
  if (cancel.is_cancelled()) return std::nullopt;
  try {
    return build_mesh_job(job, param, cancel);
  } catch (const BuildCancelled&) {
    return std::nullopt;
  }
}

}  // namespace

SceneFaults BuiltMeshes::faults(const Records& records, const support::Selection& selection) const {
  SceneFaults faults;
  for (const auto& [path, held] : held_)
    if (held.built.fault && is_shown(selection, path, *find_record<MeshRecord>(records, path)))
      faults.emplace(path, *held.built.fault);
  return faults;
}

// Makes `held_` the meshes of the records, moves those that are gone or hidden to `dropped_`, and returns those to
// build. A mesh that has not been edited for kMostUnedited builds gives up what would make an edit of its points quick.
std::vector<BuiltMeshes::Entry*> BuiltMeshes::collect(const Scene& scene, const std::shared_ptr<MemoryBudget>& budget) {
  const auto& [records, selection, view] = scene;
  support::Placements placements(
      [&held = scene.records](const Path& path) { return find_record<InstancerRecord>(held, path); },
      [](const char*, const Path&, const std::string&) {}, hold_placements_in(budget));
  MaterialLookup materials(records);
  support::AscendingLookup known(held_);
  ++collections_;
  size_t kept = 0;
  std::map<Path, Held> made;
  std::vector<Entry*> to_build;
  for (const auto& [path, record] : records) {
    const auto* mesh = std::any_cast<MeshRecord>(&record);
    if (!mesh || !mesh->visible || !mesh->source || !mesh->slots) continue;
    MeshRequest request;
    in_name_of(path.str(),
               [&, &id = path, &seen = view] { request = request_of(id, *mesh, materials, seen, placements); });
    Held* const held = known.find(path);
    const bool same_shape = held && held->job->source == mesh->source && held->job->request == request;
    if (same_shape && held->job->slots == mesh->slots && held->done) {
      constexpr int kMostUnedited = 16;
      if (held->edits && ++held->unedited_builds == kMostUnedited) held->edits->rest();
      held->collection = collections_;
      ++kept;
      continue;
    }
    if (!is_shown(selection, path, *mesh)) continue;
    MeshJob job{path, mesh->source, mesh->slots, std::move(request), nullptr, {}};
    to_build.push_back(&*made.emplace(path, make_held(std::move(job), held, same_shape, budget)).first);
  }
  drop_all_but(kept);
  held_.merge(made);
  return to_build;
}

// A mesh to build, with what it takes from the one before it (may be null).
BuiltMeshes::Held BuiltMeshes::make_held(MeshJob job, const Held* before, bool same_shape,
                                         const std::shared_ptr<MemoryBudget>& budget) const {
  Held next{nullptr, {}};
  next.collection = collections_;
  if (before) {
    next.faults = before->faults;
    job.edits = next.edits = edits_after(*before, job, budget);
    // Displacement is a material's.
    if (same_shape && before->has_shape && job.request.displacements.empty()) {
      job.shape = next.built = before->built;
      next.has_shape = true;
    }
  }
  next.job = std::make_shared<const MeshJob>(std::move(job));
  return next;
}

// Drops the meshes that this collection has not kept. Where memory runs out, all are held still.
void BuiltMeshes::drop_all_but(size_t kept) {
  if (kept == held_.size()) return;
  dropped_.reserve(dropped_.size() + held_.size() - kept);
  for (auto held = held_.begin(); held != held_.end();) {
    if (held->second.collection == collections_) {
      ++held;
      continue;
    }
    dropped_.push_back(std::move(held->second));
    held = held_.erase(held);
  }
}

// Where the topology is the same, the triangles mostly are. With motion samples there are several shapes to build.
std::shared_ptr<PointEdits> BuiltMeshes::edits_after(const Held& from, const MeshJob& next,
                                                     const std::shared_ptr<MemoryBudget>& budget) const {
  const PulledMesh &a = *from.job->source, &b = *next.source;
  if (!(a.topology == b.topology) || !(a.curves == b.curves) || !(a.tags == b.tags) || !(a.style == b.style))
    return nullptr;
  if (b.point_samples.times.size() > 1 || next.request.dicing.edge_length > 0) return nullptr;
  if (!from.edits && from.built.prototype) return std::make_shared<PointEdits>(budget);
  return from.edits;
}

void BuiltMeshes::rest() {
  for (auto& [path, held] : held_)
    if (held.edits) held.edits->rest();
}

void BuiltMeshes::adopt(Held* held, MeshResult result, const alabaster::DiagnosticSink& sink) {
  held->has_shape = result.built.prototype && !result.built.reported;
  held->built = std::move(result.built);
  held->done = true;
  held->faults.report(sink, std::move(result.reports));
}

void BuiltMeshes::build(const Scene& scene, SceneParam* param, const CancelToken& cancel) {
  const std::vector<Entry*> to_build = collect(scene, param->memory());
  if (to_build.empty()) return;
  release_dropped();  // their memory may be needed
  build_batch(build_first(to_build, param, cancel), param, cancel);
}

// Builds one of each geometry that no mesh has yet. Answers with the others, which then have its shape.
std::vector<BuiltMeshes::Entry*> BuiltMeshes::build_first(const std::vector<Entry*>& to_build, SceneParam* param,
                                                          const CancelToken& cancel) {
  std::set<const MeshPrototype*> known;
  std::vector<Entry*> all;
  MeshJobs built, jobs;
  for (Entry& entry : held_)
    if (const Held& held = entry.second; held.done && held.has_shape && known.insert(held.built.prototype.get()).second)
      all.push_back(&entry), built.push_back(held.job);
  for (Entry* entry : to_build) all.push_back(entry), jobs.push_back(entry->second.job);
  const std::vector<size_t> first = find_equal_meshes(built, jobs, cancel);
  std::vector<Entry*> alone, others;
  for (size_t i = 0; i < to_build.size(); ++i) (first[i] == built.size() + i ? alone : others).push_back(to_build[i]);
  build_batch(alone, param, cancel);
  for (size_t i = 0; i < to_build.size(); ++i) {
    if (first[i] == built.size() + i) continue;  // in `alone`
    const Held& from = all[first[i]]->second;
    Held& held = to_build[i]->second;
    if (!from.done || !from.has_shape) continue;
    if (*held.job->slots == *from.job->slots) {
      adopt(&held, {from.built, {}}, param->sink());
      continue;
    }
    MeshJob job = *held.job;
    job.shape = held.built = from.built;
    held.has_shape = true;
    held.job = std::make_shared<const MeshJob>(std::move(job));
  }
  std::erase_if(others, [](const Entry* entry) { return entry->second.done; });
  return others;
}

// Embree and OpenSubdiv do not ask for a cancel at each moment of a large mesh.
void BuiltMeshes::build_batch(const std::vector<Entry*>& to_build, SceneParam* param, const CancelToken& cancel) {
  std::vector<std::optional<MeshResult>> results(to_build.size());
  Refusals refusals;
  const auto build = [&](size_t i) {
    const MeshJob& job = *to_build[i]->second.job;
    refusals.run(job.path.str(), [&] { results[i] = build_one(job, param, cancel); });
  };
  param->run([&] { tbb::parallel_for(size_t(0), to_build.size(), build); });
  for (size_t i = 0; i < to_build.size(); ++i)
    if (results[i]) adopt(&to_build[i]->second, std::move(*results[i]), param->sink());
  cancel.check();
  refusals.check();
}

}  // namespace alabaster::hd::prims
