#include "core/geometry/subdivision.h"

#include <opensubdiv/bfr/surface.h>
#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <map>
#include <memory>
#include <string>

#include "core/geometry/edge_rates.h"
#include "core/geometry/face_pattern.h"
#include "core/geometry/index.h"
#include "core/geometry/subdivision_topology.h"

namespace alabaster {
namespace {

namespace Bfr = OpenSubdiv::Bfr;
namespace Far = OpenSubdiv::Far;

using Surface = Bfr::Surface<float>;

constexpr uint32_t kNone = ~0u;

// Where in the mesh the samples of a face lie.
struct FaceLayout {
  bool drawn = false;                              // else it has no limit surface
  uint32_t boundary = 0, samples = 0, facets = 0;  // of its pattern
  uint32_t interior = 0;                           // first interior point
  uint32_t normals = 0;                            // first normal of its own (samples along sharp features)
  uint32_t corners = 0;                            // first value of each face-varying primvar
  uint32_t triangles = 0;
};

// Points on the cage's vertices and edges belong to the first face that has them; it alone evaluates them, so that
// neighbours meet in the same bits.
struct SharedSamples {
  uint32_t first = kNone;
  int owner = -1;
};

// A primvar of the cage, and where its refined values go.
struct Track {
  Interpolation interpolation = Interpolation::vertex;
  size_t width = 0;               // floats
  const float* values = nullptr;  // of the cage
  const std::vector<int>* indices = nullptr;
  float* out = nullptr;  // in the mesh
  const float* value(size_t vertex) const {
    return values + width * (indices->empty() ? vertex : at((*indices)[vertex]));
  }
};

// Primvars with a value for each point, interleaved: one evaluation gives all.
struct PointTracks {
  std::vector<const Track*> tracks;
  std::vector<float> controls;
  int width = 0;

  void add_controls(size_t vertex) {
    for (const Track* track : tracks) {
      const float* const value = track->value(vertex);
      controls.insert(controls.end(), value, value + track->width);
    }
  }
  void write(uint32_t point, const float* v) const {
    for (const Track* track : tracks) {
      std::copy_n(v, track->width, track->out + point * track->width);
      v += track->width;
    }
  }
};

// Arrays that a task reuses from face to face.
struct Workspace {
  Surface points, varying, corners;
  FacePattern pattern;
  std::vector<float> point_controls, varying_controls, corner_controls;
  std::vector<float> value, du, dv;  // of one sample
};

class LimitTessellator {
 public:
  LimitTessellator(const Cage& cage, const Far::TopologyRefiner& refiner, const EdgeRates& rates,
                   const CancelToken& cancel)
      : cancel_(cancel), cage_(cage), base_(refiner.GetLevel(0)), factories_(refiner, rates.level()), rates_(rates) {
    find_faces();
    find_sharp_features();
  }

  Mesh run() {
    // A surface that cannot be made after all is found only on the way: then once more without that face.
    do {
      lay_out();
      std::vector<uint8_t> failed(faces_.size(), 0);
      const tbb::blocked_range<size_t> all(0, faces_.size(), faces_a_task());
      tbb::parallel_for(all, [&](const tbb::blocked_range<size_t>& range) {
        Workspace workspace;
        for (size_t face = range.begin(); face < range.end(); ++face)
          if (faces_[face].drawn && !tessellate(static_cast<int>(face), &workspace)) failed[face] = 1;
      });
      again_ = false;
      for (size_t face = 0; face < faces_.size(); ++face)
        if (failed[face]) {
          faces_[face].drawn = false;
          again_ = true;
        }
    } while (again_);
    if (mesh_.points.empty()) return std::move(mesh_);  // no face has a limit surface
    mend_degenerate_normals();
    for_each_attribute([&](const auto& primvar, auto* attribute) {
      if (primvar.interpolation == Interpolation::face_varying) attribute->triangles = corner_triangles_;
    });
    return std::move(mesh_);
  }

 private:
  // A face of level 3 is work enough for a task: a cage of six faces may become 100,000 triangles.
  size_t faces_a_task() const { return std::max(size_t(1), size_t(64) >> 2 * std::min(rates_.level(), 3)); }

