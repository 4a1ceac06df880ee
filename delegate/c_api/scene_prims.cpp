#include "delegate/c_api/scene_prims.h"

#include "delegate/support/retired_settings.h"

namespace alabaster::hd::c_api {
namespace {

MeshTopology read_topology(const AlabasterMesh& in, ValueReader& reader) {
  MeshTopology topology;
  topology.scheme = text_or(in.scheme, "none");
  topology.orientation = text_or(in.orientation, "rightHanded");
  topology.faceVertexCounts = reader.ints(in.face_vertex_counts, "face_vertex_counts");
  topology.faceVertexIndices = reader.ints(in.face_vertex_indices, "face_vertex_indices");
  topology.holeIndices = reader.ints(in.hole_indices, "hole_indices");
  topology.invisibleFaces = reader.ints(in.invisible_faces, "invisible_faces");
  for (const AlabasterSubset& subset : items(in.subsets, in.subset_count, "subsets")) {
    topology.geomSubsets.push_back(
        {text_or(subset.id, ""), text_or(subset.material, ""), reader.ints(subset.faces, "faces of a subset")});
  }
  return topology;
}

SubdivTags read_tags(const AlabasterSubdivTags* given, ValueReader& reader) {
  SubdivTags tags;
  if (!given) return tags;
  const auto in = sized(given, "subdiv_tags");
  tags.interpolateBoundary = text_or(in.interpolate_boundary, "");
  tags.faceVaryingLinearInterpolation = text_or(in.face_varying_linear_interpolation, "");
  tags.creaseMethod = text_or(in.crease_method, "");
  tags.triangleSubdivision = text_or(in.triangle_subdivision, "");
  tags.creaseIndices = reader.ints(in.crease_indices, "crease_indices");
  tags.creaseLengths = reader.ints(in.crease_lengths, "crease_lengths");
  tags.creaseWeights = reader.floats(in.crease_weights, "crease_weights");
  tags.cornerIndices = reader.ints(in.corner_indices, "corner_indices");
  tags.cornerWeights = reader.floats(in.corner_weights, "corner_weights");
  return tags;
}

}  // namespace

void read_primvar(const AlabasterPrimvar& in, ValueReader& reader, host::MeshDescription* mesh) {
  const Token name(name_of(in.name, "primvar"));
  if (in.interpolation < ALABASTER_CONSTANT || in.interpolation > ALABASTER_INSTANCE)
    throw bad_argument("primvar '" + name.str() + "': there is no interpolation " + std::to_string(in.interpolation));
  host::PrimvarValue& primvar = mesh->primvars[name];
  primvar.interpolation = Interpolation(in.interpolation);
  primvar.role = text_or(in.role, "");
  primvar.value = reader.value(in.value, name.str().c_str());
  primvar.indices = reader.ints(in.indices, "indices of a primvar");
  auto samples = reader.samples(in.motion);
  if (!samples.times.empty()) mesh->primvarSamples[name] = std::move(samples);
}

host::MeshDescription read_mesh(const AlabasterMesh* given, ValueReader& reader) {
  const auto in = sized(given, "mesh");
  host::MeshDescription mesh;
  mesh.topology = read_topology(in, reader);
  for (const AlabasterPrimvar& primvar : items(in.primvars, in.primvar_count, "primvars"))
    read_primvar(primvar, reader, &mesh);
  mesh.subdivTags = read_tags(in.subdiv_tags, reader);
  mesh.transformSamples = reader.transforms(in.motion);
  mesh.displayStyle.refineLevel = in.refine_level;
  mesh.transform = matrix_of(in.transform);
  mesh.visible = in.invisible == 0;
  mesh.doubleSided = in.single_sided == 0;
  if (in.cull_style < ALABASTER_CULL_DONT_CARE || in.cull_style > ALABASTER_CULL_FRONT_UNLESS_DOUBLE_SIDED)
    throw bad_argument("there is no cull_style " + std::to_string(in.cull_style));
  mesh.cullStyle = CullStyle(in.cull_style);
  mesh.material = Path(text_or(in.material, ""));
  mesh.instancer = Path(text_or(in.instancer, ""));
  mesh.renderTag = text_or(in.render_tag, "geometry");
  mesh.categories = reader.tokens(in.categories, "categories");
  return mesh;
}

host::InstancerDescription read_instancer(const AlabasterInstancer* given, ValueReader& reader) {
  const auto in = sized(given, "instancer");
  host::MeshDescription primvars;
  for (const AlabasterPrimvar& primvar : items(in.primvars, in.primvar_count, "primvars"))
    read_primvar(primvar, reader, &primvars);
  host::InstancerDescription instancer;
  instancer.transform = matrix_of(in.transform);
  instancer.parent = Path(text_or(in.parent, ""));
  for (const auto& [name, primvar] : primvars.primvars) instancer.primvars[name] = primvar.value;
  instancer.primvarSamples = std::move(primvars.primvarSamples);
  for (const AlabasterPrototype& prototype : items(in.prototypes, in.prototype_count, "prototypes"))
    instancer.indices[Path(name_of(prototype.id, "prototype"))] =
        reader.ints(prototype.indices, "indices of a prototype");
  instancer.transformSamples = reader.transforms(in.motion);
  return instancer;
}

MaterialNetwork read_material(const Path& id, const AlabasterMaterial* given, ValueReader& reader) {
  const auto in = sized(given, "material");
  MaterialNetwork network;
  const auto node_path = [&](const char* name) { return id.append(name_of(name, "node")); };
  for (const AlabasterNode& given_node : items(in.nodes, in.node_count, "nodes")) {
    MaterialNode& node = network.nodes[node_path(given_node.name)];
    node.nodeTypeId = text_or(given_node.type, "");
    node.parameters = reader.parameters({given_node.parameters, given_node.parameter_count}, "parameters of a node");
    for (const AlabasterConnection& connection :
         items(given_node.connections, given_node.connection_count, "connections of a node")) {
      node.inputConnections[name_of(connection.input, "connected input")].push_back(
          {node_path(connection.node), text_or(connection.output, "")});
    }
  }
  const auto terminal = [&](const char* kind, const char* name) {
    if (!name) return;
    if (!network.nodes.contains(node_path(name))) throw bad_argument("there is no node '" + std::string(name) + "'");
    network.terminals[kind] = {node_path(name), "out"};
  };
  terminal("surface", in.surface ? in.surface : in.node_count > 0 ? in.nodes[0].name : nullptr);
  terminal("displacement", in.displacement);
  return network;
}

host::LightDescription read_light(const AlabasterLight* given, ValueReader& reader) {
  const auto in = sized(given, "light");
  host::LightDescription light{text_or(in.type, ""), matrix_of(in.transform),
                               reader.parameters({in.parameters, in.parameter_count}, "parameters")};
  light.visible = in.invisible == 0;
  if (light.type.empty()) throw bad_argument("a light needs a type");
  return light;
}

host::CameraDescription read_camera(const AlabasterCamera* given, ValueReader& reader) {
  const auto in = sized(given, "camera");
  host::CameraDescription camera{matrix_of(in.transform),
                                 reader.parameters({in.parameters, in.parameter_count}, "parameters")};
  camera.transformSamples = reader.transforms(in.motion);
  return camera;
}

void refuse_retired(const Dictionary& settings) {
  for (const auto& [key, value] : settings)
    if (const std::string fault = support::RetiredSetting(key, value.text_or("")); !fault.empty())
      throw bad_argument(fault);
}

RenderSettingsDescription read_render_settings(const AlabasterRenderSettings* given, ValueReader& reader) {
  const auto in = sized(given, "render settings");
  RenderSettingsDescription settings;
  settings.camera = Path(text_or(in.camera, ""));
  if (in.width < 0 || in.height < 0) throw bad_argument("width and height must be at least 1, or 0 for the default");
  if (in.width != 0) settings.width = in.width;
  if (in.height != 0) settings.height = in.height;
  if (in.pixel_aspect != 0) settings.pixelAspectRatio = float(in.pixel_aspect);
  const Rect2i crop = {in.crop.min_x, in.crop.min_y, in.crop.max_x, in.crop.max_y};
  if (!crop.empty()) settings.crop = crop;
  settings.frame = in.frame;
  settings.settings = reader.dictionary({in.settings, in.setting_count}, "settings");
  refuse_retired(settings.settings);
  return settings;
}

}  // namespace alabaster::hd::c_api
