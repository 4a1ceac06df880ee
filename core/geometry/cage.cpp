#include "core/geometry/cage.h"

#include <algorithm>
#include <cstdint>
#include <map>
#include <set>

#include "core/geometry/index.h"

namespace alabaster {
namespace {

constexpr int kMaxRefinedSize = 1000;    // OpenSubdiv fails or hangs on far larger faces and valences
constexpr int kMaxFaceSize = 16384;      // cutting ears takes quadratic time
constexpr float kMaxCoordinate = 1e17f;  // as is_traceable: no ray can be traced from beyond
constexpr float kMaxSharpness = 10;      // OpenSubdiv's infinity

bool in_range(int i, size_t size) {
  return i >= 0 && at(i) < size;
}

bool is_usable(const Vec3f& p) {
  return is_finite(p) && max_abs_component(p) <= kMaxCoordinate;
}

// Collects faults and reports each kind once.
class Faults {
 public:
  void add(const std::string& code, int element) {
    auto [it, first] = counts_.try_emplace(code, Count{0, element});
    ++it->second.number;
  }
  /// `what` completes "N faces ...", `element` names the thing counted.
  void flush(const std::string& code, const std::string& what, const std::string& element) {
    const auto it = counts_.find(code);
    if (it == counts_.end()) return;
    report(sink_, Severity::warning, code, where_,
           std::to_string(it->second.number) + " " + what + " (first: " + element + " " +
               std::to_string(it->second.first) + ")");
    counts_.erase(it);
  }
  size_t kinds() const { return counts_.size(); }  // not flushed yet
  void note(const std::string& code, const std::string& text, Severity severity = Severity::warning) {
    report(sink_, severity, code, where_, text);
  }

  Faults(const std::string& where, const DiagnosticSink& sink) : where_(where), sink_(sink) {}

 private:
  struct Count {
    size_t number = 0;
    int first = 0;
  };
  const std::string& where_;
  const DiagnosticSink& sink_;
  std::map<std::string, Count> counts_;
};

class Sanitizer {
 public:
  Sanitizer(Cage& cage, const std::string& where, const DiagnosticSink& sink) : cage_(cage), faults_(where, sink) {}

  bool run() {
    check_points();
    check_primvar(&cage_.normals, "normals");
    check_primvar(&cage_.tangents, "tangents");
    for (UvPrimvar& uv : cage_.uvs) check_primvar<Vec2f>(&uv, "uv");
    std::erase_if(cage_.uvs, [](const UvPrimvar& uv) { return uv.empty(); });
    std::erase_if(cage_.primvars, [&](NamedPrimvar& named) {
      const auto is_gone = [&](auto& primvar) {
        check_primvar(&primvar, "primvar", "primvar " + named.name);
        return primvar.empty();
      };
      return std::visit(is_gone, named.values);
    });
    check_materials();
    check_faces();
    drop_faces();
    keep_faces(&cage_.hole_indices, "mesh.holes.index", "holes");
    keep_faces(&cage_.invisible_faces, "mesh.invisible.index", "invisible faces");
    check_scheme();
    check_creases();
    check_corners();
    std::set<int> hidden(cage_.hole_indices.begin(), cage_.hole_indices.end());
    hidden.insert(cage_.invisible_faces.begin(), cage_.invisible_faces.end());
    if (cage_.face_vertex_counts.size() > hidden.size()) return true;
    // A mesh without faces, or of those that have no area or are hidden, is meant so.
    if (damaged_ && faces() == 0)
      faults_.note("mesh.empty", "no face is left to draw: the mesh is left out; correct its points and faces",
                   Severity::error);
    else
      faults_.note("mesh.empty", "no face is left to draw");
    return false;
  }

 private:
  size_t faces() const { return cage_.face_vertex_counts.size(); }

  void check_points() {
    unusable_.assign(cage_.points.size(), false);
    for (size_t i = 0; i < cage_.points.size(); ++i) {
      if (is_usable(cage_.points[i])) continue;
      unusable_[i] = true;
      cage_.points[i] = Vec3f(0, 0, 0);
      faults_.add("mesh.points.nonfinite", static_cast<int>(i));
    }
    faults_.flush("mesh.points.nonfinite", "points are not finite or beyond 1e17; the faces that use them are dropped",
                  "point");
  }

