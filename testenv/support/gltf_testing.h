// Loads glTF documents in tests, from assets or from text made in the test, and writes loaded scenes as stable text.
#pragma once

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <sstream>
#include <string>

#include "delegate/gltf/gltf_scene.h"

namespace alabaster::hd::gltf::testing {

using Json = nlohmann::json;

struct GltfOptions : host::SourceOptions {
  std::optional<double> time = {};  // as of SceneSource::Pose
};
/// The result of loading a document, with all diagnostics.
struct Loaded {
  struct Summary : host::SceneFacts {
    bool ok = false;
    host::SourceFault fault = host::SourceFault::none;
  } summary;
  std::vector<Diagnostic> diagnostics;
  std::unique_ptr<host::RetainedSceneDelegate> scene = std::make_unique<host::RetainedSceneDelegate>();

  size_t count(Severity severity) const {
    size_t n = 0;
    for (const Diagnostic& diagnostic : diagnostics) n += diagnostic.severity == severity;
    return n;
  }
  /// True if a diagnostic of this severity has `text` in its code, place and text together.
  bool says(Severity severity, const std::string& text) const {
    for (const Diagnostic& d : diagnostics)
      if (d.severity == severity && (d.code + " " + d.where + " " + d.text).find(text) != std::string::npos)
        return true;
    return false;
  }
  std::string said() const {
    std::string text;
    for (const Diagnostic& d : diagnostics) text += d.code + " | " + d.where + " | " + d.text + "\n";
    return text;
  }
};

/// Loads the document's scene in one pose.
inline Loaded load(const std::string& file, const GltfOptions& options = {}) {
  Loaded loaded;
  const auto sink = [&](const Diagnostic& d) { loaded.diagnostics.push_back(d); };
  const auto source = MakeGltfSource();
  host::SourceOptions asked = options;
  asked.is_timed = options.time.has_value();
  host::SceneEdits edits;
  loaded.summary.fault = source->Open(file, asked, sink);
  if (loaded.summary.fault == host::SourceFault::none) loaded.summary.fault = source->Pose(options.time, sink, &edits);
  static_cast<host::SceneFacts&>(loaded.summary) = source->Facts();
  loaded.summary.ok =
      loaded.summary.fault == host::SourceFault::none && host::ApplyEdits(std::move(edits), loaded.scene.get()).empty();
  return loaded;
}

/// A temporary folder; the destructor removes it.
class TemporaryFolder {
 public:
  TemporaryFolder() {
    std::string name = (std::filesystem::temp_directory_path() / "alabaster_gltf_XXXXXX").string();
    path_ = mkdtemp(name.data());
  }
  ~TemporaryFolder() {
    std::error_code ignored;
    std::filesystem::remove_all(path_, ignored);
  }
  TemporaryFolder(const TemporaryFolder&) = delete;
  TemporaryFolder& operator=(const TemporaryFolder&) = delete;

  std::string write(const std::string& name, const std::string& content) const {
    const std::string file = path_ + "/" + name;
    std::ofstream(file, std::ios::binary) << content;
    return file;
  }
  Loaded load_text(const std::string& text, const std::string& name = "document.gltf") const {
    return load(write(name, text));
  }
  const std::string& path() const { return path_; }

