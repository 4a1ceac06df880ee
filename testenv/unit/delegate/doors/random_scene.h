// A scene with a prim of every kind whose fields have random values: those of the tables of fields, and those whose
// names a scene gives.
#pragma once

#include <random>

#include "delegate/host/scene_fields.h"
#include "testenv/support/cages.h"

namespace alabaster::hd::doors {

using host::FieldRow;
using host::Fields;

/// The paths of the prims that change. Camera and lights show a cube at the origin.
inline const std::vector<Path> kPaths{"/beads", "/body", "/camera",   "/hair", "/key",
                                      "/lid",   "/many", "/settings", "/sky",  "/wax"};

class RandomScene {
 public:
  explicit RandomScene(unsigned seed) : random_(seed) {}

  bool chance(double share) { return std::uniform_real_distribution<>(0, 1)(random_) < share; }
  float number(float low, float high) { return std::uniform_real_distribution<float>(low, high)(random_); }
  template <class T>
  T pick(const std::vector<T>& all) {
    return all[std::uniform_int_distribution<size_t>(0, all.size() - 1)(random_)];
  }
  template <class T>
  void shuffle(T* all) {
    std::shuffle(all->begin(), all->end(), random_);
  }

  Token kind_of(const Path& path) {
    if (path == Path("/key"))
      return pick<Token>({"rectLight", "sphereLight", "diskLight", "cylinderLight", "distantLight"});
    if (path == Path("/sky")) return "domeLight";
    if (path == Path("/settings")) return "renderSettings";
    if (path == Path("/camera")) return "camera";
    if (path == Path("/hair")) return "basisCurves";
    if (path == Path("/beads")) return "points";
    return path == Path("/many") ? "instancer" : path == Path("/wax") ? "material" : "mesh";
  }
  /// What a prim of the scene has at least.
  static Fields base_of(const Path& path) {
    if (path == Path("/wax")) return {{"surface.type", Token("AlabasterDisney")}};
    if (path == Path("/many"))
      return {{"primvars:hydra:instanceTranslations", Array<Vec3f>{{-1, 0, 0}, {1, 0, 0}}},
              {"prototypes:/lid", Array<int32_t>{0, 1}}};
    if (path == Path("/camera"))
      return {{"transform", Matrix4d().setTranslation(Vec3d(0, 0, 6))},
              {"focalLength", 1.0f},
              {"horizontalAperture", 1.0f},
              {"verticalAperture", 1.0f}};
    if (path == Path("/key")) return {{"transform", Matrix4d().setTranslation(Vec3d(0, 0, 3))}};
    if (path == Path("/settings")) return {{"camera", Path("/camera")}, {"width", 16}, {"height", 16}};
    if (path == Path("/sky")) return {};
    const Array<Vec3f> row{{-1, 0, 1}, {-0.5f, 0.5f, 1}, {0.5f, -0.5f, 1}, {1, 0, 1}};
    if (path == Path("/beads")) return {{"primvars:points", row}, {"primvars:widths", Array<float>{0.5f}}};
    if (path == Path("/hair")) return {{"primvars:points", row}, {"curveVertexCounts", Array<int32_t>{4}}};
    const Cage cage = test::cube_cage();
    return {{"faceVertexCounts", Array<int32_t>(cage.face_vertex_counts)},
            {"faceVertexIndices", Array<int32_t>(cage.face_vertex_indices)},
            {"primvars:points", Array<Vec3f>(cage.points)}};
  }
  /// Every other field of the prim, with a value.
  Fields fields_of(const Path& path) {
    const Value near = Array<Token>{"near"}, one = Array<int32_t>{pick<int32_t>({0, 1})};
    const Value moving = std::make_shared<const TimeSamples<Value>>(TimeSamples<Value>{{0, 1}, {place(), place()}});
    Fields all;
    if (path == Path("/wax")) {
      add_rows(host::ParameterRows("disney_material"), "surface.", &all);
    } else if (path == Path("/many")) {
      all = {{"transform", place()},
             {"transform:samples", moving},
             {"categories:near", one},
             {"prototypes:/body", one},
             {"primvars:hydra:instanceScales", Array<Vec3f>{vector(0.5f, 1), vector(0.5f, 1)}}};
    } else if (path == Path("/key") || path == Path("/sky")) {
      all = {{"transform", place()},
             {"visible", chance(0.8)},
             {"lightLink", Token("near")},
             {"shadowLink", Token("near")}};
      add_rows(host::ParameterRows("lights"), "", &all);
    } else if (path == Path("/camera")) {
      all = {{"transform:samples", moving}, {"clipPlanes", Array<Vec4f>{{1, 0, 0, number(0, 2)}}}};
      add_rows(host::ParameterRows("camera"), "", &all);
      const TimeSamples<Value> lens{{-1, 1}, {number(0.5f, 2), number(0.5f, 2)}};
      for (const char* name : {"focalLength:samples", "fStop:samples", "focusDistance:samples"})
        all.emplace_back(name, std::make_shared<const TimeSamples<Value>>(lens));
    } else if (path == Path("/settings")) {
      add_rows(host::FieldRows("renderSettings"), "", &all);
      add_rows(host::ParameterRows("render_settings"), "", &all);
      all.insert(all.end(), {{"crop", Array<int32_t>{0, 0, pick<int32_t>({4, 8}), 8}},
                             {"includedPurposes", Array<Token>{"proxy"}}});
    } else {
      const bool has_faces = path == Path("/body") || path == Path("/lid");
      add_rows(host::FieldRows(kind_of(path).str()), "", &all);
      add_rows(host::ParameterRows("mesh"), "", &all);
      if (has_faces)
        all.insert(all.end(),
                   {{"holeIndices", one},
                    {"invisibleFaces", one},
                    {"creaseIndices", Array<int32_t>{0, 1, 2}},
                    {"creaseLengths", Array<int32_t>{3}},
                    {"creaseWeights", Array<float>{number(0, 4)}},
                    {"cornerIndices", one},
                    {"cornerWeights", Array<float>{number(0, 4)}},
                    {"subsets:part:faces", Array<int32_t>{pick<int32_t>({0, 1, 2}), pick<int32_t>({3, 4, 5})}},
                    {"subsets:part:material", Path("/wax")}});
      else
        all.insert(all.end(), {{"primvars:widths", Array<float>{number(0.1f, 1)}}});
      all.insert(all.end(), {{"transform", place()},
                             {"transform:samples", moving},
                             {"material", Path("/wax")},
                             {"instancer", Path("/many")},
                             {"renderTag", pick<Token>({"render", "proxy"})},
                             {"categories", near},
                             {"subsurfaceSet", Token("set")},
                             {"primvars:displayColor", Value(vector(0, 1))},
                             {"primvars:displayColor:interpolation", Token("constant")},
                             {"primvars:displayColor:role", Token("color")}});
    }
    return all;
  }
  /// A few of them, in any order; some go back to their defaults.
  Fields some_fields(const Path& path) {
    Fields all = fields_of(path);
    shuffle(&all);
    all.resize(std::min(all.size(), pick<size_t>({1, 2, 3})));
    for (auto& [name, value] : all)
      if (chance(0.2)) value = {};
    // Samples are set after what they belong to, as is a primvar's role.
    std::stable_sort(all.begin(), all.end(),
                     [](const auto& a, const auto& b) { return a.first.size() < b.first.size(); });
    return all;
  }

