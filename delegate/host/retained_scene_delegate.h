// Holds a scene as plain descriptions and compares what is pushed in: unchanged values mark nothing dirty. Serves the
// scene readers and hosts that have no scene delegate of their own.
#pragma once

#include <algorithm>
#include <iterator>
#include <memory>
#include <optional>
#include <variant>

#include "delegate/host/render_index.h"

namespace alabaster::hd::host {

struct PrimvarValue {
  Interpolation interpolation = Interpolation::vertex;
  Token role;
  Value value;             // an array of numbers or vectors of any type, or one for all
  Array<int32_t> indices;  // empty: not indexed
  bool operator==(const PrimvarValue&) const = default;
};

/// A mesh, or what is drawn as one: its type is its kind.
struct MeshDescription {
  MeshTopology topology;  // of a mesh
  SubdivTags subdivTags;
  DisplayStyle displayStyle;
  std::map<Token, PrimvarValue> primvars;  // "points" (Vec3f, vertex), "normals" (Vec3f), "st" (Vec2f, v up)
  Matrix4d transform;
  bool visible = true;
  bool doubleSided = true;
  CullStyle cullStyle = CullStyle::dontCare;
  Path material;                                            // empty: the default material
  Path instancer;                                           // empty: not instanced
  TimeSamples<Matrix4d> transformSamples = {};              // of what moves
  std::map<Token, TimeSamples<Value>> primvarSamples = {};  // of what deforms: "points", "normals"
  Token renderTag = "geometry";
  std::vector<Token> categories = {};  // for light linking
  Token type = "mesh";                 // of kRprimTypes
  BasisCurvesTopology curves = {};     // of basisCurves, with primvar "widths": diameters, 1 without them. Points, too
  bool operator==(const MeshDescription&) const = default;
};

struct InstancerDescription {
  Matrix4d transform;
  Path parent;                                  // outer instancer; empty: none
  std::map<Token, Value> primvars;              // by instance: hydra:instanceTransforms, ... and those that looks read
  std::map<Path, Array<int32_t>> indices;       // prototype (mesh or inner instancer) -> indices into the primvars
  TimeSamples<Matrix4d> transformSamples = {};  // of what moves
  std::map<Token, TimeSamples<Value>> primvarSamples = {};  // of points that move
  std::vector<std::vector<Token>> categories = {};          // by instance
  std::map<Token, Token> primvarRoles = {};                 // of primvars that have one
  bool operator==(const InstancerDescription&) const = default;
};

/// Parameters have the names of schemas/lights.json. Types: rectLight, diskLight, cylinderLight, sphereLight,
/// distantLight, domeLight.
struct LightDescription {
  Token type;
  Matrix4d transform;
  std::map<Token, Value> parameters;
  bool visible = true;                          // else it gives no light
  TimeSamples<Matrix4d> transformSamples = {};  // of what moves
  bool operator==(const LightDescription&) const = default;
};

using hd::CameraDescription;

/// A prim: its type is its kind, and its members are its fields (scene_fields.h). This is the one list of kinds; each
/// has its row in scene_fields.cpp. An index loses prims in this order, and gets them in the reverse order.
using PrimDescription = std::variant<MeshDescription, InstancerDescription, MaterialNetwork, LightDescription,
                                     CameraDescription, RenderSettingsDescription, RenderBufferDescriptor>;
using Prims = std::map<Path, PrimDescription>;

/// Null: there is no prim of that path, or it is of another kind.
template <class T>
const T* FindPrim(const Prims& prims, const Path& path) {
  const auto found = prims.find(path);
  return found == prims.end() ? nullptr : std::get_if<T>(&found->second);
}

/// The prims of one kind among all, which must outlive it. It reads as a map from paths to T.
template <class T>
class PrimsOf {
 public:
  using key_type = Path;
  using mapped_type = T;
  using value_type = std::pair<const Path&, const T&>;

  class Iterator {
   public:
    using iterator_category = std::input_iterator_tag;
    using value_type = PrimsOf::value_type;
    using difference_type = std::ptrdiff_t;
    using pointer = std::optional<value_type>;
    using reference = value_type;

    Iterator(Prims::const_iterator at, Prims::const_iterator end) : at_(at), end_(end) { skip_others(); }
    reference operator*() const { return {at_->first, std::get<T>(at_->second)}; }
    pointer operator->() const { return **this; }
    Iterator& operator++() {
      ++at_;
      skip_others();
      return *this;
    }
    bool operator==(const Iterator& o) const { return at_ == o.at_; }

   private:
    void skip_others() {
      while (at_ != end_ && !std::holds_alternative<T>(at_->second)) ++at_;
    }
    Prims::const_iterator at_, end_;
  };

  explicit PrimsOf(const Prims& prims) : prims_(&prims) {}
  Iterator begin() const { return {prims_->begin(), prims_->end()}; }
  Iterator end() const { return {prims_->end(), prims_->end()}; }
  Iterator find(const Path& path) const { return contains(path) ? Iterator(prims_->find(path), prims_->end()) : end(); }
  bool contains(const Path& path) const { return FindPrim<T>(*prims_, path) != nullptr; }
  const T& at(const Path& path) const { return std::get<T>(prims_->at(path)); }
  bool empty() const { return begin() == end(); }
  size_t size() const { return size_t(std::distance(begin(), end())); }
  bool operator==(const PrimsOf& o) const { return std::equal(begin(), end(), o.begin(), o.end()); }

