#include <algorithm>
#include <cstring>

#include "testenv/conformance/host.h"

namespace conformance {
namespace {

template <class T>
T found(const std::map<Path, T>& all, const Path& id) {
  const auto at = all.find(id);
  return at == all.end() ? T() : at->second;
}

}  // namespace

void Scene::count(const char* function, const Path& id) {
  const std::lock_guard lock(mutex_);
  pulls_.push_back(function + (" " + id.str()));
}

std::vector<std::string> Scene::take_pulls() {
  const std::lock_guard lock(mutex_);
  std::sort(pulls_.begin(), pulls_.end());
  pulls_.erase(std::unique(pulls_.begin(), pulls_.end()), pulls_.end());
  return std::exchange(pulls_, {});
}

MeshTopology Scene::GetMeshTopology(const Path& id) {
  count("topology", id);
  return found(meshes, id).topology;
}
SubdivTags Scene::GetSubdivTags(const Path& id) {
  count("tags", id);
  return found(meshes, id).tags;
}
DisplayStyle Scene::GetDisplayStyle(const Path& id) {
  count("style", id);
  return found(meshes, id).style;
}
Matrix4d Scene::GetTransform(const Path& id) {
  count("transform", id);
  if (meshes.contains(id)) return meshes.at(id).transform;
  if (lights.contains(id)) return lights.at(id).transform;
  return found(cameras, id).transform;
}
bool Scene::GetVisible(const Path& id) {
  if (meshes.contains(id)) return meshes.at(id).visible;
  return !lights.contains(id) || lights.at(id).visible;
}
bool Scene::GetDoubleSided(const Path& id) {
  return found(meshes, id).double_sided;
}
Token Scene::GetRenderTag(const Path& id) {
  return found(meshes, id).tag;
}
std::vector<Token> Scene::GetCategories(const Path& id) {
  return found(meshes, id).categories;
}
Path Scene::GetMaterialId(const Path& id) {
  count("material", id);
  return found(meshes, id).material;
}

std::vector<PrimvarDescriptor> Scene::GetPrimvarDescriptors(const Path& id) {
  count("primvars", id);
  std::vector<PrimvarDescriptor> all;
  for (const auto& [name, primvar] : found(meshes, id).primvars)
    all.push_back({name, primvar.interpolation, primvar.role, !primvar.indices.empty()});
  for (const auto& [name, value] : found(instancers, id).primvars)
    all.push_back({name, Interpolation::instance, Token(), false});
  return all;
}

Value Scene::GetPrimvar(const Path& id, const Token& name, Array<int32_t>* indices) {
  count(("primvar " + name.str()).c_str(), id);
  if (const auto mesh = meshes.find(id); mesh != meshes.end()) {
    const auto primvar = mesh->second.primvars.find(name);
    if (primvar == mesh->second.primvars.end()) return {};
    if (indices) *indices = primvar->second.indices;
    return primvar->second.value;
  }
  const auto instancer = instancers.find(id);
  if (instancer == instancers.end()) return {};
  const auto value = instancer->second.primvars.find(name);
  return value == instancer->second.primvars.end() ? Value() : value->second;
}

TimeSamples<Matrix4d> Scene::SampleTransform(const Path& id) {
  return meshes.contains(id) ? meshes.at(id).motion : found(cameras, id).motion;
}
TimeSamples<Value> Scene::SamplePrimvar(const Path& id, const Token& name) {
  return name == Token("points") ? found(meshes, id).moving_points : TimeSamples<Value>();
}
Path Scene::GetInstancerId(const Path& id) {
  return meshes.contains(id) ? meshes.at(id).instancer : found(instancers, id).parent;
}
Matrix4d Scene::GetInstancerTransform(const Path& id) {
  return found(instancers, id).transform;
}
Array<int32_t> Scene::GetInstanceIndices(const Path& id, const Path& prototype) {
  return found(found(instancers, id).indices, prototype);
}
MaterialNetwork Scene::GetMaterialResource(const Path& id) {
  count("network", id);
  return found(materials, id);
}
Value Scene::GetLightParamValue(const Path& id, const Token& name) {
  const std::map<Token, Value> parameters = found(lights, id).parameters;
  const auto at = parameters.find(name);
  return at == parameters.end() ? Value() : at->second;
}
Value Scene::GetCameraParamValue(const Path& id, const Token& name) {
  count("camera", id);
  const std::map<Token, Value> parameters = found(cameras, id).parameters;
  const auto at = parameters.find(name);
  return at == parameters.end() ? Value() : at->second;
}
RenderBufferDescriptor Scene::GetRenderBufferDescriptor(const Path& id) {
  return found(buffers, id);
}
RenderSettingsDescription Scene::GetRenderSettings(const Path&) {
  return {};
}

namespace {
template <class T>
T component(const Picture& picture, int x, int y, int index) {
  T value{};
  const size_t size = FormatSize(picture.format);
  const size_t at = (static_cast<size_t>(y) * static_cast<size_t>(picture.width) + static_cast<size_t>(x)) * size +
                    static_cast<size_t>(index) * sizeof(T);
  if (x >= 0 && y >= 0 && x < picture.width && at + sizeof(T) <= picture.bytes.size())
    std::memcpy(&value, picture.bytes.data() + at, sizeof(T));
  return value;
}
int pixel(double at, int size) {
  return static_cast<int>((at + 1) / 2 * size);
}
}  // namespace

float Picture::number(int x, int y, int index) const {
  return component<float>(*this, x, y, index);
}
int32_t Picture::integer(int x, int y) const {
  return component<int32_t>(*this, x, y, 0);
}
Vec3f Picture::color(double x, double y) const {
  const int i = pixel(x, width), j = pixel(y, height);
  return {number(i, j, 0), number(i, j, 1), number(i, j, 2)};
}
int32_t Picture::id(double x, double y) const {
  return integer(pixel(x, width), pixel(y, height));
}

Picture read(RenderBuffer& buffer) {
  buffer.Resolve();
  Picture picture;
  const void* pixels = buffer.Map();
  picture.width = buffer.GetWidth(), picture.height = buffer.GetHeight(), picture.format = buffer.GetFormat();
  const size_t size =
      static_cast<size_t>(picture.width) * static_cast<size_t>(picture.height) * FormatSize(picture.format);
  const auto* bytes = static_cast<const uint8_t*>(pixels);
  if (bytes) picture.bytes.assign(bytes, bytes + size);
  buffer.Unmap();
  return picture;
}

}  // namespace conformance
