#include "delegate/description/model.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <utility>

#include "delegate/archive/archive.h"
#include "delegate/description/places.h"
#include "delegate/gltf/gltf_scene.h"
#include "delegate/support/extension.h"
#include "delegate/support/lookup.h"
#include "delegate/usd/usd_source.h"

namespace alabaster::hd::description {
namespace {

using host::PrimDescription;
using host::SourceFault;

// Samples -------------------------------------------------------------------------------------------

constexpr size_t kFewestSteps = 4, kMostSteps = 128, kMostStepsOfPoints = 32;  // as the renderer takes
constexpr double kLargestTurn = 5;      // of a thing, from one sample to the next
constexpr double kLargestAxisTurn = 4;  // of one of its axes, which may turn by 0.816 times as much as it does
const Token kTransform("transform");

bool is_sampled(const host::MeshDescription&, const Token& name) {
  return name == Token("points") || name == Token("normals");
}
bool is_sampled(const host::InstancerDescription&, const Token& name) {
  return name.str().starts_with("hydra:instance");
}
const Value& value_of(const Value& value) {
  return value;
}
const Value& value_of(const host::PrimvarValue& primvar) {
  return primvar.value;
}

/// What may move or deform, unless the file has samples of it.
std::map<Token, Value> moving_parts(const PrimDescription& prim) {
  std::map<Token, Value> parts;
  const auto add = [&](const auto& of) {
    if constexpr (requires { of.transformSamples; })
      if (of.transformSamples.values.empty()) parts[kTransform] = of.transform;
    if constexpr (requires { of.primvarSamples; })
      for (const auto& [name, primvar] : of.primvars)
        if (is_sampled(of, name) && !of.primvarSamples.contains(name)) parts[name] = value_of(primvar);
  };
  std::visit(add, prim);
  return parts;
}

/// Nodes whose morph weights are equal at one time share a mesh there, which an instancer places.
bool is_placed_alike(const PrimDescription& a, const PrimDescription& b) {
  const auto *mesh = std::get_if<host::MeshDescription>(&a), *other = std::get_if<host::MeshDescription>(&b);
  return a.index() == b.index() && (!mesh || mesh->instancer == other->instancer);
}
bool has_same_points(const PrimDescription& a, const PrimDescription& b) {
  const auto *mesh = std::get_if<host::MeshDescription>(&a), *other = std::get_if<host::MeshDescription>(&b);
  return !mesh || (mesh->topology == other->topology && mesh->curves == other->curves);
}

double angle_between(const Vec3d& a, const Vec3d& b) {
  return std::atan2(a.cross(b).length(), a.dot(b)) * 180 / M_PI;
}

/// The largest angle by which ways bend, which point(i, pose) follows. Each third pose is seen from its neighbours, so
/// that a corner at a sample is none. Bends of less than a thousandth of the longest way are not seen.
template <class PointAt>
double largest_bend(size_t points, size_t poses, const PointAt& point) {
  double longest = 0, bend = 0;
  for (size_t p = 0; p < points; ++p)
    for (size_t i = 1; i < poses; ++i) longest = std::max(longest, (point(p, i) - point(p, 0)).length());
  for (size_t p = 0; p < points; ++p)
    for (size_t i = 1; i + 1 < poses; i += 2) {
      const Vec3d from = point(p, i - 1), middle = point(p, i), to = point(p, i + 1);
      if ((middle - (from + to) * 0.5).length() > 1e-3 * longest)
        bend = std::max(bend, angle_between(middle - from, to - middle));
    }
  return bend;
}

/// The largest turn from one of even poses to the next, in degrees of a thing that is turned as a whole.
double largest_turn(const std::vector<Value>& poses) {
  std::vector<Array<Matrix4d>> maps;
  std::vector<Array<Vec3f>> points;
  size_t count = poses.front().is_array() ? poses.front().count() : 1;
  for (const Value& pose : poses) {
    if (const auto* map = pose.get<Matrix4d>()) maps.push_back(Array<Matrix4d>{*map});
    if (const auto* all = pose.get<Array<Matrix4d>>()) maps.push_back(*all), count = std::min(count, all->size());
    if (const auto* all = pose.get<Array<Vec3f>>()) points.push_back(*all), count = std::min(count, all->size());
  }
  if (points.size() == poses.size())
    return largest_bend(count, poses.size(), [&](size_t p, size_t i) { return Vec3d(points[i][p]); });
  if (maps.size() != poses.size()) return 0;
  double turn = largest_bend(count, poses.size(), [&](size_t p, size_t i) { return maps[i][p].translation(); });
  for (size_t p = 0; p < count; ++p)
    for (size_t i = 1; i < maps.size(); ++i)
      for (int axis = 0; axis < 3; ++axis) {
        const auto of = [&](size_t pose) {
          return Vec3d(maps[pose][p][axis][0], maps[pose][p][axis][1], maps[pose][p][axis][2]);
        };
        turn = std::max(turn, angle_between(of(i - 1), of(i)) * kLargestTurn / kLargestAxisTurn);
      }
  return turn;
}

size_t bytes_of(const Value& value) {
  return value.is_array() ? value.count() * size_t(GetTypeInfo(value.type()).bytes) : 0;
}

// Places --------------------------------------------------------------------------------------------

/// Puts a root before the paths of a prim, and before the categories that light links name, which are of its scene.
class Rerooted {
 public:
  explicit Rerooted(std::string root) : root_(std::move(root)) {}