  // Before faces are dropped: sizes are counted against the cage as it was given.
  template <class T>
  void check_primvar(Primvar<T>* primvar, const std::string& name) {
    check_primvar(primvar, name, name);
  }
  template <class T>
  void check_primvar(Primvar<T>* primvar, const std::string& kind, const std::string& name) {
    if (primvar->values.empty() && primvar->indices.empty()) return;
    const auto [wanted, what] = wanted_values(primvar->interpolation);
    const size_t given = primvar->indices.empty() ? primvar->values.size() : primvar->indices.size();
    const bool indices_fit = std::all_of(primvar->indices.begin(), primvar->indices.end(),
                                         [&](int i) { return in_range(i, primvar->values.size()); });
    if (given != wanted || !indices_fit) {
      faults_.note("mesh." + kind + (given != wanted ? ".size" : ".index"),
                   given != wanted ? name + " has " + std::to_string(given) + " values, " + std::to_string(wanted) +
                                         " are needed (" + what + "); ignored"
                                   : name + " has indices outside its " + std::to_string(primvar->values.size()) +
                                         " values; ignored");
      *primvar = {};
      return;
    }
    const std::string code = "mesh." + kind + ".nonfinite";
    for (size_t i = 0; i < primvar->values.size(); ++i)
      if (!is_usable_value(primvar->values[i])) {
        primvar->values[i] = T(0);
        faults_.add(code, static_cast<int>(i));
      }
    faults_.flush(code, "values of " + name + " are not finite; zero is used", "value");
    if (primvar->interpolation == Interpolation::constant) spread_over_points(primvar);
    if (primvar->interpolation == Interpolation::uniform) spread_over_corners(primvar);
  }

  std::pair<size_t, const char*> wanted_values(Interpolation interpolation) const {
    switch (interpolation) {
      case Interpolation::constant:
        return {1, "one for the mesh"};
      case Interpolation::uniform:
        return {faces(), "one per face"};
      case Interpolation::varying:
      case Interpolation::vertex:
        return {cage_.points.size(), "one per point"};
      case Interpolation::face_varying:
        break;
    }
    return {cage_.face_vertex_indices.size(), "one per face corner"};
  }
  template <class T>
  void spread_over_points(Primvar<T>* primvar) const {
    primvar->interpolation = Interpolation::vertex;
    primvar->indices.assign(cage_.points.size(), primvar->indices.empty() ? 0 : primvar->indices[0]);
  }
  // Counts that do not fit the corners are found later; corners beyond them belong to no face.
  template <class T>
  void spread_over_corners(Primvar<T>* primvar) const {
    std::vector<int> corners(cage_.face_vertex_indices.size(), 0);
    size_t first = 0;
    for (size_t face = 0; face < faces(); ++face) {
      const size_t count = std::min(at(std::max(cage_.face_vertex_counts[face], 0)), corners.size() - first);
      std::fill_n(corners.begin() + static_cast<std::ptrdiff_t>(first), count,
                  primvar->indices.empty() ? static_cast<int>(face) : primvar->indices[face]);
      first += count;
    }
    primvar->interpolation = Interpolation::face_varying;
    primvar->indices = std::move(corners);
  }

  static bool is_usable_value(const Vec3f& v) { return is_usable(v); }
  static bool is_usable_value(const Vec2f& v) { return is_usable(Vec3f(v.x, v.y, 0)); }
  static bool is_usable_value(const Vec4f& v) { return is_usable(Vec3f(v.x, v.y, v.z)) && std::isfinite(v.w); }
  static bool is_usable_value(float x) { return std::isfinite(x); }