 private:
  const Prims* prims_;
};

/// Memory that the host edits in place (Array::version) is told to be changed by setting the description again, with a
/// new version of the array.
///
/// One thread at a time pushes; pulls come from Sync. Before Populate it is plain data. Afterwards every Set marks the
/// differences in the index it populates. A Set replaces a prim of another kind that has its path.
class ALABASTER_API RetainedSceneDelegate : public SceneDelegate {
 public:
  RetainedSceneDelegate();
  ~RetainedSceneDelegate() override;

  void Set(const Path& id, PrimDescription prim);
  /// False: there is no prim of that path.
  bool Remove(const Path& id);
  const Prims& GetPrims() const;
  /// The name that an artist gave the prim, which need not be unique: the last part of its path, unless a reader has
  /// set another one. It goes with the prim. Empty: that of the path again.
  void SetName(const Path& id, std::string name);
  std::string GetName(const Path& id) const;
  const std::map<Path, std::string>& GetNames() const;  // that were set

  // The same for one kind.
  void SetMesh(const Path& id, MeshDescription mesh) { Set(id, std::move(mesh)); }
  void SetInstancer(const Path& id, InstancerDescription instancer) { Set(id, std::move(instancer)); }
  void SetMaterial(const Path& id, MaterialNetwork network) { Set(id, std::move(network)); }
  void SetLight(const Path& id, LightDescription light) { Set(id, std::move(light)); }
  void SetCamera(const Path& id, CameraDescription camera) { Set(id, std::move(camera)); }
  void SetRenderSettings(const Path& id, RenderSettingsDescription settings) { Set(id, std::move(settings)); }
  void SetRenderBuffer(const Path& id, RenderBufferDescriptor buffer) { Set(id, buffer); }
  auto GetMeshes() const { return PrimsOf<MeshDescription>(GetPrims()); }
  auto GetInstancers() const { return PrimsOf<InstancerDescription>(GetPrims()); }
  auto GetMaterials() const { return PrimsOf<MaterialNetwork>(GetPrims()); }
  auto GetLights() const { return PrimsOf<LightDescription>(GetPrims()); }
  auto GetCameras() const { return PrimsOf<CameraDescription>(GetPrims()); }
  auto GetAllRenderSettings() const { return PrimsOf<RenderSettingsDescription>(GetPrims()); }

  /// Replaces elements of an instancer's primvars, from `first` on; in their motion samples, too: these stand still.
  /// Costs a copy of each array, SetInstancer a comparison, too. False, and nothing is
  /// changed: there is no such primvar, or an array's elements have another number of components or end before them.
  bool SetInstanceValues(const Path& instancer, size_t first, const std::map<Token, Value>& elements);
  bool SetInstanceValues(const Path& instancer, const Token& primvar, size_t first, const Value& elements) {
    return SetInstanceValues(instancer, first, {{primvar, elements}});
  }

  /// Inserts everything into `index` and keeps it informed. The index must outlive this, or Depopulate comes first.
  /// A prim that others remove from the index is not made again.
  void Populate(RenderIndex* index);
  /// Makes the prims that the index lacks because memory ran out when they were to be made. False if it does again.
  bool PopulateRest();
  void Depopulate();

  // SceneDelegate
  MeshTopology GetMeshTopology(const Path& id) override;
  SubdivTags GetSubdivTags(const Path& id) override;
  BasisCurvesTopology GetBasisCurvesTopology(const Path& id) override;
  DisplayStyle GetDisplayStyle(const Path& id) override;
  Matrix4d GetTransform(const Path& id) override;
  bool GetVisible(const Path& id) override;
  bool GetDoubleSided(const Path& id) override;
  CullStyle GetCullStyle(const Path& id) override;
  Token GetRenderTag(const Path& id) override;
  std::vector<Token> GetCategories(const Path& id) override;
  Token GetDisplayName(const Path& id) override;
  Path GetMaterialId(const Path& id) override;
  std::vector<PrimvarDescriptor> GetPrimvarDescriptors(const Path& id) override;
  Value GetPrimvar(const Path& id, const Token& name, Array<int32_t>* indices) override;
  TimeSamples<Matrix4d> SampleTransform(const Path& id) override;
  TimeSamples<Value> SamplePrimvar(const Path& id, const Token& name) override;
  TimeSamples<Matrix4d> SampleInstancerTransform(const Path& instancerId) override;
  Path GetInstancerId(const Path& primId) override;
  Matrix4d GetInstancerTransform(const Path& instancerId) override;
  Array<int32_t> GetInstanceIndices(const Path& instancerId, const Path& prototypeId) override;
  std::vector<std::vector<Token>> GetInstanceCategories(const Path& instancerId) override;
  MaterialNetwork GetMaterialResource(const Path& id) override;
  Value GetLightParamValue(const Path& id, const Token& name) override;
  Value GetCameraParamValue(const Path& id, const Token& name) override;
  RenderBufferDescriptor GetRenderBufferDescriptor(const Path& id) override;
  RenderSettingsDescription GetRenderSettings(const Path& id) override;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace alabaster::hd::host