  void find_faces() {
    faces_.resize(at(base_.GetNumFaces()));
    std::vector<uint8_t> invisible(faces_.size(), 0);
    for (const int face : cage_.invisible_faces) invisible[at(face)] = 1;
    for (int face = 0; face < base_.GetNumFaces(); ++face) {
      cancel_.check();
      if (invisible[at(face)] || !factories_.of(face).FaceHasLimitSurface(face)) continue;
      FacePattern own;
      const FacePattern& pattern = pattern_of(face, &own);
      faces_[at(face)] = {
          .drawn = true, .boundary = pattern.boundary, .samples = pattern.samples, .facets = pattern.triangles()};
    }
  }

  // With one rate for all edges, faces of one size share a pattern; any other is made where it is needed.
  const FacePattern& pattern_of(int face, FacePattern* own) {
    const auto parameterization = [&] { return factories_.of(face).GetFaceParameterization(face); };
    if (!rates_.uniform) {
      std::vector<int> rates;
      for (const int edge : base_.GetFaceEdges(face)) rates.push_back(static_cast<int>(rates_.of(edge)));
      return *own = make_pattern(parameterization(), rates);
    }
    const int size = base_.GetFaceVertices(face).size();
    const auto found = patterns_.find(size);
    return found != patterns_.end() ? found->second
                                    : patterns_[size] = make_pattern(parameterization(), {int(rates_.uniform)});
  }

  // Across these the tangent plane jumps: each face keeps its own normals there.
  void find_sharp_features() {
    const bool all = cage_.scheme == SubdivisionScheme::bilinear;
    sharp_edge_.resize(at(base_.GetNumEdges()));
    sharp_vertex_.resize(at(base_.GetNumVertices()));
    for (int v = 0; v < base_.GetNumVertices(); ++v)
      sharp_vertex_[at(v)] =
          all || base_.IsVertexNonManifold(v) || (base_.IsVertexInfSharp(v) && base_.GetVertexFaces(v).size() > 1);
    for (int e = 0; e < base_.GetNumEdges(); ++e) {
      const bool sharp =
          base_.GetEdgeFaces(e).size() > 1 && (all || base_.IsEdgeInfSharp(e) || base_.IsEdgeNonManifold(e));
      sharp_edge_[at(e)] = sharp;
      if (!sharp) continue;
      for (int v : {base_.GetEdgeVertices(e)[0], base_.GetEdgeVertices(e)[1]}) sharp_vertex_[at(v)] = true;
    }
  }

  // Calls visit(primvar, attribute of the mesh). The mesh's uv sets: per point first, then face-varying.
  template <class Visit>
  void for_each_attribute(const Visit& visit) {
    size_t set = 0;
    for (const bool by_corner : {false, true})
      for (const UvPrimvar& uv : cage_.uvs)
        if ((uv.interpolation == Interpolation::face_varying) == by_corner) {
          mesh_.uv_sets[set].name = uv.name;
          visit(uv, &mesh_.uv_sets[set++]);
        }
    for (size_t i = 0; i < cage_.primvars.size(); ++i) {
      NamedAttribute& named = mesh_.primvars[i];
      named.name = cage_.primvars[i].name;
      const auto visit_one = [&]<class T>(const Primvar<T>& primvar) {
        if (!std::holds_alternative<MeshAttribute<T>>(named.values)) named.values = MeshAttribute<T>();
        visit(primvar, &std::get<MeshAttribute<T>>(named.values));
      };
      std::visit(visit_one, cage_.primvars[i].values);
    }
  }

  void lay_out_primvars(uint32_t points, uint32_t corners) {
    mesh_.uv_sets.resize(cage_.uvs.size()), mesh_.primvars.resize(cage_.primvars.size());
    tracks_.clear();
    constexpr size_t kNumberBytes = sizeof(float);
    const auto add = [&]<class T>(const Primvar<T>& primvar, MeshAttribute<T>* attribute) {
      attribute->values.resize(primvar.interpolation == Interpolation::face_varying ? corners : points, T(0.0f));
      tracks_.push_back({primvar.interpolation, sizeof(T) / kNumberBytes,
                         reinterpret_cast<const float*>(primvar.values.data()), &primvar.indices,
                         reinterpret_cast<float*>(attribute->values.data())});
    };
    // The points themselves come first.
    tracks_.push_back({Interpolation::vertex, 3, &cage_.points[0].x, &no_indices_, &mesh_.points[0].x});
    for_each_attribute(add);
    vertex_ = {}, varying_ = {}, corners_.clear();
    for (const Track& track : tracks_)
      (track.interpolation == Interpolation::vertex    ? vertex_.tracks
       : track.interpolation == Interpolation::varying ? varying_.tracks
                                                       : corners_)
          .push_back(&track);
    for (PointTracks* tracks : {&vertex_, &varying_}) {
      for (size_t i = 0; i < cage_.points.size(); ++i) tracks->add_controls(i);
      tracks->width = static_cast<int>(tracks->controls.size() / cage_.points.size());
    }
    if (!corners_.empty()) corner_triangles_.assign(mesh_.triangles.size(), {});
  }