  Path path(const Path& given) const { return given.str().starts_with('/') ? Path(root_ + given.str()) : given; }
  void apply(PrimDescription* prim) const {
    std::visit([this](auto& one) { apply_to(one); }, *prim);
  }
  /// Parameters of a prim.
  template <class Named>
  void change(Named* values) const {
    for (auto& [name, value] : *values) {
      if (const auto* named = value.template get<Path>()) value = path(*named);
      if (const Token key(name); key == Token("lightLink") || key == Token("shadowLink"))
        value = Token(root_ + " " + value.text_or(""));
    }
  }

 private:
  template <class T>
  void apply_to(T& prim) const {
    if constexpr (requires { prim.material; }) prim.material = path(prim.material);
    if constexpr (requires { prim.instancer; }) prim.instancer = path(prim.instancer);
    if constexpr (requires { prim.parent; }) prim.parent = path(prim.parent);
    if constexpr (requires { prim.camera; }) prim.camera = path(prim.camera);
    if constexpr (requires { prim.indices; }) prim.indices = with_keys(prim.indices);
    if constexpr (requires { prim.categories; }) put_before(&prim.categories);
    if constexpr (requires { prim.parameters; }) change(&prim.parameters);
    if constexpr (requires { prim.topology; })
      for (GeomSubset& subset : prim.topology.geomSubsets)
        subset.id = path(subset.id), subset.materialId = path(subset.materialId);
    if constexpr (requires { prim.products; })
      for (RenderProduct& product : prim.products) product.camera = path(product.camera);
    if constexpr (requires { prim.nodes; }) {
      prim.nodes = with_keys(prim.nodes);
      for (auto& [id, node] : prim.nodes) {
        change(&node.parameters);
        for (auto& [input, connections] : node.inputConnections)
          for (MaterialConnection& connection : connections) connection.upstreamNode = path(connection.upstreamNode);
      }
      for (auto& [name, terminal] : prim.terminals) terminal.upstreamNode = path(terminal.upstreamNode);
    }
  }
  template <class T>
  std::map<Path, T> with_keys(const std::map<Path, T>& entries) const {
    std::map<Path, T> all;
    for (const auto& [key, value] : entries) all.emplace(path(key), value);
    return all;
  }
  void put_before(Token* category) const { *category = Token(root_ + " " + category->str()); }
  template <class T>
  void put_before(std::vector<T>* all) const {
    for (T& one : *all) put_before(&one);
  }

