#include "delegate/hydra/plugin/hydra_scene.h"

#include <pxr/imaging/hd/extComputationUtils.h>
#include <pxr/imaging/hd/material.h>

#include <algorithm>

#include "delegate/hydra/plugin/convert.h"

namespace alabaster::hydra {
namespace {

// Both have these in OpenUSD's order.
static_assert(int(pxr::HdInterpolationFaceVarying) == int(hd::Interpolation::faceVarying) &&
              int(pxr::HdInterpolationInstance) == int(hd::Interpolation::instance));
static_assert(int(pxr::HdCullStyleBack) == int(hd::CullStyle::back) &&
              int(pxr::HdCullStyleFrontUnlessDoubleSided) == int(hd::CullStyle::frontUnlessDoubleSided));

template <class Theirs>
hd::PrimvarDescriptor to_descriptor(const Theirs& primvar, bool indexed) {
  return {ToToken(primvar.name), static_cast<hd::Interpolation>(primvar.interpolation), ToToken(primvar.role), indexed};
}

constexpr unsigned kSamples = 16;  // without a second allocation

template <class Theirs, class Convert>
auto to_samples(const pxr::HdTimeSampleArray<Theirs, kSamples>& samples, const Convert& convert) {
  hd::TimeSamples<decltype(convert(samples.values[0]))> ours;
  if (samples.count < 2) return ours;
  for (unsigned i = 0; i < samples.count; ++i) {
    ours.times.push_back(double(samples.times[i]));
    ours.values.push_back(convert(samples.values[i]));
  }
  return ours;
}

hd::MaterialNode to_node(const pxr::HdMaterialNode2& node) {
  hd::MaterialNode ours;
  ours.nodeTypeId = ToToken(node.nodeTypeId);
  for (const auto& [name, value] : node.parameters) ours.parameters[ToToken(name)] = ToValue(value);
  for (const auto& [name, connections] : node.inputConnections)
    for (const auto& connection : connections)
      ours.inputConnections[ToToken(name)].push_back(
          {ToPath(connection.upstreamNode), ToToken(connection.upstreamOutputName)});
  return ours;
}

}  // namespace

// A path that is not the prim's own is an instancer's.
pxr::SdfPath HydraScene::path(const hd::Path& id) const {
  return id.str() == id_.GetString() ? id_ : pxr::SdfPath(id.str());
}

const pxr::HdExtComputationPrimvarDescriptorVector& HydraScene::computed() {
  if (computed_) return *computed_;
  computed_.emplace();
  for (int i = 0; i < pxr::HdInterpolationCount; ++i) {
    const auto found = host_->GetExtComputationPrimvarDescriptors(id_, static_cast<pxr::HdInterpolation>(i));
    computed_->insert(computed_->end(), found.begin(), found.end());
  }
  return *computed_;
}

const pxr::HdExtComputationPrimvarDescriptor* HydraScene::computed(const hd::Path& id, const hd::Token& name) {
  if (id.str() != id_.GetString()) return nullptr;
  for (const auto& one : computed())
    if (one.name.GetString() == name.str()) return &one;
  return nullptr;
}

hd::MeshTopology HydraScene::GetMeshTopology(const hd::Path& id) {
  const pxr::HdMeshTopology theirs = host_->GetMeshTopology(path(id));
  hd::MeshTopology ours;
  ours.scheme = ToToken(theirs.GetScheme());
  ours.orientation = ToToken(theirs.GetOrientation());
  ours.faceVertexCounts = ToArray<int32_t>(theirs.GetFaceVertexCounts());
  ours.faceVertexIndices = ToArray<int32_t>(theirs.GetFaceVertexIndices());
  ours.holeIndices = ToArray<int32_t>(theirs.GetHoleIndices());
  ours.invisibleFaces = ToArray<int32_t>(theirs.GetInvisibleFaces());
  ours.invisiblePoints = ToArray<int32_t>(theirs.GetInvisiblePoints());
  for (const pxr::HdGeomSubset& subset : theirs.GetGeomSubsets())
    if (subset.type == pxr::HdGeomSubset::TypeFaceSet)
      ours.geomSubsets.push_back({ToPath(subset.id), ToPath(subset.materialId), ToArray<int32_t>(subset.indices)});
  return ours;
}

hd::SubdivTags HydraScene::GetSubdivTags(const hd::Path& id) {
  const pxr::PxOsdSubdivTags theirs = host_->GetSubdivTags(path(id));
  return {.interpolateBoundary = ToToken(theirs.GetVertexInterpolationRule()),
          .faceVaryingLinearInterpolation = ToToken(theirs.GetFaceVaryingInterpolationRule()),
          .creaseMethod = ToToken(theirs.GetCreaseMethod()),
          .triangleSubdivision = ToToken(theirs.GetTriangleSubdivision()),
          .creaseIndices = ToArray<int32_t>(theirs.GetCreaseIndices()),
          .creaseLengths = ToArray<int32_t>(theirs.GetCreaseLengths()),
          .creaseWeights = ToArray<float>(theirs.GetCreaseWeights()),
          .cornerIndices = ToArray<int32_t>(theirs.GetCornerIndices()),
          .cornerWeights = ToArray<float>(theirs.GetCornerWeights())};
}

hd::BasisCurvesTopology HydraScene::GetBasisCurvesTopology(const hd::Path& id) {
  const pxr::HdBasisCurvesTopology theirs = host_->GetBasisCurvesTopology(path(id));
  return {.type = ToToken(theirs.GetCurveType()),
          .basis = ToToken(theirs.GetCurveBasis()),
          .wrap = ToToken(theirs.GetCurveWrap()),
          .curveVertexCounts = ToArray<int32_t>(theirs.GetCurveVertexCounts())};
}

hd::DisplayStyle HydraScene::GetDisplayStyle(const hd::Path& id) {
  return {.refineLevel = host_->GetDisplayStyle(path(id)).refineLevel};
}
hd::Matrix4d HydraScene::GetTransform(const hd::Path& id) {
  return ToMatrix(host_->GetTransform(path(id)));
}
bool HydraScene::GetVisible(const hd::Path& id) {
  return host_->GetVisible(path(id));
}
bool HydraScene::GetDoubleSided(const hd::Path& id) {
  return host_->GetDoubleSided(path(id));
}
hd::CullStyle HydraScene::GetCullStyle(const hd::Path& id) {
  return static_cast<hd::CullStyle>(host_->GetCullStyle(path(id)));
}
hd::Token HydraScene::GetRenderTag(const hd::Path& id) {
  return ToToken(host_->GetRenderTag(path(id)));
}
std::vector<hd::Token> HydraScene::GetCategories(const hd::Path& id) {
  return ToTokens(host_->GetCategories(path(id)));
}
hd::Path HydraScene::GetMaterialId(const hd::Path& id) {
  return ToPath(host_->GetMaterialId(path(id)));
}

std::vector<hd::PrimvarDescriptor> HydraScene::GetPrimvarDescriptors(const hd::Path& id) {
  descriptors_.clear();
  for (int i = 0; i < pxr::HdInterpolationCount; ++i) {
    const auto interpolation = static_cast<pxr::HdInterpolation>(i);
    for (const pxr::HdPrimvarDescriptor& theirs : host_->GetPrimvarDescriptors(path(id), interpolation))
      descriptors_.push_back(to_descriptor(theirs, theirs.indexed));
  }
  if (path(id) != id_) return descriptors_;
  for (const auto& theirs : computed()) {
    std::erase_if(descriptors_, [&](const auto& one) { return one.name == ToToken(theirs.name); });
    descriptors_.push_back(to_descriptor(theirs, false));
  }
  return descriptors_;
}

// Hosts without indexed primvars need not answer to GetIndexedPrimvar.
hd::Value HydraScene::GetPrimvar(const hd::Path& id, const hd::Token& name, hd::Array<int32_t>* indices) {
  const bool is_indexed =
      std::any_of(descriptors_.begin(), descriptors_.end(), [&](const auto& d) { return d.name == name && d.indexed; });
  const pxr::TfToken key(name.str());
  if (const auto* by_host = computed(id, name)) {
    const auto values = pxr::HdExtComputationUtils::GetComputedPrimvarValues({*by_host}, host_);
    const auto found = values.find(by_host->name);
    return found == values.end() ? hd::Value() : ToValue(found->second);
  }
  if (!is_indexed) return ToValue(host_->Get(path(id), key));
  pxr::VtIntArray found;
  const pxr::VtValue value = host_->GetIndexedPrimvar(path(id), key, &found);
  *indices = ToArray<int32_t>(found);
  return ToValue(value);
}

hd::TimeSamples<hd::Matrix4d> HydraScene::SampleTransform(const hd::Path& id) {
  pxr::HdTimeSampleArray<pxr::GfMatrix4d, kSamples> samples;
  host_->SampleTransform(path(id), &samples);
  return to_samples(samples, ToMatrix);
}
hd::TimeSamples<hd::Value> HydraScene::SamplePrimvar(const hd::Path& id, const hd::Token& name) {
  if (const auto* by_host = computed(id, name)) {
    pxr::HdExtComputationUtils::SampledValueStore<kSamples> values;
    pxr::HdExtComputationUtils::SampleComputedPrimvarValues<kSamples>({*by_host}, host_, kSamples, &values);
    return to_samples(values[by_host->name], ToValue);
  }
  pxr::HdTimeSampleArray<pxr::VtValue, kSamples> samples;
  host_->SamplePrimvar(path(id), pxr::TfToken(name.str()), &samples);
  return to_samples(samples, ToValue);
}
hd::TimeSamples<hd::Matrix4d> HydraScene::SampleInstancerTransform(const hd::Path& instancerId) {
  pxr::HdTimeSampleArray<pxr::GfMatrix4d, kSamples> samples;
  host_->SampleInstancerTransform(path(instancerId), &samples);
  return to_samples(samples, ToMatrix);
}

hd::Path HydraScene::GetInstancerId(const hd::Path& primId) {
  return ToPath(host_->GetInstancerId(path(primId)));
}
hd::Matrix4d HydraScene::GetInstancerTransform(const hd::Path& instancerId) {
  return ToMatrix(host_->GetInstancerTransform(path(instancerId)));
}
hd::Array<int32_t> HydraScene::GetInstanceIndices(const hd::Path& instancerId, const hd::Path& prototypeId) {
  return ToArray<int32_t>(host_->GetInstanceIndices(path(instancerId), path(prototypeId)));
}
std::vector<std::vector<hd::Token>> HydraScene::GetInstanceCategories(const hd::Path& instancerId) {
  std::vector<std::vector<hd::Token>> ours;
  for (const auto& categories : host_->GetInstanceCategories(path(instancerId))) ours.push_back(ToTokens(categories));
  return ours;
}

hd::Token HydraScene::GetHostLightType(const hd::Path&) {
  return ToToken(light_type_);
}
hd::Value HydraScene::GetHostLightParameter(const hd::Path& id, const hd::Token& name) {
  hd::Value value = ToValue(host_->GetLightParamValue(path(id), pxr::TfToken(name.str())));
  if (name == hd::Token("lightGroup"))  // as RenderMan and Arnold have it
    for (const char* theirs : {"inputs:ri:light:lightGroup", "ri:light:lightGroup", "primvars:arnold:aov"})
      if (value.empty()) value = ToValue(host_->GetLightParamValue(path(id), pxr::TfToken(theirs)));
  return value;
}

hd::MaterialNetwork HydraScene::GetMaterialResource(const hd::Path& id) {
  const pxr::VtValue resource = host_->GetMaterialResource(path(id));
  hd::MaterialNetwork ours;
  if (!resource.IsHolding<pxr::HdMaterialNetworkMap>()) return ours;
  const pxr::HdMaterialNetwork2 theirs =
      pxr::HdConvertToHdMaterialNetwork2(resource.UncheckedGet<pxr::HdMaterialNetworkMap>());
  for (const auto& [node, held] : theirs.nodes) ours.nodes[ToPath(node)] = to_node(held);
  for (const auto& [name, terminal] : theirs.terminals)
    ours.terminals[ToToken(name)] = {ToPath(terminal.upstreamNode), ToToken(terminal.upstreamOutputName)};
  return ours;
}

}  // namespace alabaster::hydra