  /// A value of the row, near its default, so that there is something to see. Empty: the scene has a value of its own.
  Value value_of(const FieldRow& row) {
    for (const char* cost : {"timeLimit", "targetError", "memoryLimit", "denoise"})
      if (row.name == cost) return {};  // pictures depend on the machine then
    if (!row.words.empty()) return Token(pick(row.words));
    const TypeInfo& info = GetTypeInfo(row.type.type);
    if (row.type.type == ALABASTER_BOOL) return chance(0.5);
    if (row.type.is_array || info.bytes == 0 || (info.components > 1 && !row.is_color)) return {};
    if (row.name == "shutterOpen") return -number(0, 1);  // before it closes
    if (row.name == "refineLevel") return pick<int32_t>({0, 1, 2});
    const double fallback = row.fallback.number_or(0);
    const auto drawn = [&] {
      const double value = fallback > 0 ? fallback * double(number(0.5f, 1.5f)) : double(number(0, 1));
      return std::clamp(value, row.low, row.high);
    };
    if (row.is_color) return Vec3f(float(drawn()), float(drawn()), float(drawn()));
    const bool is_whole = info.scalar == Scalar::int32 || info.scalar == Scalar::int64 || info.scalar == Scalar::uint32;
    return is_whole ? Value(int32_t(drawn())) : Value(float(drawn()));
  }

 private:
  Vec3f vector(float low, float high) { return {number(low, high), number(low, high), number(low, high)}; }
  Matrix4d place() { return Matrix4d().setTranslation(Vec3d(vector(-1, 1))); }
  void add_rows(const std::vector<FieldRow>& rows, const std::string& prefix, Fields* fields) {
    for (const FieldRow& row : rows)
      if (Value value = value_of(row); !value.empty()) fields->emplace_back(prefix + row.name, std::move(value));
  }

  std::mt19937 random_;
};

}  // namespace alabaster::hd::doors
