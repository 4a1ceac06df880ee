// Every list that a host gives may be empty: the frame is rendered or refused, and the host goes on.
#include <gtest/gtest.h>

#include <functional>

#include "delegate/host/frame_recorder.h"
#include "testenv/support/stage.h"

namespace alabaster::hd::host {
namespace {

// A scene in which each list has a use: subdivision with creases, motion, instances, textures, a clip plane.
struct Parts {
  MeshDescription mesh = Stage::quad();
  InstancerDescription instancer;
  MaterialNetwork material;
  LightDescription light{"rectLight", {}, {{"intensity", 3.0f}}};
  CameraDescription camera;
  RenderSettingsDescription settings;

  Parts() {
    const TimeSamples<Matrix4d> moves{{0, 0.5}, {Matrix4d(), Matrix4d().translate(Vec3d(0.1, 0, 0))}};
    mesh.topology.scheme = "catmullClark";
    mesh.topology.holeIndices = Array<int32_t>{7};
    mesh.topology.geomSubsets = {{"/part", "/material", Array<int32_t>{0}}};
    mesh.subdivTags.creaseIndices = Array<int32_t>{0, 1};
    mesh.subdivTags.creaseLengths = Array<int32_t>{2};
    mesh.subdivTags.creaseWeights = Array<float>{2.0f};
    mesh.subdivTags.cornerIndices = Array<int32_t>{0};
    mesh.subdivTags.cornerWeights = Array<float>{3.0f};
    mesh.displayStyle.refineLevel = 1;
    mesh.primvars["st"] = {Interpolation::faceVarying, "textureCoordinate",
                           Array<Vec2f>{{0, 0}, {1, 0}, {1, 1}, {0, 1}}, Array<int32_t>{0, 1, 2, 3}};
    mesh.primvars["displayColor"] = {Interpolation::constant, "color", Array<Vec3f>{{0.5f, 0.5f, 0.5f}}, {}};
    mesh.primvars["holdout"] = {Interpolation::constant, "", Array<int32_t>{0}, {}};
    mesh.transformSamples = moves;
    mesh.primvarSamples["points"] = {{0, 0.5}, {mesh.primvars["points"].value, mesh.primvars["points"].value}};
    mesh.material = "/material";
    mesh.instancer = "/instancer";
    mesh.categories = {"one"};
    instancer.primvars["hydra:instanceTransforms"] = Array<Matrix4d>(std::vector<Matrix4d>(2));
    instancer.primvars["hydra:instanceTranslations"] = Array<Vec3f>{{0, 0, 0}, {1, 0, 0}};
    instancer.indices["/mesh"] = Array<int32_t>{0, 1};
    instancer.transformSamples = moves;
    const Value places = instancer.primvars["hydra:instanceTranslations"];
    instancer.primvarSamples["hydra:instanceTranslations"] = {{0, 0.5}, {places, places}};
    instancer.categories = {{"one"}, {}};
    material.nodes["/color"] = {"AlabasterPrimvar", {{"varname", Token("displayColor")}}, {}};
    material.nodes["/surface"] = {"AlabasterDisney", {{"roughness", 0.5f}}, {{"baseColor", {{"/color", "rgb"}}}}};
    material.nodes["/moved"] = {"AlabasterDisplacement", {}, {{"displacement", {{"/color", "r"}}}}};
    material.terminals = {{"surface", {"/surface", "out"}}, {"displacement", {"/moved", "out"}}};
    light.parameters["lightLink"] = Token("one");
    light.transform = Matrix4d().translate(Vec3d(0, 0, 3));
    camera.transform[3][2] = 4;
    camera.parameters = {{"focalLength", 1.0f},      {"horizontalAperture", 1.0f},
                         {"verticalAperture", 1.0f}, {"shutterOpen", 0.0},
                         {"shutterClose", 0.5},      {"clipPlanes", Array<Vec4f>{{0, 0, -1, 0}}}};
    camera.transformSamples = moves;
    settings.camera = "/camera";
    settings.width = settings.height = 4;
    settings.settings = {{"samples", 1}};
  }
};

RecordStatus record(const Parts& parts) {
  Stage stage;
  stage.scene.SetMaterial("/material", parts.material);
  stage.scene.SetInstancer("/instancer", parts.instancer);
  stage.scene.SetMesh("/mesh", parts.mesh);
  stage.scene.SetLight("/light", parts.light);
  stage.scene.SetCamera("/camera", parts.camera);
  stage.scene.SetRenderSettings("/settings", parts.settings);
  RecordOptions options;
  options.keep_going = true;
  bool told = false;
  options.diagnostics = [&](const Diagnostic&) { told = true; };
  const RecordStatus status = RecordFrame(stage.index.get(), &stage.scene, "/settings", options).status;
  const bool drawn = status == RecordStatus::done || status == RecordStatus::degraded;
  EXPECT_TRUE(drawn || told);
  return status;
}

template <class T>
std::function<void(Parts&)> emptied(T MeshDescription::*part) {
  return [part](Parts& p) { p.mesh.*part = {}; };
}
template <class T>
std::function<void(Parts&)> empty_topology(T MeshTopology::*list) {
  return [list](Parts& p) { p.mesh.topology.*list = {}; };
}
template <class T>
std::function<void(Parts&)> empty_tags(T SubdivTags::*list) {
  return [list](Parts& p) { p.mesh.subdivTags.*list = {}; };
}

using Edits = std::map<std::string, std::function<void(Parts&)>>;

Edits mesh_edits() {
  Edits edits = {
      {"counts", empty_topology(&MeshTopology::faceVertexCounts)},
      {"indices", empty_topology(&MeshTopology::faceVertexIndices)},
      {"holes", empty_topology(&MeshTopology::holeIndices)},
      {"subsets", empty_topology(&MeshTopology::geomSubsets)},
      {"faces of a subset", [](Parts& p) { p.mesh.topology.geomSubsets[0].indices = {}; }},
      {"creases", empty_tags(&SubdivTags::creaseIndices)},
      {"crease lengths", empty_tags(&SubdivTags::creaseLengths)},
      {"crease weights", empty_tags(&SubdivTags::creaseWeights)},
      {"corners", empty_tags(&SubdivTags::cornerIndices)},
      {"corner weights", empty_tags(&SubdivTags::cornerWeights)},
      {"primvars", emptied(&MeshDescription::primvars)},
      {"categories", emptied(&MeshDescription::categories)},
      {"samples of points", emptied(&MeshDescription::primvarSamples)},
      {"points and their samples",
       [](Parts& p) {
         p.mesh.primvars["points"].value = Array<Vec3f>();
         for (Value& value : p.mesh.primvarSamples["points"].values) value = Array<Vec3f>();
       }},
      {"values of samples", [](Parts& p) { p.mesh.primvarSamples["points"].values.clear(); }},
      {"times of samples", [](Parts& p) { p.mesh.primvarSamples["points"].times.clear(); }},
      {"sampled points", [](Parts& p) { p.mesh.primvarSamples["points"].values[1] = Array<Vec3f>(); }},
      {"no sampled value", [](Parts& p) { p.mesh.primvarSamples["points"].values[0] = Value(); }},
      {"times of the mesh", [](Parts& p) { p.mesh.transformSamples.times.clear(); }},
      {"transforms of the mesh", [](Parts& p) { p.mesh.transformSamples.values.clear(); }},
  };
  for (const char* name : {"points", "st", "displayColor", "holdout"}) {
    edits[std::string("no value of ") + name] = [name](Parts& p) { p.mesh.primvars[name].value = Value(); };
    edits[std::string("indices of ") + name] = [name](Parts& p) { p.mesh.primvars[name].indices = {}; };
  }
  edits["values of points"] = [](Parts& p) { p.mesh.primvars["points"].value = Array<Vec3f>(); };
  edits["values of st"] = [](Parts& p) { p.mesh.primvars["st"].value = Array<Vec2f>(); };
  edits["values of displayColor"] = [](Parts& p) { p.mesh.primvars["displayColor"].value = Array<Vec3f>(); };
  edits["values of holdout"] = [](Parts& p) { p.mesh.primvars["holdout"].value = Array<int32_t>(); };
  return edits;
}

Edits other_edits() {
  return {
      {"instances", [](Parts& p) { p.instancer.indices["/mesh"] = {}; }},
      {"prototypes", [](Parts& p) { p.instancer.indices.clear(); }},
      {"instance primvars", [](Parts& p) { p.instancer.primvars.clear(); }},
      {"places", [](Parts& p) { p.instancer.primvars["hydra:instanceTranslations"] = Array<Vec3f>(); }},
      {"transforms of instances",
       [](Parts& p) { p.instancer.primvars["hydra:instanceTransforms"] = Array<Matrix4d>(); }},
      {"times of the instancer", [](Parts& p) { p.instancer.transformSamples.times.clear(); }},
      {"transforms of the instancer", [](Parts& p) { p.instancer.transformSamples.values.clear(); }},
      {"times of places", [](Parts& p) { p.instancer.primvarSamples["hydra:instanceTranslations"].times.clear(); }},
      {"samples of places", [](Parts& p) { p.instancer.primvarSamples["hydra:instanceTranslations"].values.clear(); }},
      {"sampled places",
       [](Parts& p) { p.instancer.primvarSamples["hydra:instanceTranslations"].values[0] = Array<Vec3f>(); }},
      {"categories of instances", [](Parts& p) { p.instancer.categories.clear(); }},
      {"nodes", [](Parts& p) { p.material.nodes.clear(); }},
      {"terminals", [](Parts& p) { p.material.terminals.clear(); }},
      {"connections", [](Parts& p) { p.material.nodes["/surface"].inputConnections["baseColor"].clear(); }},
      {"connections of relief", [](Parts& p) { p.material.nodes["/moved"].inputConnections["displacement"].clear(); }},
      {"parameters of the light", [](Parts& p) { p.light.parameters.clear(); }},
      {"parameters of the camera", [](Parts& p) { p.camera.parameters.clear(); }},
      {"clip planes", [](Parts& p) { p.camera.parameters["clipPlanes"] = Array<Vec4f>(); }},
      {"times of the camera", [](Parts& p) { p.camera.transformSamples.times.clear(); }},
      {"transforms of the camera", [](Parts& p) { p.camera.transformSamples.values.clear(); }},
      {"purposes", [](Parts& p) { p.settings.includedPurposes.clear(); }},
      {"settings",
       [](Parts& p) {
         p.settings.settings = {{"samples", 1}};
       }},
  };
}

TEST(EmptyLists, EmptyListsAreRenderedOrRefused) {
  EXPECT_EQ(record(Parts()), RecordStatus::done);
  Edits edits = mesh_edits();
  edits.merge(other_edits());
  for (const auto& [name, edit] : edits)
    for (const bool alone : {true, false}) {
      SCOPED_TRACE(name);
      Parts parts;
      if (!alone) parts.mesh.instancer = Path(), parts.mesh.topology.scheme = "none";
      edit(parts);
      record(parts);
    }
}

}  // namespace
}  // namespace alabaster::hd::host