  void claim(SharedSamples* samples, int face, uint32_t count, uint32_t* points) {
    if (samples->owner >= 0) return;
    *samples = {*points, face};
    *points += count;
  }

  void lay_out() {
    vertices_.assign(at(base_.GetNumVertices()), {});
    edges_.assign(at(base_.GetNumEdges()), {});
    uint32_t points = 0, own_normals = 0, corners = 0, triangles = 0;
    for (int f = 0; f < base_.GetNumFaces(); ++f) {
      FaceLayout& face = faces_[at(f)];
      if (!face.drawn) continue;
      const auto vertices = base_.GetFaceVertices(f), edges = base_.GetFaceEdges(f);
      face.normals = own_normals;
      for (int i = 0; i < vertices.size(); ++i) {
        claim(&vertices_[at(vertices[i])], f, 1, &points);
        claim(&edges_[at(edges[i])], f, rates_.of(edges[i]) - 1, &points);
        if (sharp_vertex_[at(vertices[i])]) ++own_normals;
        if (sharp_edge_[at(edges[i])]) own_normals += rates_.of(edges[i]) - 1;
      }
      face.interior = points;
      face.corners = corners;
      face.triangles = triangles;
      points += face.samples - face.boundary;
      corners += face.samples;
      triangles += face.facets;
    }
    for (FaceLayout& face : faces_) face.normals += points;  // own normals follow the shared ones
    mesh_ = Mesh();
    mesh_.points.resize(points, Vec3f(0, 0, 0));
    // Where every face has its own normal the shared one stays unused: zero, as Imath leaves new vectors undefined.
    mesh_.normals.resize(points + own_normals, Vec3f(0, 0, 0));
    degenerate_.assign(mesh_.normals.size(), 0);
    mesh_.triangles.resize(triangles);
    mesh_.triangle_face.resize(triangles);
    if (own_normals) mesh_.normal_triangles.resize(triangles);
    if (points > 0) lay_out_primvars(points, corners);
    if (!cage_.face_material.empty()) mesh_.triangle_material.resize(triangles);
  }

  struct Sample {
    uint32_t point = 0, normal = 0;
    bool owns_point = true, owns_normal = true;
  };

  // Indices of all samples of a face, in the order of its pattern.
  std::vector<Sample> place_samples(int f) const {
    const FaceLayout& face = faces_[at(f)];
    const auto vertices = base_.GetFaceVertices(f), edges = base_.GetFaceEdges(f);
    std::vector<Sample> samples(face.samples);
    uint32_t own_normal = face.normals;
    int corner = 0;
    uint32_t along = 0;
    for (uint32_t i = 0; i < samples.size(); ++i, ++along) {
      Sample& sample = samples[i];
      if (i >= face.boundary) {
        sample.point = sample.normal = face.interior + (i - face.boundary);
        continue;
      }
      if (along == rates_.of(edges[corner])) along = 0, ++corner;
      const SharedSamples& shared = along ? edges_[at(edges[corner])] : vertices_[at(vertices[corner])];
      const bool sharp = along ? sharp_edge_[at(edges[corner])] : sharp_vertex_[at(vertices[corner])];
      const bool forward = !along || base_.GetEdgeVertices(edges[corner])[0] == vertices[corner];
      sample.point = shared.first + (along ? (forward ? along - 1 : rates_.of(edges[corner]) - 1 - along) : 0);
      sample.owns_point = shared.owner == f;
      sample.owns_normal = sharp || sample.owns_point;
      sample.normal = sharp ? own_normal++ : sample.point;
    }
    return samples;
  }