  void check_materials() {
    if (cage_.face_material.empty()) return;
    if (cage_.face_material.size() != faces()) {
      faults_.note("mesh.material.size", "face_material has " + std::to_string(cage_.face_material.size()) +
                                             " entries for " + std::to_string(faces()) +
                                             " faces; missing ones use slot 0");
      cage_.face_material.resize(faces(), 0);
    }
    for (size_t i = 0; i < cage_.face_material.size(); ++i)
      if (cage_.face_material[i] < 0) {
        cage_.face_material[i] = 0;
        faults_.add("mesh.material.slot", static_cast<int>(i));
      }
    faults_.flush("mesh.material.slot", "faces have a negative material slot; slot 0 is used", "face");
  }

  bool check_corners_of_face(int face, size_t first, size_t count) {
    for (size_t k = first; k < first + count; ++k) {
      const int point = cage_.face_vertex_indices[k];
      if (!in_range(point, cage_.points.size())) {
        faults_.add("mesh.faces.index", face);
        return false;
      }
      if (unusable_[at(point)]) return false;  // reported with the points
    }
    return true;
  }

  bool check_face(int face, size_t first) {
    const int count = cage_.face_vertex_counts[at(face)];
    const bool is_small = count >= 0 && count < 3;
    const bool is_whole = check_whole_face(face, first, count);
    damaged_ |= !is_whole && !is_small;
    return is_whole;
  }

  bool check_whole_face(int face, size_t first, int count) {
    if (count < 3 || count > kMaxFaceSize) {
      faults_.add(count < 3 ? "mesh.faces.small" : "mesh.faces.large", face);
      return false;
    }
    if (first + at(count) > cage_.face_vertex_indices.size()) {
      faults_.add("mesh.faces.short", face);
      return false;
    }
    return check_corners_of_face(face, first, at(count));
  }

  void check_faces() {
    keep_.assign(faces(), false);
    size_t first = 0;
    for (size_t face = 0; face < faces(); ++face) {
      keep_[face] = check_face(static_cast<int>(face), first);
      // A sum that ran over the end cannot overflow: it stops growing there.
      first = std::min(first + at(std::max(cage_.face_vertex_counts[face], 0)), cage_.face_vertex_indices.size() + 1);
    }
    if (first < cage_.face_vertex_indices.size())
      faults_.note("mesh.faces.long", std::to_string(cage_.face_vertex_indices.size() - first) +
                                          " face vertex indices belong to no face (counts are too small); ignored");
    faults_.flush("mesh.faces.small", "faces have less than 3 corners; dropped", "face");
    faults_.flush("mesh.faces.large", "faces have more than " + std::to_string(kMaxFaceSize) + " corners; dropped",
                  "face");
    faults_.flush("mesh.faces.short", "faces lie beyond the end of the face vertex indices; dropped", "face");
    faults_.flush("mesh.faces.index", "faces use points that do not exist; dropped", "face");
  }

  // Values by corner or by face follow the faces that stay.
  void drop_faces() {
    std::vector<int> counts, indices, corners, materials, kept;
    new_face_.assign(faces(), -1);
    size_t first = 0;
    for (size_t face = 0; face < faces(); ++face) {
      const size_t count = at(std::max(cage_.face_vertex_counts[face], 0));
      if (keep_[face] && corners_to_keep(static_cast<int>(face), first, count, &kept)) {
        new_face_[face] = static_cast<int>(counts.size());
        counts.push_back(static_cast<int>(kept.size()));
        for (const int k : kept) indices.push_back(cage_.face_vertex_indices[at(k)]);
        corners.insert(corners.end(), kept.begin(), kept.end());
        if (!cage_.face_material.empty()) materials.push_back(cage_.face_material[face]);
      }
      first = std::min(first + count, cage_.face_vertex_indices.size() + 1);
    }
    faults_.flush("mesh.faces.degenerate",
                  "faces have a point twice in a row; it counts once, and faces of two points are dropped", "face");
    if (corners.size() != cage_.face_vertex_indices.size()) {
      keep_corners(&cage_.normals, corners);
      keep_corners(&cage_.tangents, corners);
      for_each_refined(cage_, [&]<class T>(T& primvar) { keep_corners(&primvar, corners); });
    }
    cage_.face_vertex_counts = std::move(counts);
    cage_.face_vertex_indices = std::move(indices);
    cage_.face_material = std::move(materials);
  }

