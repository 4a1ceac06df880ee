// The pull side of the contract: the questions that a scene must answer. A prim pulls what its dirty bits name and
// nothing else.
#pragma once

#include "delegate/api/scene_types.h"

namespace alabaster::hd {

/// Called from several threads at once for different ids during Rprim and Material Sync; from one thread otherwise.
/// Must not throw. Unknown ids answer with defaults.
class ALABASTER_API SceneDelegate {
 public:
  virtual ~SceneDelegate();

  // Rprims
  virtual MeshTopology GetMeshTopology(const Path& id) = 0;
  virtual SubdivTags GetSubdivTags(const Path& id) = 0;
  virtual BasisCurvesTopology GetBasisCurvesTopology(const Path& id);  // by default no curve
  virtual DisplayStyle GetDisplayStyle(const Path& id) = 0;
  virtual Matrix4d GetTransform(const Path& id) = 0;
  virtual bool GetVisible(const Path& id) = 0;
  /// False: back faces are culled for all rays, unless their material lets light below the surface. A material whose
  /// `sides` is front or both overrides this for its faces.
  virtual bool GetDoubleSided(const Path& id) = 0;
  virtual CullStyle GetCullStyle(const Path& id);  // dontCare, if a host has none
  /// geometry (USD's purpose default), render, proxy, guide or hidden; a pass draws the tags that it lists.
  virtual Token GetRenderTag(const Path& id) = 0;
  /// Names that light parameters `lightLink` and `shadowLink` may give. By default none.
  virtual std::vector<Token> GetCategories(const Path& id);
  virtual Path GetMaterialId(const Path& id) = 0;
  virtual std::vector<PrimvarDescriptor> GetPrimvarDescriptors(const Path& id) = 0;
  /// A primvar ("points", "st", "normals", ...), unflattened: with `indices` when its descriptor says indexed.
  virtual Value GetPrimvar(const Path& id, const Token& name, Array<int32_t>* indices) = 0;

  /// The name under which people know a mesh or a material, where its file has such names; it need not be unique. By
  /// default empty: its path. Asked when the prim is new.
  virtual Token GetDisplayName(const Path& id);

  // Motion: asked together with the values themselves, which are those of time 0. The defaults say that nothing moves.
  /// For meshes and cameras.
  virtual TimeSamples<Matrix4d> SampleTransform(const Path& id);
  /// "points" and "normals" of a mesh, "hydra:instanceTransforms" and the like of an instancer: as many at each time as
  /// at time 0.
  virtual TimeSamples<Value> SamplePrimvar(const Path& id, const Token& name);
  virtual TimeSamples<Matrix4d> SampleInstancerTransform(const Path& instancerId);

  // Instancing
  virtual Path GetInstancerId(const Path& primId) = 0;  // of an rprim or of an instancer (nesting); empty: none
  virtual Matrix4d GetInstancerTransform(const Path& instancerId) = 0;
  virtual Array<int32_t> GetInstanceIndices(const Path& instancerId, const Path& prototypeId) = 0;
  /// Categories of each instance of an instancer, besides those of the prototypes. Instances beyond its end have none.
  virtual std::vector<std::vector<Token>> GetInstanceCategories(const Path& instancerId);

  // Sprims, Bprims
  virtual MaterialNetwork GetMaterialResource(const Path& id) = 0;
  virtual Value GetLightParamValue(const Path& id, const Token& name) = 0;
  virtual Value GetCameraParamValue(const Path& id, const Token& name) = 0;
  virtual RenderBufferDescriptor GetRenderBufferDescriptor(const Path& id) = 0;
  virtual RenderSettingsDescription GetRenderSettings(const Path& id) = 0;
};

}  // namespace alabaster::hd