 private:
  std::string path_;
};

inline std::string read_text(const std::string& file) {
  std::ostringstream text;
  text << std::ifstream(file, std::ios::binary).rdbuf();
  return text.str();
}

/// The folder named by ALABASTER_TEST_ASSETS. Empty if it is unset: a test then skips with kNoAssets.
inline std::string assets_folder() {
  const char* folder = std::getenv("ALABASTER_TEST_ASSETS");
  return folder ? folder : "";
}
inline constexpr const char* kNoAssets = "ALABASTER_TEST_ASSETS does not name a folder of glTF test files";

/// A GLB of a JSON text and a binary chunk (omitted if empty), padded as the container requires.
inline std::string make_glb(std::string json, std::string binary) {
  const auto u32 = [](size_t v) {
    return std::string{char(v & 255), char(v >> 8 & 255), char(v >> 16 & 255), char(v >> 24 & 255)};
  };
  json.resize((json.size() + 3) / 4 * 4, ' ');
  binary.resize((binary.size() + 3) / 4 * 4, '\0');
  std::string chunks = u32(json.size()) + "JSON" + json;
  if (!binary.empty()) chunks += u32(binary.size()) + std::string("BIN\0", 4) + binary;
  return "glTF" + u32(2) + u32(12 + chunks.size()) + chunks;
}

template <class T>
const T& primvar(const host::MeshDescription& mesh, const char* name) {
  static const T none;
  const auto found = mesh.primvars.find(name);
  const T* value = found == mesh.primvars.end() ? nullptr : found->second.value.template get<T>();
  return value ? *value : none;
}

inline std::string text_of(const std::map<Token, Value>& parameters) {
  std::string text;
  for (const auto& [name, value] : parameters) text += "  " + name.str() + " = " + value.to_string() + "\n";
  return text;
}

inline std::string text_of(const Matrix4d& m) {
  return "  transform = " + Value(m).to_string() + "\n";
}

inline std::string text_of(const host::MeshDescription& mesh) {
  constexpr const char* kInterpolations[] = {"constant", "uniform", "varying", "vertex", "faceVarying", "instance"};
  std::string text = "  scheme = " + mesh.topology.scheme.str() + ", " + mesh.topology.orientation.str() + ", level " +
                     std::to_string(mesh.displayStyle.refineLevel) + (mesh.doubleSided ? ", two-sided" : "") + "\n";
  text += "  counts = " + Value(mesh.topology.faceVertexCounts).to_string() + "\n";
  text += "  indices = " + Value(mesh.topology.faceVertexIndices).to_string() + "\n";
  text += "  material = <" + mesh.material.str() + ">, instancer = <" + mesh.instancer.str() + ">\n";
  text += text_of(mesh.transform);
  for (const auto& [name, primvar] : mesh.primvars) {
    text += "  " + name.str() + " (" + kInterpolations[int(primvar.interpolation)] + ", " + primvar.role.str() +
            ") = " + primvar.value.to_string() + "\n";
    if (!primvar.indices.empty()) text += "    by " + Value(primvar.indices).to_string() + "\n";
  }
  return text;
}

inline std::string text_of(const MaterialNetwork& network) {
  std::string text;
  for (const auto& [name, terminal] : network.terminals)
    text +=
        "  terminal " + name.str() + " = <" + terminal.upstreamNode.str() + ">." + terminal.upstreamOutput.str() + "\n";
  for (const auto& [id, node] : network.nodes) {
    text += "  node <" + id.str() + "> " + node.nodeTypeId.str() + "\n";
    for (const auto& [name, value] : node.parameters) text += "    " + name.str() + " = " + value.to_string() + "\n";
    for (const auto& [name, connections] : node.inputConnections)
      for (const MaterialConnection& c : connections)
        text += "    " + name.str() + " <- <" + c.upstreamNode.str() + ">." + c.upstreamOutput.str() + "\n";
  }
  return text;
}

/// Everything in the scene, in path order: the same text for the same scene.
inline std::string text_of(const host::RetainedSceneDelegate& scene) {
  std::string text;
  for (const auto& [id, mesh] : scene.GetMeshes()) text += "mesh " + id.str() + "\n" + text_of(mesh);
  for (const auto& [id, instancer] : scene.GetInstancers()) {
    text += "instancer " + id.str() + "\n" + text_of(instancer.primvars);
    for (const auto& [prototype, indices] : instancer.indices)
      text += "  of <" + prototype.str() + "> " + Value(indices).to_string() + "\n";
  }
  for (const auto& [id, material] : scene.GetMaterials()) text += "material " + id.str() + "\n" + text_of(material);
  for (const auto& [id, light] : scene.GetLights())
    text += "light " + id.str() + " " + light.type.str() + "\n" + text_of(light.transform) + text_of(light.parameters);
  for (const auto& [id, camera] : scene.GetCameras())
    text += "camera " + id.str() + "\n" + text_of(camera.transform) + text_of(camera.parameters);
  return text;
}

}  // namespace alabaster::hd::gltf::testing