  bool tessellate(int face, Workspace* w) {
    if (!factories_.of(face).InitVertexSurface(face, &w->points)) return false;
    const std::vector<Sample> samples = place_samples(face);
    const FacePattern& pattern = pattern_of(face, &w->pattern);
    evaluate_points(pattern, samples, w);
    if (varying_.width > 0 && !evaluate_varying(face, pattern, samples, w)) return false;
    for (size_t i = 0; i < corners_.size(); ++i)
      if (!evaluate_corners(face, pattern, i, w)) return false;
    write_triangles(face, pattern, samples);
    return true;
  }

  void evaluate_points(const FacePattern& pattern, const std::vector<Sample>& samples, Workspace* w) {
    const Surface::PointDescriptor layout(vertex_.width);
    w->point_controls.resize(at(w->points.GetNumPatchPoints()) * at(vertex_.width));
    w->points.PreparePatchPoints(vertex_.controls.data(), layout, w->point_controls.data(), layout);
    for (std::vector<float>* values : {&w->value, &w->du, &w->dv}) values->resize(at(vertex_.width));
    const std::vector<float>& coordinates = pattern.coordinates;
    for (size_t i = 0; i < samples.size(); ++i) {
      if (i % 256 == 0) cancel_.check();  // a face may have 65,000
      const Sample& sample = samples[i];
      if (!sample.owns_point && !sample.owns_normal) continue;
      const std::vector<float>&du = w->du, &dv = w->dv;
      w->points.Evaluate(&coordinates[2 * i], w->point_controls.data(), layout, w->value.data(), w->du.data(),
                         w->dv.data());
      if (sample.owns_point) vertex_.write(sample.point, w->value.data());
      if (sample.owns_normal) write_normal(sample.normal, Vec3d(du[0], du[1], du[2]), Vec3d(dv[0], dv[1], dv[2]));
    }
  }

  bool evaluate_varying(int face, const FacePattern& pattern, const std::vector<Sample>& samples, Workspace* w) {
    if (!factories_.of(face).InitVaryingSurface(face, &w->varying)) return false;
    const Surface::PointDescriptor layout(varying_.width);
    w->varying_controls.resize(at(w->varying.GetNumPatchPoints()) * at(varying_.width));
    w->varying.PreparePatchPoints(varying_.controls.data(), layout, w->varying_controls.data(), layout);
    std::vector<float> value(at(varying_.width));
    for (size_t i = 0; i < samples.size(); ++i) {
      if (!samples[i].owns_point) continue;
      w->varying.Evaluate(&pattern.coordinates[2 * i], w->varying_controls.data(), layout, value.data());
      varying_.write(samples[i].point, value.data());
    }
    return true;
  }

  void write_normal(uint32_t index, const Vec3d& du, const Vec3d& dv) {
    const Vec3d n = cross(du, dv);
    // Derivatives vanish or align at some extraordinary and degenerate points: with a sine this small, rounding and the
    // approximation turn the normal by more than the neighbouring triangles are off.
    constexpr double kMinSine2 = 1e-6;
    const bool usable = dot(n, n) > kMinSine2 * dot(du, du) * dot(dv, dv);
    degenerate_[index] = !usable;
    mesh_.normals[index] = usable ? Vec3f(normalize(n)) : Vec3f(0, 0, 0);
  }

  bool evaluate_corners(int f, const FacePattern& pattern, size_t channel, Workspace* w) {
    if (!factories_.of(f).InitFaceVaryingSurface(f, &w->corners, static_cast<std::intptr_t>(channel))) return false;
    const FaceLayout& face = faces_[at(f)];
    const Track& track = *corners_[channel];
    const Surface::PointDescriptor layout(static_cast<int>(track.width));
    w->corner_controls.resize(at(w->corners.GetNumPatchPoints()) * track.width);
    w->corners.PreparePatchPoints(track.values, layout, w->corner_controls.data(), layout);
    for (uint32_t i = 0; i < pattern.samples; ++i)
      w->corners.Evaluate(&pattern.coordinates[2 * size_t(i)], w->corner_controls.data(), layout,
                          track.out + (size_t(face.corners) + i) * track.width);
    return true;
  }