  const std::string root_;
};

}  // namespace

std::unique_ptr<host::SceneSource> source_of(const std::string& file) {
  const std::string extension = support::lower_extension(file);
  if (extension == ".gltf" || extension == ".glb") return gltf::MakeGltfSource();
  if (usd::is_stage(extension)) return usd::MakeStageSource();
  return extension == ".alab" ? archive::MakeArchiveSource() : nullptr;
}

/// Asks for poses over the shutter about a time.
struct OpenModel::Sampler {
  using Parts = std::map<Token, std::vector<Value>>;  // at even times

  OpenModel& model;
  const double time;
  const DiagnosticSink& sink;
  SourceFault fault = SourceFault::none;
  std::map<Path, Parts> moving = {};
  std::map<Path, std::map<Token, Value>> next = {};  // a frame later, of what moves until then or within the shutter
  std::set<Path> apart = {};                         // not there, or not by themselves, at all times

  /// In the unit of the source, from the frame's own time on.
  double after(size_t step, size_t steps) const {
    const double open = model.shutter.open / model.frames_per_unit();
    const double length = model.shutter.close / model.frames_per_unit() - open;
    return open + length * double(step) / double(steps);
  }

  bool ask(size_t step, size_t steps) {
    fault = model.ask(time + after(step, steps), sink, &model.stirred_);
    return fault == SourceFault::none;
  }

  /// Adds the parts of a prim as they are now.
  void add(const Path& path, const PrimDescription& drawn, Parts* parts) {
    const PrimDescription* now = support::find_in(model.now_.GetPrims(), path);
    if (!now || !is_placed_alike(*now, drawn)) {
      apart.insert(path);
      return;
    }
    const bool same_points = has_same_points(*now, drawn);
    for (auto& [name, value] : moving_parts(*now))
      if (const auto part = parts->find(name); part != parts->end() && (name == kTransform || same_points))
        part->second.push_back(std::move(value));
  }

  bool run() {
    // Few poses tell what moves.
    for (size_t i = 0; i <= kFewestSteps; ++i) {
      if (!ask(i, kFewestSteps)) return false;
      for (const Path& path : model.stirred_) {
        const std::optional<PrimDescription>& drawn = model.drawn_.at(path);
        if (!drawn) continue;
        const auto [found, is_new] = moving.try_emplace(path);
        if (is_new)
          for (auto& [name, value] : moving_parts(*drawn)) found->second[name].assign(i, value);
        if (!found->second.empty()) add(path, *drawn, &found->second);
      }
    }
    for (auto& [path, parts] : moving)
      std::erase_if(parts, [](const auto& part) {
        const std::vector<Value>& poses = part.second;
        return poses.size() != kFewestSteps + 1 ||
               std::all_of(poses.begin(), poses.end(), [&](const Value& pose) { return pose == poses.front(); });
      });
    hold();
    // More of them for what turns far. What turns by as much from one to the next has a corner, which none mends.
    std::map<std::vector<Value>*, double> turns;
    for (size_t steps = kFewestSteps; steps < kMostSteps; steps *= 2) {
      std::map<Path, Parts> finer;
      for (auto& [path, parts] : moving)
        for (auto& [name, poses] : parts) {
          if (poses.size() != steps + 1) continue;
          if (steps >= kMostStepsOfPoints && poses.front().get<Array<Vec3f>>()) continue;
          const double turn = largest_turn(poses);
          const auto before = turns.find(&poses);
          const bool falls = before == turns.end() || turn < 0.75 * before->second;
          if (turn > kLargestTurn && falls) finer[path][name] = {}, turns[&poses] = turn;
        }
      if (finer.empty()) return true;
      for (size_t step = 1; step < 2 * steps; step += 2) {
        if (!ask(step, 2 * steps)) return false;
        for (auto& [path, parts] : finer) add(path, *model.drawn_.at(path), &parts);
      }
      for (auto& [path, parts] : finer)
        for (auto& [name, between] : parts) {
          if (between.size() != steps) continue;
          std::vector<Value>& poses = moving[path][name];
          std::vector<Value> all{poses.front()};
          for (size_t i = 0; i < steps; ++i) all.push_back(std::move(between[i])), all.push_back(poses[i + 1]);
          poses = std::move(all);
        }
      hold();
    }
    return true;
  }

