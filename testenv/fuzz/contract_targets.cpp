// Targets whose input is what a host pushes through the contract.
#include <nlohmann/json.hpp>

#include "testenv/fuzz/small_render.h"
#include "testenv/fuzz/structured_input.h"

namespace alabaster::fuzz {
namespace {

using hd::host::MeshDescription;
using hd::host::PrimvarValue;

constexpr int kMostPoints = 24, kMostFaces = 12;

hd::Vec3f vector(StructuredInput& in) {
  const float x = in.number(), y = in.number();
  return {x, y, in.number()};
}

hd::Array<int32_t> indices(StructuredInput& in, int most, int below) {
  std::vector<int32_t> list(static_cast<size_t>(in.choice(most + 1)));
  for (int32_t& one : list) one = in.choice(16) == 15 ? in.raw<int32_t>() : in.choice(below);
  return list;
}

hd::Array<float> numbers(StructuredInput& in, int most) {
  std::vector<float> list(static_cast<size_t>(in.choice(most + 1)));
  for (float& one : list) one = in.number();
  return list;
}

template <class T>
hd::Array<T> vectors(StructuredInput& in, int count) {
  std::vector<T> list(static_cast<size_t>(count));
  for (T& one : list)
    for (unsigned i = 0; i < T::dimensions(); ++i) one[static_cast<int>(i)] = in.number();
  return list;
}

hd::Matrix4d matrix(StructuredInput& in) {
  hd::Matrix4d m;
  if (in.flag()) return m;
  for (int i = 0; i < 4; ++i)
    for (int j = 0; j < 4; ++j)
      if (in.flag()) m[i][j] = in.flag() ? in.raw<double>() : in.number();
  return m;
}

hd::MeshTopology topology(StructuredInput& in) {
  constexpr const char* kSchemes[] = {"none", "catmullClark", "loop", "bilinear", "other"};
  hd::MeshTopology t;
  t.scheme = kSchemes[in.choice(5)];
  t.orientation = in.flag() ? "leftHanded" : "rightHanded";
  std::vector<int32_t> counts(static_cast<size_t>(in.choice(kMostFaces + 1))), corners;
  for (int32_t& count : counts) {
    count = in.choice(16) == 15 ? in.raw<int32_t>() : 3 + in.choice(3);
    for (int32_t i = 0; i < std::clamp(count, 0, 5); ++i)
      corners.push_back(in.choice(32) == 31 ? in.raw<int32_t>() : in.choice(kMostPoints));
  }
  if (in.choice(16) == 15) corners.resize(corners.size() / 2);
  t.faceVertexCounts = counts;
  t.faceVertexIndices = corners;
  t.holeIndices = indices(in, 2, kMostFaces);
  t.invisibleFaces = indices(in, 2, kMostFaces);
  if (in.flag()) t.geomSubsets = {{"/mesh/subset", "/m", indices(in, 4, kMostFaces)}};
  return t;
}

hd::SubdivTags subdivision(StructuredInput& in) {
  constexpr const char* kBoundaries[] = {"", "none", "edgeOnly", "edgeAndCorner", "other"};
  constexpr const char* kLinear[] = {"", "all", "none", "boundaries", "cornersOnly", "cornersPlus1", "cornersPlus2"};
  hd::SubdivTags tags;
  tags.interpolateBoundary = kBoundaries[in.choice(5)];
  tags.faceVaryingLinearInterpolation = kLinear[in.choice(7)];
  tags.creaseMethod = in.flag() ? "chaikin" : "uniform";
  tags.triangleSubdivision = in.flag() ? "smooth" : "catmullClark";
  tags.creaseIndices = indices(in, 6, kMostPoints);
  tags.creaseLengths = indices(in, 3, 4);
  tags.creaseWeights = numbers(in, 3);
  tags.cornerIndices = indices(in, 3, kMostPoints);
  tags.cornerWeights = numbers(in, 3);
  return tags;
}

PrimvarValue primvar(StructuredInput& in) {
  PrimvarValue value;
  value.interpolation = static_cast<hd::Interpolation>(in.choice(6));
  const int count = in.choice(kMostPoints * 2);
  switch (in.choice(6)) {
    case 0:
      value.value = vectors<hd::Vec2f>(in, count);
      break;
    case 1:
      value.value = vectors<hd::Vec3f>(in, count);
      break;
    case 2:
      value.value = vectors<hd::Vec4f>(in, count);
      break;
    case 3:
      value.value = numbers(in, count);
      break;
    case 4:
      value.value = indices(in, count, 9);
      break;
    default:
      value.value = in.number();
  }
  if (in.flag()) value.indices = indices(in, kMostPoints, kMostPoints);
  return value;
}

void add_instances(StructuredInput& in, hd::host::RetainedSceneDelegate* scene, MeshDescription* mesh) {
  hd::host::InstancerDescription instancer;
  instancer.transform = matrix(in);
  instancer.indices["/mesh"] = indices(in, 4, 3);
  instancer.primvars["hydra:instanceTranslations"] = vectors<hd::Vec3f>(in, in.choice(4));
  if (in.flag()) instancer.primvars["hydra:instanceScales"] = vectors<hd::Vec3f>(in, in.choice(4));
  if (in.flag()) instancer.parent = "/instancer";
  scene->SetInstancer("/instancer", instancer);
  mesh->instancer = "/instancer";
}

hd::Value value_for(StructuredInput& in, const std::string& name) {
  switch (in.choice(8)) {
    case 0:
      return vector(in);
    case 1:
      return in.raw<int32_t>();
    case 2:
      return in.flag();
    case 3:
      return in.raw<double>();
    case 4:
      return in.text(in.byte());
    default:
      return name.ends_with("olor") || name == "scatterDistance" ? hd::Value(vector(in)) : hd::Value(in.number());
  }
}

/// The names of a schema's parameters.
std::vector<std::string> names_of(const char* schema) {
  std::vector<std::string> names;
  const nlohmann::json document = nlohmann::json::parse(hd::description::SchemaText(schema));
  for (const auto& [name, entry] : document.at("properties").items()) names.push_back(name);
  return names;
}

/// Light above this adds up to more than floats hold, as does light below it with a greater exposure
/// (testenv/extremes/README.md, known limits).
constexpr double kMost = 1e35, kMostExposure = 8;

bool is_beyond_floats(const hd::Value& emission) {
  std::array<double, 4> numbers{};
  const size_t count = emission.components(&numbers);
  return std::any_of(numbers.begin(), numbers.begin() + static_cast<std::ptrdiff_t>(std::min<size_t>(count, 4)),
                     [](double number) { return !(std::abs(number) <= kMost); });
}

template <class Map>
void set_some(StructuredInput& in, const std::vector<std::string>& names, Map* parameters) {
  for (int left = in.choice(12); left > 0; --left) {
    const std::string& name = names[in.byte() % names.size()];
    (*parameters)[name] = value_for(in, name);
  }
}

}  // namespace

void run_mesh(Bytes input) {
  StructuredInput in(input);
  hd::host::RetainedSceneDelegate scene;
  add_stage(&scene);
  hd::MaterialNetwork network;
  network.nodes["/m/surface"] = {"AlabasterDisney", {{"subsurface", in.flag() ? 1.0f : 0.0f}}, {}};
  network.terminals["surface"] = {"/m/surface", "out"};
  scene.SetMaterial("/m", network);
  MeshDescription mesh;
  mesh.topology = topology(in);
  mesh.subdivTags = subdivision(in);
  mesh.displayStyle.refineLevel = in.choice(16) == 15 ? in.raw<int32_t>() : in.choice(4);
  mesh.primvars["points"].value = vectors<hd::Vec3f>(in, in.flag() ? kMostPoints : in.choice(kMostPoints));
  for (const char* name : {"normals", "st", "displayColor", "displayOpacity", "tangents"})
    if (in.flag()) mesh.primvars[name] = primvar(in);
  mesh.transform = matrix(in);
  mesh.doubleSided = in.flag();
  mesh.cullStyle = static_cast<hd::CullStyle>(in.choice(6));
  mesh.material = "/m";
  if (in.flag()) add_instances(in, &scene, &mesh);
  scene.SetMesh("/mesh", mesh);
  render_small(&scene);
}

void run_material(Bytes input) {
  static const std::vector<std::string> kMaterial = names_of("disney_material"), kLight = names_of("lights"),
                                        kCamera = names_of("camera");
  constexpr const char* kLights[] = {"rectLight", "diskLight", "cylinderLight", "sphereLight", "distantLight"};
  StructuredInput in(input);
  hd::host::RetainedSceneDelegate scene;
  add_stage(&scene);
  hd::MaterialNetwork network;
  network.nodes["/m/surface"] = {"AlabasterDisney", {}, {}};
  auto& parameters = network.nodes["/m/surface"].parameters;
  set_some(in, kMaterial, &parameters);
  if (const auto emission = parameters.find("emission");
      emission != parameters.end() && is_beyond_floats(emission->second))
    parameters.erase(emission);
  network.terminals["surface"] = {"/m/surface", "out"};
  scene.SetMaterial("/m", network);
  add_cube(&scene, "/m");
  hd::host::LightDescription light;
  light.type = kLights[in.choice(5)];
  light.transform = matrix(in);
  set_some(in, kLight, &light.parameters);
  scene.SetLight("/light", light);
  if (in.flag()) {
    hd::CameraDescription camera = scene.GetCameras().at("/camera");
    set_some(in, kCamera, &camera.parameters);
    const auto exposure = camera.parameters.find("exposure");
    if (exposure != camera.parameters.end() && exposure->second.number_or(0) > kMostExposure)
      camera.parameters.erase(exposure);
    if (in.flag()) camera.transform = matrix(in);
    scene.SetCamera("/camera", camera);
  }
  render_small(&scene);
}

}  // namespace alabaster::fuzz
