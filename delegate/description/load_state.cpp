#include "delegate/description/load_state.h"

#include <filesystem>

#include "core/files/input_file.h"
#include "core/files/real_path.h"
#include "core/texture/texture.h"
#include "core/texture/udim.h"
#include "delegate/support/lookup.h"
#include "delegate/support/nearest_name.h"

namespace alabaster::hd::description {
namespace {

using nlohmann::json;

std::vector<Path> paths_of_kind(const host::RetainedSceneDelegate& scene, std::string_view kind) {
  std::vector<Path> paths;
  for (const auto& [path, prim] : scene.GetPrims())
    if (host::KindOf(prim) == kind) paths.push_back(path);
  return paths;
}

/// The nearest name, and the paths of the prims where several have it.
std::string nearest_prims(const std::string& pattern, const std::map<std::string, std::vector<Path>>& named) {
  constexpr size_t kMostPaths = 5;
  const std::string nearest = support::NearestName(pattern, support::keys_of(named));
  if (nearest.empty()) return {};
  const std::string text = " Did you mean '" + nearest + "'?";
  const std::vector<Path>& paths = named.at(nearest);
  if (paths.size() == 1) return text;
  std::string list;
  for (size_t i = 0; i < std::min(paths.size(), kMostPaths); ++i) list += (i == 0 ? "'" : ", '") + paths[i].str() + "'";
  return text + " It names " + std::to_string(paths.size()) + ", a path one of them: " + list +
         (paths.size() > kMostPaths ? ", ..." : "");
}

const NameIndex& names_of(LoadState& load, std::string_view kind) {
  const auto [found, is_new] = load.names.try_emplace(kind);
  if (!is_new) return found->second;
  const bool is_mesh = kind == "mesh";
  for (const Path& path : paths_of_kind(*load.scene, kind)) {
    found->second.add(path, load.scene->GetName(path));
    if (is_mesh) found->second.add_subsets(path, load.scene->GetMeshes().at(path).topology);
  }
  return found->second;
}

// The prims that a pattern with wildcards matches.
std::vector<Path> walk(const LoadState& load, std::string_view kind, const std::string& pattern) {
  const bool is_mesh = kind == "mesh";
  std::vector<Path> found;
  for (const Path& path : paths_of_kind(*load.scene, kind))
    if (matches(pattern, path, *load.scene) ||
        (is_mesh && !matching_subsets(pattern, load.scene->GetMeshes().at(path).topology).empty()))
      found.push_back(path);
  return found;
}

}  // namespace

const json* LoadState::part(const char* name) const {
  const auto found = document.value.find(name);
  return found == document.value.end() ? nullptr : &*found;
}

void LoadState::report(Severity severity, const char* code, const std::string& where, const std::string& text) const {
  if (*sink) (*sink)({severity, code, where, text});
}

void LoadState::fail(LoadCause noted, const char* code, const std::string& where, const std::string& text) {
  note_cause(noted);
  report(Severity::error, code, where, text);
  throw LoadFailed();
}

void LoadState::fail(const std::string& pointer, const std::string& text) {
  fail(document.is_of_option(pointer) ? LoadCause::option : LoadCause::input, "description.invalid",
       document.place(pointer), text);
}

void LoadState::edit(const std::string& pointer, const Path& prim, const Token& new_kind, const host::Fields& fields) {
  const std::string fault =
      new_kind.empty() ? host::EditPrim(scene, prim, fields).fault : host::SetPrim(scene, prim, new_kind, fields).fault;
  if (!fault.empty()) fail(pointer, fault + ".");
}

void LoadState::warn(const std::string& pointer, const std::string& text) const {
  report(Severity::warning, "description.doubtful", document.place(pointer), text);
}

std::string LoadState::within_of(const std::string& pointer) const {
  return document.is_of_option(pointer) ? std::string() : within;
}

std::string LoadState::resolve(const std::string& pointer, const std::string& file) {
  if (document.is_of_option(pointer)) return file;
  std::string resolved = (std::filesystem::path(folder) / file).lexically_normal();
  if (within.empty()) return resolved;
  std::string fault = outside_fault(within, resolved);
  if (fault.empty())
    for (const UdimTile& tile : udim_tiles(resolved))
      if (fault.empty()) fault = outside_fault(within, tile.path);
  if (!fault.empty())
    fail(LoadCause::input, "asset.outside", document.place(pointer),
         (file.starts_with('/') ? "It is an absolute path: " : "") + fault + ".");
  return resolved;
}

AssetPath LoadState::asset(const std::string& pointer, const std::string& file) {
  const std::string resolved = resolve(pointer, file);
  const InputFile opened(resolved, within_of(pointer));
  if (opened) return {file, resolved, nullptr, within_of(pointer)};
  const std::string start = document.is_of_option(pointer) ? "the working folder." : "the folder of the description.";
  if (opened.fault() == InputFile::Fault::missing)
    fail(LoadCause::input, "asset.missing", document.place(pointer),
         "There is no file '" + resolved + "'. Relative paths start at " + start);
  fail(LoadCause::input, "asset.unreadable", document.place(pointer),
       "'" + (opened.fault() == InputFile::Fault::foreign ? file : resolved) + "': " + opened.reason() + ".");
}

AssetPath LoadState::image(const std::string& pointer, const std::string& file, const std::string& layer) {
  AssetPath found{file, resolve(pointer, file), nullptr, within_of(pointer)};
  if (options.keep_going) return found;
  TextureSource source;
  source.path = found.resolved, source.within = found.within, source.layer = layer;
  source.may_be_set = !udim_tiles(found.resolved).empty();
  if (!source.may_be_set) found = asset(pointer, file);
  const auto [known, is_new] = image_faults.try_emplace({found.resolved, found.within, layer});
  std::string& problem = known->second;  // an image may be named often, and is opened once
  const auto note = [&](const alabaster::Diagnostic& d) {
    problem = d.text;
    if (d.code == "texture.memory") note_cause(LoadCause::out_of_memory);
  };
  if (is_new && !is_image(source, note) && problem.empty()) problem = "it is no image";
  if (!problem.empty())
    fail(LoadCause::input, "asset.unreadable", document.place(pointer), "'" + found.resolved + "': " + problem + ".");
  return found;
}

std::vector<Path> find_prims(LoadState& load, std::string_view kind, const std::string& pattern,
                             const std::string& pointer) {
  std::vector<Path> found = is_plain_name(pattern) ? names_of(load, kind).find(pattern) : walk(load, kind, pattern);
  if (!found.empty() || load.posing) return found;
  std::map<std::string, std::vector<Path>> named;
  for (const Path& path : paths_of_kind(*load.scene, kind)) named[load.scene->GetName(path)].push_back(path);
  load.fail(pointer, "No " + std::string(kind) + " matches '" + pattern + "'." +
                         (named.empty() ? " The scene has none." : nearest_prims(pattern, named)));
  return found;
}

Path new_path(LoadState& load, const std::string& kind, const Path& folder, const std::string& pointer,
              const std::string& name) {
  Path path = folder.append(name);
  const auto known = load.scene->GetPrims().find(path);
  const bool is_of_kind = known != load.scene->GetPrims().end() && host::KindOf(known->second) == kind;
  if (is_of_kind || load.archive_paths.contains(path))
    load.fail(pointer + "/name", "There is already a " + (is_of_kind ? kind : "prim") + " '" + path.str() +
                                     "': match it, or choose another name.");
  return path;
}

std::vector<size_t> find_parts(LoadState& load, const std::string& pattern, const Path& mesh) {
  if (matches(pattern, mesh, *load.scene)) return {};
  return is_plain_name(pattern) ? names_of(load, "mesh").find_subsets(pattern, mesh)
                                : matching_subsets(pattern, load.scene->GetMeshes().at(mesh).topology);
}

void add_name(LoadState& load, std::string_view kind, const Path& path) {
  if (const auto known = load.names.find(kind); known != load.names.end())
    known->second.add(path, load.scene->GetName(path));
}

}  // namespace alabaster::hd::description