  void write_triangles(int f, const FacePattern& pattern, const std::vector<Sample>& samples) {
    const FaceLayout& face = faces_[at(f)];
    for (uint32_t t = 0; t < face.facets; ++t) {
      const size_t triangle = face.triangles + t;
      for (size_t i = 0; i < 3; ++i) {
        const auto corner = static_cast<uint32_t>(pattern.facets[t][i]);
        mesh_.triangles[triangle][i] = samples[corner].point;
        if (!mesh_.normal_triangles.empty()) mesh_.normal_triangles[triangle][i] = samples[corner].normal;
        if (!corners_.empty()) corner_triangles_[triangle][i] = face.corners + corner;
      }
      mesh_.triangle_face[triangle] = f;
      if (!cage_.face_material.empty()) mesh_.triangle_material[triangle] = cage_.face_material[at(f)];
    }
  }

  // Where du x dv vanishes, the mean of the triangles around, weighted by area.
  void mend_degenerate_normals() {
    std::map<uint32_t, Vec3d> sums;
    for (uint32_t i = 0; i < degenerate_.size(); ++i)
      if (degenerate_[i]) sums.emplace(i, Vec3d(0, 0, 0));
    if (sums.empty()) return;
    const auto& corners = mesh_.normal_triangles.empty() ? mesh_.triangles : mesh_.normal_triangles;
    for (size_t t = 0; t < corners.size(); ++t)
      for (uint32_t i : corners[t]) {
        if (!degenerate_[i]) continue;
        const auto& points = mesh_.triangles[t];
        const Vec3d p(mesh_.points[points[0]]);
        sums[i] += cross(Vec3d(mesh_.points[points[1]]) - p, Vec3d(mesh_.points[points[2]]) - p);
      }
    for (const auto& [i, n] : sums)
      if (dot(n, n) > 0) mesh_.normals[i] = Vec3f(normalize(n));
  }

  const CancelToken cancel_;
  const Cage& cage_;
  const Far::TopologyLevel& base_;
  SurfaceFactories factories_;
  const EdgeRates& rates_;
  const std::vector<int> no_indices_;
  std::vector<Track> tracks_;
  PointTracks vertex_, varying_;
  std::vector<const Track*> corners_;  // face-varying, by channel of the refiner
  std::vector<Corners> corner_triangles_;
  bool again_ = false;
  std::map<int, FacePattern> patterns_;  // by face size; stable addresses
  std::vector<FaceLayout> faces_;
  std::vector<bool> sharp_edge_, sharp_vertex_;
  std::vector<SharedSamples> vertices_, edges_;
  std::vector<uint8_t> degenerate_;
  Mesh mesh_;
};

// The topology that is refined, and its cage.
struct Topology {
  std::optional<Cage> changed;  // else the given one
  std::unique_ptr<Far::TopologyRefiner> refiner;
  std::string messages;  // of OpenSubdiv, or about it
};

Topology make_topology(const Cage& cage) {
  Topology t;
  t.refiner = make_refiner(cage, &t.messages);
  // Bilinear surfaces have no patches.
  if (!t.refiner || cage.scheme == SubdivisionScheme::bilinear) return t;
  if (!any_has_two_face_vertex(t.refiner->GetLevel(0))) return t;
  std::string left_out;
  t.changed = cage_for_two_face_vertices(cage, t.refiner->GetLevel(0), &left_out);
  t.messages.clear();
  t.refiner = make_refiner(*t.changed, &t.messages);
  if (!left_out.empty()) t.messages += (t.messages.empty() ? "" : "; ") + left_out;
  if (!t.refiner || !is_sharp_at_two_face_vertex(t.refiner->GetLevel(0))) return t;
  t.refiner = nullptr;
  t.messages = "an edge of more than two faces ends at a face with a vertex that only one other face shares";
  return t;
}

}  // namespace

std::optional<Mesh> tessellate_limit_surface(const Cage& given, const RefinementOptions& options,
                                             const DiagnosticSink& sink) {
  const std::string& where = options.where;
  const auto [changed, refiner, messages] = make_topology(given);
  const Cage& cage = changed ? *changed : given;
  if (!refiner) {
    report(sink, Severity::error, "mesh.subdivision.topology", where,
           "OpenSubdiv refuses this topology (" + messages + "); drawn unrefined");
    return std::nullopt;
  }
  if (!messages.empty()) report(sink, Severity::warning, "mesh.subdivision.topology", where, "OpenSubdiv: " + messages);
  const EdgeRates rates =
      options.segments ? adaptive_rates(cage, *refiner, options) : EdgeRates{1u << options.level, {}};
  return LimitTessellator(cage, *refiner, rates, options.cancel).run();
}

}  // namespace alabaster
