#include <algorithm>
#include <cmath>
#include <cstdio>

#include "delegate/cli/commands.h"
#include "delegate/cli/control_characters.h"
#include "delegate/cli/exit_codes.h"
#include "delegate/cli/info_overrides.h"
#include "delegate/cli/interrupt.h"
#include "delegate/cli/predict.h"
#include "delegate/cli/scene_session.h"
#include "delegate/cli/stopwatch.h"
#include "delegate/description/authored_name.h"
#include "delegate/host/schemas.h"
#include "delegate/support/process_usage.h"

namespace alabaster::cli {
namespace {

using hd::host::MeshDescription;

std::string shown(const hd::Path& path) {
  return printable(path.str());
}

// A studio and the soft dome are added after all overrides.
bool is_added(const hd::Path& path) {
  const std::string name = hd::description::AuthoredName(path, false);
  return path == hd::Path("/studio/backdrop") || path == hd::Path("/lights/default_dome") ||
         name.starts_with("studio_");
}

/// The name by which --set finds a prim, and its path.
std::string named(const hd::Path& path, bool is_mesh) {
  if (is_added(path)) return shown(path) + " (added)";
  return printable(hd::description::AuthoredName(path, is_mesh)) + ": " + shown(path);
}

/// Prints how --set changes the first prim of a list that it can change and `fits` takes.
template <class Prims, class Fits>
void print_overrides(const char* list, const Prims& prims, const Fits& fits) {
  for (const auto& [path, prim] : prims) {
    const std::string name = hd::description::AuthoredName(path, list == std::string("meshes"));
    // An example for a name that a terminal would not show as it is cannot be copied.
    if (is_added(path) || has_control_character(name) || !fits(prim)) continue;
    std::fputs(override_lines(list, name).c_str(), stdout);
    return;
  }
}

// Materials of other surfaces take no parameters of AlabasterDisney.
bool is_disney(const hd::MaterialNetwork& network) {
  return std::any_of(network.nodes.begin(), network.nodes.end(),
                     [](const auto& node) { return node.second.nodeTypeId == hd::Token("AlabasterDisney"); });
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

std::string dimension(const hd::RenderSettingsDescription& s) {
  return std::to_string(s.width) + "x" + std::to_string(s.height);
}

void print_geometry(const hd::host::RetainedSceneDelegate& scene) {
  size_t cage = 0, refined = 0;
  for (const auto& [path, mesh] : scene.GetMeshes()) {
    cage += cage_triangles(mesh);
    refined += refined_triangles(mesh);
  }
  std::printf("meshes: %zu (%zu triangles as modelled, %zu as rendered)\n", scene.GetMeshes().size(), cage, refined);
  for (const auto& [path, mesh] : scene.GetMeshes()) {
    const std::string subdivision =
        mesh.topology.scheme == hd::Token("none")
            ? ""
            : ", " + mesh.topology.scheme.str() + " level " + std::to_string(mesh.displayStyle.refineLevel);
    std::printf("  %s: %zu faces%s%s%s%s\n", named(path, true).c_str(), mesh.topology.faceVertexCounts.size(),
                subdivision.c_str(), mesh.material.empty() ? "" : (", material " + shown(mesh.material)).c_str(),
                mesh.instancer.empty() ? "" : (", instanced by " + shown(mesh.instancer)).c_str(),
                mesh.visible ? "" : ", hidden");
    for (const hd::GeomSubset& subset : mesh.topology.geomSubsets)
      std::printf("    %s: %zu faces%s\n", shown(subset.id).c_str(), subset.indices.size(),
                  subset.materialId.empty() ? "" : (", material " + shown(subset.materialId)).c_str());
  }
  print_overrides("meshes", scene.GetMeshes(), [](const MeshDescription&) { return true; });
  for (const auto& [path, instancer] : scene.GetInstancers()) {
    size_t count = 0;
    for (const auto& [prototype, indices] : instancer.indices) count += indices.size();
    std::printf("instancer %s: %zu instances\n", shown(path).c_str(), count);
  }
}

std::string quoted(const std::string& name) {
  return name.empty() ? "" : " '" + printable(name) + "'";
}

// The choices of --scene, --animation and --variant, with the number of each.
void print_choices(const hd::gltf::GltfSummary& model) {
  const auto print = [](const char* kind, const std::vector<std::string>& names, const char* option) {
    if (!names.empty()) std::printf("%s: %zu, chosen by render %s 0\n", kind, names.size(), option);
    for (size_t i = 0; i < names.size(); ++i) std::printf("  %zu%s\n", i, quoted(names[i]).c_str());
  };
  if (model.scenes.size() > 1) print("scenes", model.scenes, "--scene");
  if (!model.animations.empty())
    std::printf("animations: %zu, chosen by render --time 0 --animation 0\n", model.animations.size());
  for (size_t i = 0; i < model.animations.size(); ++i)
    std::printf("  %zu%s: %.4g s\n", i, quoted(model.animations[i].name).c_str(), model.animations[i].seconds);
  print("variants", model.variants, "--variant");
}

void print_materials(const hd::host::RetainedSceneDelegate& scene) {
  std::printf("materials: %zu\n", scene.GetMaterials().size());
  for (const auto& [path, network] : scene.GetMaterials()) {
    std::printf("  %s\n", named(path, false).c_str());
    for (const auto& [node_path, node] : network.nodes)
      for (const auto& [name, value] : node.parameters)
        std::printf("    %s.%s = %s\n", node.nodeTypeId.str().c_str(), name.str().c_str(),
                    printable(value.to_string()).c_str());
  }
  print_overrides("materials", scene.GetMaterials(), is_disney);
}

void print_lights_and_cameras(const SceneSession& session) {
  std::printf("lights: %zu\n", session.scene.GetLights().size());
  for (const auto& [path, light] : session.scene.GetLights())
    std::printf("  %s: %s\n", named(path, false).c_str(), light.type.str().c_str());
  print_overrides("lights", session.scene.GetLights(), [](const hd::host::LightDescription&) { return true; });
  std::printf("cameras: %zu\n", session.scene.GetCameras().size());
  const auto& settings = session.scene.GetAllRenderSettings();
  const hd::Path used = settings.at(session.file.settings).camera;
  for (const auto& [path, camera] : session.scene.GetCameras())
    std::printf("  %s%s\n", named(path, false).c_str(), path == used ? " (used)" : "");
  std::fputs(override_lines("camera", "").c_str(), stdout);
  for (const auto& [path, description] : settings) {
    std::printf("render %s: %s\n", shown(path).c_str(), dimension(description).c_str());
    for (const hd::RenderProduct& product : description.products)
      std::printf("  -> %s\n", printable(product.file).c_str());
  }
  for (const std::string& note : session.file.notes) std::printf("note: %s\n", printable(note).c_str());
}

hd::description::LoadOptions load_options(const InfoArguments& a) {
  std::vector<hd::description::Override> flags;
  if (!a.threads.empty()) flags.emplace_back("--threads " + a.threads, "threads", a.threads);
  hd::description::LoadOptions options = scene_load_options(a, std::move(flags));
  options.size = a.size;
  return options;
}

// Those of SchemaText.
const std::vector<std::string> kSchemas{"disney_material", "textures",           "mesh",           "lights", "camera",
                                        "render_settings", "render_description", "quality_presets"};

void write_table_files(const std::string& sources, Console* console) {
  std::map<std::string, std::string> texts = hd::host::TableFiles();
  texts["schemas/render_description.json"] = hd::host::WithTables(hd::description::SchemaText("render_description"));
  for (const auto& [name, text] : texts) console->write_file(sources + "/" + name, text, "The file");
}

}  // namespace

int run_info(const InfoArguments& arguments) {
  // The start-up ran on one thread: its wall time is the same.
  const double linked = hd::support::process_cpu_seconds();
  const Stopwatch watch;
  catch_interrupts();
  Console console(false);
  SceneSession session;
  const hd::description::LoadOptions options = load_options(arguments);
  session.load(arguments.scene, options, console.sink());
  session.choose_colors("", console.sink(), kInput);
  print_geometry(session.scene);
  for (const hd::gltf::GltfSummary& model : session.file.gltf) print_choices(model);
  print_materials(session.scene);
  print_lights_and_cameras(session);
  std::fflush(stdout);
  session.start(console.sink());
  Preparation spent{{linked + watch.wall(), linked + watch.cpu()}, {}};
  const Stopwatch sync_watch;
  session.index()->SyncAll();
  // It waits until the scene is built with its images.
  const std::string requirements =
      without_control_characters(session.delegate()->InvokeCommand("requirements", {}).value.text_or(""), "\n");
  spent.sync = {sync_watch.wall(), sync_watch.cpu()};
  std::printf("requires:\n%s%s", requirements.c_str(), requirements.ends_with('\n') ? "" : "\n");
  std::printf("peak memory so far: %.1f MB\n", double(hd::support::peak_memory_bytes()) / 1e6);
  std::fflush(stdout);
  session.require_whole();
  return arguments.predict ? print_prediction(&session, &console, spent, *arguments.predict) : kDone;
}

int run_schema(const SchemaArguments& arguments) {
  Console console(false);
  if (!arguments.folder.empty()) return write_table_files(arguments.folder, &console), kDone;
  const char* const text = hd::description::SchemaText(arguments.name);
  if (!text)
    console.usage_error("schema", "There is no schema '" + arguments.name + "': choose from " + joined(kSchemas) + "." +
                                      did_you_mean(arguments.name, kSchemas));
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