  bool run_next() {
    fault = model.ask(time + 1 / model.frames_per_unit(), sink, &model.stirred_);
    if (fault != SourceFault::none) return false;
    for (const Path& path : model.stirred_) {
      const std::optional<PrimDescription>& drawn = model.drawn_.at(path);
      const PrimDescription* const then = support::find_in(model.now_.GetPrims(), path);
      if (!drawn || !then || !is_placed_alike(*then, *drawn)) continue;
      const bool same_points = has_same_points(*then, *drawn);
      const std::map<Token, Value> before = moving_parts(*drawn);
      for (auto& [name, value] : moving_parts(*then)) {
        const auto known = before.find(name);
        if (known == before.end() || !(name == kTransform || same_points)) continue;
        const auto of = moving.find(path);
        const bool moves = of != moving.end() && of->second.contains(name);
        if (moves || value != known->second) next[path][name] = std::move(value);
      }
    }
    hold();
    return true;
  }

  void hold() const {
    size_t bytes = 0;
    for (const auto& [path, parts] : moving)
      for (const auto& [name, poses] : parts) bytes += poses.size() * bytes_of(poses.front());
    for (const auto& [path, parts] : next)
      for (const auto& [name, value] : parts) bytes += 2 * bytes_of(value);
    if (!model.held_.bytes()) model.held_ = MemoryReservation(model.memory, MemoryUse::scene);
    model.held_.resize(bytes, model.source->Facts().files.front() + ": the geometry over the shutter");
  }

  void give_samples(const Path& path, PrimDescription* drawn) {
    if (apart.contains(path)) return;
    const std::map<Token, Value> now = moving_parts(*drawn);
    const auto give = [&](auto& prim) {
      for (auto& [name, poses] : timed(path, now)) {
        if constexpr (requires { prim.transformSamples; })
          if (name == kTransform)
            for (const auto& [frame, pose] : poses)
              prim.transformSamples.times.push_back(frame),
                  prim.transformSamples.values.push_back(pose.get_or(Matrix4d()));
        if constexpr (requires { prim.primvarSamples; })
          if (name != kTransform) {
            auto& samples = prim.primvarSamples[name] = {};
            for (auto& [frame, pose] : poses) samples.times.push_back(frame), samples.values.push_back(std::move(pose));
          }
      }
    };
    std::visit(give, *drawn);
  }