  // A point that comes twice in a row would make an edge of three faces, or one to itself: a crease of the surface.
  // False: less than three corners are left.
  bool corners_to_keep(int face, size_t first, size_t count, std::vector<int>* kept) {
    kept->clear();
    const auto point = [&](size_t k) { return cage_.face_vertex_indices[first + k % count]; };
    for (size_t k = 0; k < count; ++k)
      if (cage_.scheme == SubdivisionScheme::none || point(k) != point(k + 1))
        kept->push_back(static_cast<int>(first + k));
    if (kept->size() < count) faults_.add("mesh.faces.degenerate", face);
    return kept->size() >= 3;
  }

  template <class T>
  static void keep_corners(Primvar<T>* primvar, const std::vector<int>& corners) {
    if (primvar->empty() || primvar->interpolation != Interpolation::face_varying) return;
    Primvar<T> kept;
    kept.interpolation = primvar->interpolation;
    for (int k : corners) {
      if (primvar->indices.empty())
        kept.values.push_back(primvar->values[at(k)]);
      else
        kept.indices.push_back(primvar->indices[at(k)]);
    }
    if (!primvar->indices.empty()) kept.values = std::move(primvar->values);
    *primvar = std::move(kept);
  }

  // Those that exist, by their new numbers, each once.
  void keep_faces(std::vector<int>* named, const char* code, const std::string& what) {
    std::set<int> kept;
    for (int face : *named) {
      if (!in_range(face, new_face_.size()))
        faults_.add(code, face);
      else if (new_face_[at(face)] >= 0)
        kept.insert(new_face_[at(face)]);
    }
    faults_.flush(code, what + " name faces that do not exist; ignored", "index");
    named->assign(kept.begin(), kept.end());
  }

  void check_scheme() {
    if (cage_.scheme == SubdivisionScheme::none) return;
    const auto triangle = [](int count) { return count == 3; };
    if (cage_.scheme == SubdivisionScheme::loop &&
        !std::all_of(cage_.face_vertex_counts.begin(), cage_.face_vertex_counts.end(), triangle)) {
      cage_.scheme = SubdivisionScheme::catmull_clark;
      faults_.note("mesh.scheme.loop", "loop subdivision needs triangles only; catmull_clark is used");
    }
    std::vector<int> valences(cage_.points.size(), 0);
    for (int point : cage_.face_vertex_indices) ++valences[at(point)];
    for (size_t face = 0; face < faces(); ++face)
      if (cage_.face_vertex_counts[face] > kMaxRefinedSize) faults_.add("mesh.faces.size", static_cast<int>(face));
    for (size_t i = 0; i < valences.size(); ++i)
      if (valences[i] > kMaxRefinedSize) faults_.add("mesh.points.valence", static_cast<int>(i));
    const size_t before = faults_.kinds();
    const std::string remedy = "; the mesh is not subdivided (split them to have it refined)";
    faults_.flush("mesh.faces.size", "faces have more than 1000 corners" + remedy, "face");
    faults_.flush("mesh.points.valence", "points are shared by more than 1000 faces" + remedy, "point");
    if (faults_.kinds() < before) cage_.scheme = SubdivisionScheme::none;
  }

  std::set<std::pair<int, int>> edges() const {
    std::set<std::pair<int, int>> edges;
    size_t first = 0;
    for (int count : cage_.face_vertex_counts) {
      for (size_t i = 0; i < at(count); ++i)
        edges.insert(std::minmax(
            {cage_.face_vertex_indices[first + i], cage_.face_vertex_indices[first + (i + 1) % at(count)]}));
      first += at(count);
    }
    return edges;
  }

  static bool is_sharpness(float s) { return std::isfinite(s) && s >= 0; }

  bool crease_sizes_fit(size_t* pairs) const {
    size_t points = 0;
    *pairs = 0;
    for (int length : cage_.crease_lengths) {
      if (length < 2) return false;
      points += at(length);
      *pairs += at(length) - 1;
    }
    const size_t sharpnesses = cage_.crease_sharpnesses.size();
    return points == cage_.crease_indices.size() &&
           (sharpnesses == cage_.crease_lengths.size() || sharpnesses == *pairs);
  }

