#include <algorithm>
#include <cstdio>
#include <cstring>
#include <nlohmann/json.hpp>
#include <set>
#include <sstream>

#include "delegate/cli/commands.h"
#include "delegate/cli/exit_codes.h"
#include "delegate/cli/interrupt.h"
#include "delegate/cli/outputs.h"
#include "delegate/cli/predict.h"
#include "delegate/cli/render_options.h"
#include "delegate/cli/scene_session.h"
#include "delegate/cli/shell_word.h"
#include "delegate/cli/stopwatch.h"
#include "delegate/host/input_digests.h"
#include "delegate/host/parameter_pages.h"
#include "delegate/support/json_values.h"
#include "delegate/support/lookup.h"
#include "delegate/support/nearest_name.h"
#include "delegate/support/process_usage.h"

namespace alabaster::cli {
namespace {

using hd::description::WorldBox;
using hd::host::MeshDescription;
using hd::host::RetainedSceneDelegate;
using Json = nlohmann::ordered_json;

/// The name by which --set finds a prim, and its path.
Json named(const RetainedSceneDelegate& scene, const hd::Path& path) {
  Json prim{{"path", path.str()}};
  if (is_added(scene, path))
    prim["added"] = true;
  else
    prim["name"] = scene.GetName(path);
  return prim;
}

Json numbers(const hd::Vec3d& v) {
  return {v.x, v.y, v.z};
}

/// Null of a box without points.
Json box_json(const WorldBox& box) {
  if (!(box.min.x <= box.max.x)) return nullptr;
  return {{"min", numbers(box.min)},
          {"max", numbers(box.max)},
          {"size", numbers(box.max - box.min)},
          {"centre", numbers((box.min + box.max) * 0.5)}};
}

size_t cage_triangles(const MeshDescription& mesh) {
  size_t triangles = 0;
  for (const int32_t count : mesh.topology.faceVertexCounts) triangles += static_cast<size_t>(std::max(count - 2, 0));
  return triangles;
}

// The first subdivision makes a quad of every face corner, and each further one four quads of each. Loop subdivision
// makes four triangles of each triangle every time.
size_t refined_triangles(const MeshDescription& mesh) {
  const int level = mesh.topology.scheme == hd::Token("none") ? 0 : mesh.displayStyle.refineLevel;
  if (level <= 0) return cage_triangles(mesh);
  const size_t growth = size_t(1) << (2 * std::min(level, 8));
  if (mesh.topology.scheme == hd::Token("loop")) return cage_triangles(mesh) * growth;
  return mesh.topology.faceVertexIndices.size() * (growth / 4) * 2;
}

Json mesh_json(Json out, const MeshDescription& mesh, const WorldBox& box) {
  if (mesh.type == hd::Token("mesh"))
    out["faces"] = mesh.topology.faceVertexCounts.size();
  else if (mesh.type == hd::Token("basisCurves"))
    out["curves"] = mesh.curves.curveVertexCounts.size();
  else
    out["points"] = hd::support::value_in(mesh.primvars, hd::Token("points")).value.count();
  if (!(mesh.topology.scheme == hd::Token("none")))
    out["scheme"] = mesh.topology.scheme.str(), out["refineLevel"] = mesh.displayStyle.refineLevel;
  if (!mesh.material.empty()) out["material"] = mesh.material.str();
  if (!mesh.instancer.empty()) out["instancer"] = mesh.instancer.str();
  out["visible"] = mesh.visible;
  out["bounds"] = box_json(box);
  for (const hd::GeomSubset& subset : mesh.topology.geomSubsets) {
    Json one{{"path", subset.id.str()}, {"faces", subset.indices.size()}};
    if (!subset.materialId.empty()) one["material"] = subset.materialId.str();
    out["subsets"].push_back(std::move(one));
  }
  return out;
}

void add_geometry(hd::host::RetainedSceneDelegate& scene, Json* out) {
  size_t cage = 0, refined = 0;
  Json meshes = Json::array(), instancers = Json::array();
  const std::map<hd::Path, WorldBox> boxes = hd::description::MeshBoxes(scene);
  for (const auto& [path, mesh] : scene.GetMeshes()) {
    cage += cage_triangles(mesh);
    refined += refined_triangles(mesh);
    meshes.push_back(mesh_json(named(scene, path), mesh, boxes.at(path)));
  }
  for (const auto& [path, instancer] : scene.GetInstancers()) {
    size_t count = 0;
    for (const auto& [prototype, indices] : instancer.indices) count += indices.size();
    instancers.push_back({{"path", path.str()}, {"instances", count}});
  }
  (*out)["bounds"] = box_json(objects_box(scene));
  (*out)["triangles"] = {{"modelled", cage}, {"rendered", refined}};
  (*out)["meshes"] = std::move(meshes);
  (*out)["instancers"] = std::move(instancers);
}

Json model_json(const hd::host::SceneFacts& model) {
  Json animations = Json::array();
  for (const auto& animation : model.animations)
    animations.push_back({{"name", animation.name}, {"seconds", animation.seconds}});
  Json out = {{"scenes", model.scenes},
              {"animations", std::move(animations)},
              {"variants", model.variants},
              {"upAxis", model.up.str()},
              {"metersPerUnit", model.metersPerUnit}};
  if (model.timeCodesPerSecond > 0) out["timeCodesPerSecond"] = model.timeCodesPerSecond;
  if (model.range) out["range"] = *model.range;
  if (!model.unread.empty()) out["unread"] = model.unread;
  out["files"] = Json::object();
  for (const std::string& file : model.files) out["files"][file] = hd::host::FileDigest(file);
  return out;
}

std::string text_of(const std::string& name) {
  return name;
}
std::string text_of(const hd::Token& name) {
  return name.str();
}
template <class Name>
Json values_json(const std::map<Name, hd::Value>& values) {
  Json all = Json::object();
  for (const auto& [name, value] : values) all[text_of(name)] = hd::support::json_of(value);
  return all;
}

Json material_json(Json out, const hd::MaterialNetwork& network) {
  out["nodes"] = Json::array();
  for (const auto& [node_path, node] : network.nodes) {
    out["nodes"].push_back(
        {{"path", node_path.str()}, {"type", node.nodeTypeId.str()}, {"parameters", values_json(node.parameters)}});
  }
  return out;
}

void add_lights_and_cameras(const SceneSession& session, Json* out) {
  Json lights = Json::array(), cameras = Json::array(), renders = Json::array();
  for (const auto& [path, light] : session.scene.GetLights()) {
    lights.push_back(named(session.scene, path));
    lights.back()["type"] = light.type.str();
  }
  const auto& settings = session.scene.GetAllRenderSettings();
  const hd::Path used = settings.at(session.file.settings).camera;
  for (const auto& [path, camera] : session.scene.GetCameras()) {
    cameras.push_back(named(session.scene, path));
    cameras.back()["used"] = path == used;
    Json& parameters = cameras.back()["parameters"] = values_json(camera.parameters);
    for (const hd::host::FieldRow& row : hd::host::ParameterRows("camera"))  // as --set takes them
      if (const auto length = camera.parameters.find(row.name); row.in_millimetres && length != camera.parameters.end())
        parameters[row.name] =
            hd::description::Millimetres(static_cast<float>(length->second.number_or(0)), session.file.info);
  }
  for (const auto& [path, description] : settings) {
    Json files = Json::array();
    for (const hd::RenderProduct& product : description.products) files.push_back(product.file);
    renders.push_back({{"path", path.str()},
                       {"width", description.width},
                       {"height", description.height},
                       {"files", std::move(files)},
                       {"settings", values_json(description.settings)}});
    if (const auto& c = description.crop) renders.back()["crop"] = {c->minX, c->minY, c->maxX, c->maxY};
  }
  (*out)["lights"] = std::move(lights);
  (*out)["cameras"] = std::move(cameras);
  (*out)["renders"] = std::move(renders);
  (*out)["notes"] = session.file.notes;
}

/// The prims whose light each group is, as AOVs lightGroup:NAME show it.
Json light_groups_json(const RetainedSceneDelegate& scene) {
  std::map<std::string, std::vector<std::string>> groups;
  const auto add = [&](const hd::Path& path, const auto& values) {
    const auto group = values.find("lightGroup");
    if (group == values.end()) return;
    const hd::Value* value = nullptr;
    if constexpr (requires { group->second.interpolation; })
      value = &group->second.value;
    else
      value = &group->second;
    if (const std::string name = value->text_or(""); !name.empty()) groups[name].push_back(path.str());
  };
  for (const auto& [path, light] : scene.GetLights())
    if (light.visible) add(path, light.parameters);
  for (const auto& [path, mesh] : scene.GetMeshes()) add(path, mesh.primvars);
  Json all = Json::object();
  for (auto& [name, paths] : groups) all[name] = std::move(paths);
  return all;
}

/// Lists the scene; the text and --json print it.
Json listing_of(SceneSession& session, const std::string& file) {
  Json out{{"scene", file}};
  add_geometry(session.scene, &out);
  out["models"] = Json::array();
  for (const auto& model : session.file.models) out["models"].push_back(model_json(model));
  out["materials"] = Json::array();
  for (const auto& [path, network] : session.scene.GetMaterials())
    out["materials"].push_back(material_json(named(session.scene, path), network));
  add_lights_and_cameras(session, &out);
  out["lightGroups"] = light_groups_json(session.scene);
  return out;
}

// Text ----------------------------------------------------------------------------------------------

std::string shown(const Json& text) {
  return printable(text.get<std::string>());
}

std::string title(const Json& prim) {
  return prim.contains("added") ? shown(prim["path"]) + " (added)" : shown(prim["name"]) + ": " + shown(prim["path"]);
}

/// "300, 47, 3.7 mm"
std::string millimetres_text(const Json& lengths, double metres_per_unit) {
  std::string text;
  for (const Json& one : lengths.is_array() ? lengths : Json::array({lengths})) {
    const double millimetres = 1000 * metres_per_unit * one.get<double>();
    text += (text.empty() ? "" : ", ") + formatted(std::abs(millimetres) < 100 ? "%.3g" : "%.0f", millimetres);
  }
  return text + " mm";
}

std::string box_text(const Json& box) {
  if (box.is_null()) return "none";
  std::string text;
  for (const auto& [name, v] : box.items())
    text += formatted("%s%s (%.6g, %.6g, %.6g)", text.empty() ? "" : ", ", name.c_str(), v[0].get<double>() + 0.0,
                      v[1].get<double>() + 0.0, v[2].get<double>() + 0.0);
  return text;
}

/// The lists of a render description, with a change of an entry.
struct Kind {
  const char *list, *example;
};
constexpr Kind kKinds[] = {
    {"materials", "roughness=0.3"}, {"meshes", "visible=false"}, {"lights", "intensity=2"}, {"camera", "fStop=2.8"}};

std::string properties_text(const Kind& kind) {
  constexpr size_t kWidth = 100;
  const std::set<std::string> of_new_entries{"match", "name", "type"};
  const std::string begin = "  can be set:";
  std::set<std::string> names;
  for (const hd::host::FieldRow& row : hd::description::DescriptionKeys(kind.list)) names.insert(row.name);
  std::string text = begin, line, comma;
  for (const std::string& name : names) {
    if (of_new_entries.contains(name)) continue;
    line += comma;
    if (begin.size() + line.size() + name.size() + 2 > kWidth)
      text += line + "\n" + std::string(begin.size(), ' '), line.clear();
    line += " " + name;
    comma = ",";
  }
  return text + line + "\n";
}

/// The option that changes the prims of a name or a path. Globs match a name that escapes their marks.
std::string set_option(const Kind& kind, const std::string& name) {
  std::string place = kind.list;
  if (!name.empty()) place += '/';
  for (const char c : name) place += (std::strchr("*?[\\", c) ? "\\" : "") + std::string(1, c);
  return "--set " + shell_word(place + "." + kind.example);
}

// Materials of other surfaces take no parameters of AlabasterDisney.
bool can_be_changed(const Json& prim) {
  if (prim.contains("added") || has_control_character(prim["name"].get<std::string>())) return false;
  const Json nodes = prim.value("nodes", Json());
  return nodes.is_null() ||
         std::any_of(nodes.begin(), nodes.end(), [](const Json& node) { return node["type"] == "AlabasterDisney"; });
}

/// Tells how --set changes the first prim of a list that it can change. Several prims may have its name.
void print_overrides(const Kind& kind, const Json& prims) {
  constexpr size_t kMostPaths = 5;
  const auto first = std::find_if(prims.begin(), prims.end(), can_be_changed);
  if (first == prims.end()) return;
  const auto name = (*first)["name"].get<std::string>();
  std::printf("  to change: %s\n", set_option(kind, name).c_str());
  std::vector<std::string> paths;
  for (const Json& prim : prims)
    if (prim.value("name", "") == name && !prim.contains("added")) paths.push_back(prim["path"]);
  if (paths.size() > 1) {
    std::printf("  it changes %zu %s of this name; a path selects one:\n", paths.size(), kind.list);
    for (size_t i = 0; i < std::min(paths.size(), kMostPaths); ++i)
      std::printf("    %s\n", set_option(kind, paths[i]).c_str());
    if (paths.size() > kMostPaths) std::printf("    and so on\n");
  }
  std::fputs(properties_text(kind).c_str(), stdout);
}

void print_geometry(const Json& scene, double metres_per_unit) {
  const Json& meshes = scene["meshes"];
  std::printf("bounds in scene units (metres in glTF): %s\n", box_text(scene["bounds"]).c_str());
  if (!scene["bounds"].is_null())
    std::printf("size: %s\n", millimetres_text(scene["bounds"]["size"], metres_per_unit).c_str());
  std::printf("meshes: %zu (%zu triangles as modelled, %zu as rendered)\n", meshes.size(),
              scene["triangles"]["modelled"].get<size_t>(), scene["triangles"]["rendered"].get<size_t>());
  for (const Json& mesh : meshes) {
    std::string text = title(mesh) + ":";
    for (const char* parts : {"faces", "curves", "points"})
      if (mesh.contains(parts)) text += " " + mesh[parts].dump() + " " + parts;
    if (mesh.contains("scheme")) text += ", " + shown(mesh["scheme"]) + " level " + mesh["refineLevel"].dump();
    if (mesh.contains("material")) text += ", material " + shown(mesh["material"]);
    if (mesh.contains("instancer")) text += ", instanced by " + shown(mesh["instancer"]);
    std::printf("  %s%s\n    bounds: %s\n", text.c_str(), mesh["visible"] ? "" : ", hidden",
                box_text(mesh["bounds"]).c_str());
    for (const Json& subset : mesh.value("subsets", Json::array()))
      std::printf("    %s: %zu faces%s\n", shown(subset["path"]).c_str(), subset["faces"].get<size_t>(),
                  subset.contains("material") ? (", material " + shown(subset["material"])).c_str() : "");
  }
  print_overrides(kKinds[1], meshes);
  for (const Json& instancer : scene["instancers"])
    std::printf("instancer %s: %zu instances\n", shown(instancer["path"]).c_str(),
                instancer["instances"].get<size_t>());
}

std::string quoted(const Json& name) {
  const std::string text = shown(name);
  return text.empty() ? "" : " '" + text + "'";
}

// The choices of --scene, --animation and --variant, with the number of each.
void print_choices(const Json& model) {
  const auto print = [](const char* kind, const Json& names, const char* option) {
    if (!names.empty()) std::printf("%s: %zu, chosen by render %s 0\n", kind, names.size(), option);
    for (size_t i = 0; i < names.size(); ++i) std::printf("  %zu%s\n", i, quoted(names[i]).c_str());
  };
  const Json& animations = model["animations"];
  if (model["scenes"].size() > 1) print("scenes", model["scenes"], "--scene");
  if (!animations.empty()) std::printf("animations: %zu, chosen by render --time 0 --animation 0\n", animations.size());
  for (size_t i = 0; i < animations.size(); ++i)
    std::printf("  %zu%s: %.4g s\n", i, quoted(animations[i]["name"]).c_str(), animations[i]["seconds"].get<double>());
  print("variants", model["variants"], "--variant");
  if (model["files"].size() > 1) std::printf("files: %zu, which --json lists\n", model["files"].size());
  if (model["upAxis"] != "Y") std::printf("up axis: %s\n", shown(model["upAxis"]).c_str());
  if (model["metersPerUnit"] != 1) std::printf("metres per unit: %.6g\n", model["metersPerUnit"].get<double>());
  if (model.contains("timeCodesPerSecond"))
    std::printf("time codes per second: %.6g\n", model["timeCodesPerSecond"].get<double>());
  if (model.contains("range"))
    std::printf("time codes: %.6g to %.6g\n", model["range"][0].get<double>(), model["range"][1].get<double>());
}

void print_materials(const Json& materials, double metres_per_unit) {
  std::set<std::string> lengths;
  for (const hd::host::FieldRow& row : hd::host::ParameterRows("disney_material"))
    if (row.unit == "scene unit") lengths.insert(row.name);
  std::printf("materials: %zu\n", materials.size());
  for (const Json& material : materials) {
    std::printf("  %s\n", title(material).c_str());
    for (const Json& node : material["nodes"])
      for (const auto& [name, value] : node["parameters"].items())
        std::printf("    %s.%s = %s%s\n", shown(node["type"]).c_str(), printable(name).c_str(),
                    printable(value.is_string() ? value.get<std::string>() : value.dump()).c_str(),
                    lengths.contains(name) && node["type"] == "AlabasterDisney" && !value.is_string()
                        ? (" (" + millimetres_text(value, metres_per_unit) + ")").c_str()
                        : "");
  }
  print_overrides(kKinds[0], materials);
}

void print_lights_and_cameras(const Json& scene) {
  std::printf("lights: %zu\n", scene["lights"].size());
  for (const Json& light : scene["lights"])
    std::printf("  %s: %s\n", title(light).c_str(), shown(light["type"]).c_str());
  print_overrides(kKinds[2], scene["lights"]);
  const Json& groups = scene["lightGroups"];
  if (!groups.empty()) std::printf("light groups: %zu, as layers by render --aov 'lightGroup:*'\n", groups.size());
  for (const auto& [name, paths] : groups.items()) {
    std::string text;
    for (const Json& path : paths) text += (text.empty() ? "" : ", ") + shown(path);
    std::printf("  %s: %s\n", printable(name).c_str(), text.c_str());
  }
  std::printf("cameras: %zu\n", scene["cameras"].size());
  for (const Json& camera : scene["cameras"])
    std::printf("  %s%s\n", title(camera).c_str(), camera["used"] ? " (used)" : "");
  std::printf("  to change: %s\n%s", set_option(kKinds[3], "").c_str(), properties_text(kKinds[3]).c_str());
  for (const Json& render : scene["renders"]) {
    std::printf("render %s: %sx%s\n", shown(render["path"]).c_str(), render["width"].dump().c_str(),
                render["height"].dump().c_str());
    for (const Json& file : render["files"]) std::printf("  -> %s\n", shown(file).c_str());
  }
  for (const Json& note : scene["notes"]) std::printf("note: %s\n", shown(note).c_str());
}

void print_listing(const Json& scene) {
  const double metres_per_unit =
      scene["models"].empty() ? 1 : scene["models"][0]["metersPerUnit"].get<double>();  // the first model's rule
  print_geometry(scene, metres_per_unit);
  for (const Json& model : scene["models"]) print_choices(model);
  print_materials(scene["materials"], metres_per_unit);
  print_lights_and_cameras(scene);
  std::fflush(stdout);
}

/// The JSON of a command is one document.
void print_json(const Json& document) {
  std::printf("%s\n", document.dump(2, ' ', false, Json::error_handler_t::replace).c_str());
}

std::vector<std::string> text_lines(const std::string& text) {
  std::istringstream lines(text);
  std::vector<std::string> all;
  for (std::string line; std::getline(lines, line);) all.push_back(line);
  return all;
}

/// Gives the render that is listed the products of the options.
void set_products(const PictureArguments& a, SceneSession* session, Console* console) {
  hd::RenderSettingsDescription settings = session->scene.GetAllRenderSettings().at(session->file.settings);
  const bool asked = !a.outputs.empty() || !a.aovs.empty() || a.exposure ||
                     !(a.display + a.view + a.look + a.compression).empty() || a.tiles;
  if (!asked && settings.products.empty()) return;
  settings.products = make_products(a, settings.products, "info", *console);
  session->scene.SetRenderSettings(session->file.settings, std::move(settings));
}

// Those of SchemaText.
const std::vector<std::string> kSchemas{
    "disney_material", "texture_node", "displacement_node", "textures",           "mesh",
    "lights",          "camera",       "render_settings",   "render_description", "quality_presets"};

void write_table_files(const std::string& sources, Console* console) {
  std::map<std::string, std::string> texts = hd::host::ParameterPages();
  for (const std::string& name : kSchemas)
    if (name != "quality_presets") texts["schemas/" + name + ".json"] = hd::description::SchemaText(name);
  for (const auto& [name, text] : texts) console->write_file(sources + "/" + name, text, "The file");
}

}  // namespace

int run_info(InfoArguments arguments) {
  // The start-up ran on one thread: its wall time is the same.
  const double linked = hd::support::process_cpu_seconds();
  const Stopwatch watch;
  catch_interrupts();
  Console console(false);
  SceneSession session;
  RenderArguments& render = arguments.render;
  if (arguments.predict) render.settings.emplace_back("--predict", "targetError", *arguments.predict);
  session.load(render.scene, load_options(render), console.sink());
  session.choose_colors(render.ocio, console.sink(), kInput);
  set_products(render, &session, &console);
  Json scene = listing_of(session, render.scene);
  if (!arguments.json) print_listing(scene);
  session.start(console.sink());
  Preparation spent{{linked + watch.wall(), linked + watch.cpu()}, {}};
  const Stopwatch sync_watch;
  session.index()->SyncAll();
  // It waits until the scene is built with its images.
  const std::string requirements = session.delegate()->InvokeCommand("requirements", {}).value.text_or("");
  spent.sync = {sync_watch.wall(), sync_watch.cpu()};
  scene["requires"] = text_lines(requirements);
  scene["peakMemory"] = hd::support::peak_memory_bytes();
  if (!arguments.json) {
    std::printf("requires:\n");
    for (const Json& line : scene["requires"]) std::printf("%s\n", shown(line).c_str());
    std::printf("peak memory so far: %.1f MB\n", scene["peakMemory"].get<double>() / 1e6);
    std::fflush(stdout);
  }
  const int fault = session.fault_code();
  int code = fault;
  if (fault == kDone && arguments.predict) code = predict(&session, &console, spent, *arguments.predict, &scene);
  if (arguments.json) print_json(scene);
  if (!arguments.json && scene.contains("prediction")) print_prediction(scene["prediction"]);
  return code;
}

int run_schema(const SchemaArguments& arguments) {
  Console console(false);
  if (!arguments.folder.empty()) return write_table_files(arguments.folder, &console), kDone;
  const char* const text = hd::description::SchemaText(arguments.name);
  if (!text)
    console.usage_error("schema", "There is no schema '" + arguments.name + "': choose from " + joined(kSchemas) + "." +
                                      hd::support::Suggestion(arguments.name, kSchemas));
  std::fputs(text, stdout);
  return kDone;
}

int run_ocio(const OcioArguments& arguments) {
  Console console(false);
  const hd::host::OutputColors colors{arguments.ocio};
  const std::string text = arguments.write_config ? hd::host::SerializeColors(colors, console.sink())
                                                  : hd::host::DescribeColors(colors, console.sink());
  if (text.empty()) return kInput;
  std::fputs((arguments.write_config ? text : without_control_characters(text, "\n")).c_str(), stdout);
  return kDone;
}

}  // namespace alabaster::cli