  // The samples of what moves, by their frames. `now`: in the frame that is drawn.
  std::map<Token, std::map<double, Value>> timed(const Path& path, const std::map<Token, Value>& now) {
    std::map<Token, std::map<double, Value>> all;
    if (const auto parts = moving.find(path); parts != moving.end())
      for (auto& [name, poses] : parts->second)
        for (size_t i = 0; i < poses.size(); ++i)
          all[name][after(i, poses.size() - 1) * model.frames_per_unit()] = std::move(poses[i]);
    if (const auto parts = next.find(path); parts != next.end())
      for (auto& [name, value] : parts->second) {
        const auto within = [&](double frame) { return frame >= model.shutter.open && frame <= model.shutter.close; };
        auto& samples = all[name];
        const bool known = !samples.empty();
        if (!known || !within(0)) samples[0] = now.at(name);
        if (!known || !within(1)) samples[1] = std::move(value);
      }
    return all;
  }
};

std::optional<double> OpenModel::time_of(const LoadOptions& options) const {
  if (options.frame) return own_time.value_or(0) + *options.frame / frames_per_unit();
  if (options.time || shutter.close > shutter.open) return own_time.value_or(0) + options.time.value_or(0);
  return own_time;
}

// Frames are those of the time codes unless another rate is asked for.
double OpenModel::frames_per_unit() const {
  const double codes = source->Facts().timeCodesPerSecond;
  return codes > 0 ? (frames_per_second ? *frames_per_second / codes : 1) : frames_per_second.value_or(24);
}

SourceFault OpenModel::ask(std::optional<double> at, const DiagnosticSink& sink, std::set<Path>* touched) {
  host::SceneEdits edits;
  if (const SourceFault fault = source->Pose(at, sink, &edits); fault != SourceFault::none) return fault;
  const auto note = [&](const Path& path) {
    const PrimDescription* before = support::find_in(now_.GetPrims(), path);
    drawn_.try_emplace(path, before ? std::optional(*before) : std::nullopt);
    touched->insert(path);
  };
  for (const auto& [path, prim] : edits.prims) note(path);
  for (const auto& [path, fields] : edits.changes) note(path);
  for (const Path& path : edits.removed) note(path);
  return apply(std::move(edits), sink, &now_);
}

SourceFault OpenModel::pose(std::optional<double> at, const DiagnosticSink& sink, host::SceneEdits* edits) {
  if (!source->Facts().varies) return source->Pose(at, sink, edits);
  drawn_.clear();
  due_.merge(std::exchange(stirred_, {}));
  if (const SourceFault fault = ask(at, sink, &due_); fault != SourceFault::none) return fault;
  for (const Path& path : due_) {
    const PrimDescription* now = support::find_in(now_.GetPrims(), path);
    drawn_[path] = now ? std::optional(*now) : std::nullopt;
  }
  const DiagnosticSink errors = [&sink](const Diagnostic& diagnostic) {
    if (diagnostic.severity == Severity::error && sink) sink(diagnostic);
  };
  Sampler sampler{*this, at.value_or(0), errors};
  if (shutter.close > shutter.open && !sampler.run()) return sampler.fault;
  if (next_frame && at && !sampler.run_next()) return sampler.fault;
  for (const Path& path : sampler.apart)
    if (sink)
      sink({Severity::warning, "model.motion", source->Facts().files.front() + ": " + path.str(),
            "It is not there, or not by itself, at all times of the shutter; it is drawn without motion blur."});
  for (auto& [path, drawn] : drawn_) {
    if (!drawn) {
      edits->removed.push_back(path);
      continue;
    }
    sampler.give_samples(path, &*drawn);
    edits->set(path, std::move(*drawn), support::value_in(now_.GetNames(), path));
  }
  return SourceFault::none;
}

void OpenModel::place(host::SceneEdits* edits) const {
  for (auto& [path, prim] : edits->prims) {
    if (placement.transform) place_prim(*placement.transform, &prim);
    if (!placement.motion.values.empty()) move_prim(placement.motion, &prim);
  }
  if (root.empty()) return;
  const Rerooted rerooted(root);
  host::SceneEdits all;
  for (auto& [path, prim] : edits->prims) {
    rerooted.apply(&prim);
    all.prims.emplace(rerooted.path(path), std::move(prim));
  }
  for (const Path& path : edits->removed) all.removed.push_back(rerooted.path(path));
  for (auto& [path, name] : edits->names) all.names.emplace(rerooted.path(path), std::move(name));
  *edits = std::move(all);
}

SourceFault OpenModel::apply(host::SceneEdits edits, const DiagnosticSink& sink,
                             host::RetainedSceneDelegate* scene) const {
  const std::string fault = host::ApplyEdits(std::move(edits), scene);
  if (fault.empty()) return SourceFault::none;
  if (sink)
    sink({Severity::error, "model.change", source->Facts().files.front(),
          "A change from one pose to the next is refused: " + fault +
              ". Load the scene again; if that does not help, leave the prim's animation out of the file."});
  return SourceFault::input;
}

}  // namespace alabaster::hd::description