  // Leaves creases as single edges, each with its sharpness: one that is wrong does not take its neighbours along.
  void check_creases() {
    if (cage_.crease_lengths.empty() && cage_.crease_indices.empty()) return;
    std::vector<int> indices;
    std::vector<float> sharpnesses;
    size_t pairs = 0;
    if (crease_sizes_fit(&pairs)) {
      collect_creases(&indices, &sharpnesses);
    } else {
      faults_.note("mesh.creases.size",
                   "crease indices, lengths (at least 2 each) and sharpnesses (one per crease or per edge) do not fit "
                   "each other; creases are ignored");
    }
    cage_.crease_indices = std::move(indices);
    cage_.crease_lengths.assign(sharpnesses.size(), 2);
    cage_.crease_sharpnesses = std::move(sharpnesses);
  }

  void collect_creases(std::vector<int>* indices, std::vector<float>* sharpnesses) {
    const std::set<std::pair<int, int>> existing = edges();
    const bool per_crease = cage_.crease_sharpnesses.size() == cage_.crease_lengths.size();
    size_t first = 0, edge = 0;
    for (size_t crease = 0; crease < cage_.crease_lengths.size(); ++crease) {
      const size_t end = first + at(cage_.crease_lengths[crease]);
      for (; first + 1 < end; ++first, ++edge) {
        const int a = cage_.crease_indices[first], b = cage_.crease_indices[first + 1];
        const float sharpness = cage_.crease_sharpnesses[per_crease ? crease : edge];
        if (!existing.contains(std::minmax({a, b}))) {
          faults_.add("mesh.creases.edge", static_cast<int>(crease));
        } else if (!is_sharpness(sharpness)) {
          faults_.add("mesh.creases.sharpness", static_cast<int>(crease));
        } else {
          indices->insert(indices->end(), {a, b});
          sharpnesses->push_back(std::min(sharpness, kMaxSharpness));
        }
      }
      ++first;
    }
    faults_.flush("mesh.creases.edge", "crease segments are no edge of the mesh; ignored", "crease");
    faults_.flush("mesh.creases.sharpness", "crease segments have a negative or non-finite sharpness; ignored",
                  "crease");
  }

  void check_corners() {
    const size_t count = std::min(cage_.corner_indices.size(), cage_.corner_sharpnesses.size());
    if (cage_.corner_indices.size() != cage_.corner_sharpnesses.size())
      faults_.note("mesh.corners.size", "corners and their sharpnesses differ in number; the rest is ignored");
    std::vector<int> indices;
    std::vector<float> sharpnesses;
    for (size_t i = 0; i < count; ++i) {
      if (!in_range(cage_.corner_indices[i], cage_.points.size())) {
        faults_.add("mesh.corners.index", static_cast<int>(i));
      } else if (!is_sharpness(cage_.corner_sharpnesses[i])) {
        faults_.add("mesh.corners.sharpness", static_cast<int>(i));
      } else {
        indices.push_back(cage_.corner_indices[i]);
        sharpnesses.push_back(std::min(cage_.corner_sharpnesses[i], kMaxSharpness));
      }
    }
    faults_.flush("mesh.corners.index", "corners name points that do not exist; ignored", "corner");
    faults_.flush("mesh.corners.sharpness", "corners have a negative or non-finite sharpness; ignored", "corner");
    cage_.corner_indices = std::move(indices);
    cage_.corner_sharpnesses = std::move(sharpnesses);
  }

  Cage& cage_;
  Faults faults_;
  std::vector<bool> unusable_, keep_;
  bool damaged_ = false;  // a face that would have an area was dropped
  std::vector<int> new_face_;
};

}  // namespace

bool sanitize_cage(Cage& cage, const std::string& where, const DiagnosticSink& sink) {
  return Sanitizer(cage, where, sink).run();
}

}  // namespace alabaster
