#include "delegate/description/description_reader.h"

#include <filesystem>
#include <limits>

#include "core/files/input_file.h"
#include "core/files/real_path.h"
#include "core/texture/texture.h"
#include "core/texture/udim.h"
#include "delegate/description/name_match.h"

namespace alabaster::hd::description {
namespace {

using nlohmann::json;

template <class Map>
std::vector<Path> paths_of(const Map& prims) {
  std::vector<Path> paths;
  for (const auto& [path, prim] : prims) paths.push_back(path);
  return paths;
}

std::vector<Path> paths_of_kind(const host::RetainedSceneDelegate& scene, PrimKind kind) {
  switch (kind) {
    case PrimKind::mesh:
      return paths_of(scene.GetMeshes());
    case PrimKind::material:
      return paths_of(scene.GetMaterials());
    case PrimKind::light:
      return paths_of(scene.GetLights());
    case PrimKind::camera:
      return paths_of(scene.GetCameras());
  }
  return {};
}

const char* kind_name(PrimKind kind) {
  constexpr const char* names[] = {"mesh", "material", "light", "camera"};
  return names[static_cast<size_t>(kind)];
}

}  // namespace

Reader::Reader(const JsonDocument& document, std::string folder, LoadState* state)
    : document_(document), folder_(std::move(folder)), state_(*state) {
  if (!is_users() && !state_.options.allow_outside) within_ = allowed_folder(folder_);
}

bool Reader::fail(const std::string& pointer, const std::string& text) const {
  if (*state_.sink) (*state_.sink)({Severity::error, "description.invalid", place(pointer), text});
  return false;
}

void Reader::warn(const std::string& pointer, const std::string& text) const {
  if (*state_.sink) (*state_.sink)({Severity::warning, "description.doubtful", place(pointer), text});
}

std::string Reader::resolve(const std::string& pointer, const std::string& file) const {
  const std::filesystem::path path = std::filesystem::path(folder_) / file;
  std::string resolved = path.lexically_normal();
  if (within_.empty()) return resolved;
  std::string fault = outside_fault(within_, resolved);
  if (fault.empty())
    for (const UdimTile& tile : udim_tiles(resolved))
      if (fault.empty()) fault = outside_fault(within_, tile.path);
  if (fault.empty()) return resolved;
  state_.note_cause(LoadCause::input);
  if (*state_.sink) (*state_.sink)({Severity::error, "asset.outside", place(pointer), fault + "."});
  return {};
}

AssetPath Reader::asset(const std::string& pointer, const std::string& file) const {
  const std::string resolved = resolve(pointer, file);
  if (resolved.empty()) return {};
  const InputFile opened(resolved, within_);
  if (opened) return {file, resolved, nullptr, within_};
  state_.note_cause(LoadCause::input);
  if (!*state_.sink) return {};
  if (opened.fault() == InputFile::Fault::missing)
    (*state_.sink)({Severity::error, "asset.missing", place(pointer),
                    "There is no file '" + resolved + "'. Relative paths start at " +
                        (folder_.empty() ? "the working folder." : "the folder of the description.")});
  else
    (*state_.sink)(
        {Severity::error, "asset.unreadable", place(pointer), "'" + resolved + "': " + opened.reason() + "."});
  return {};
}

AssetPath Reader::image(const std::string& pointer, const std::string& file) const {
  AssetPath found{file, resolve(pointer, file), nullptr, within_};
  if (state_.options.keep_going || found.resolved.empty()) return found;
  TextureSource source;
  source.path = found.resolved, source.within = found.within;
  source.may_be_set = !udim_tiles(found.resolved).empty();
  if (!source.may_be_set) found = asset(pointer, file);
  if (found.resolved.empty()) return found;
  const auto [known, is_new] = state_.image_faults.try_emplace({found.resolved, found.within});
  std::string& problem = known->second;  // an image may be named often, and is opened once
  const auto note = [&](const alabaster::Diagnostic& d) {
    problem = d.text;
    if (d.code == "texture.memory") state_.note_cause(LoadCause::out_of_memory);
  };
  if (is_new && !is_image(source, note) && problem.empty()) problem = "it is no image";
  if (problem.empty()) return found;
  state_.note_cause(LoadCause::input);
  if (*state_.sink)
    (*state_.sink)({Severity::error, "asset.unreadable", place(pointer), "'" + found.resolved + "': " + problem + "."});
  return {};
}

Value to_value(const json& value) {
  if (value.is_boolean()) return value.get<bool>();
  if (value.is_number_integer()) {
    const auto number = value.get<int64_t>();
    const bool fits = number >= std::numeric_limits<int32_t>::min() && number <= std::numeric_limits<int32_t>::max();
    return fits ? Value(static_cast<int32_t>(number)) : Value(number);
  }
  if (value.is_number()) return value.get<float>();
  if (value.is_string()) return value.get<std::string>();
  if (value.is_array() && value.size() == 2) return Vec2f(value[0].get<float>(), value[1].get<float>());
  if (value.is_array() && value.size() == 3)
    return Vec3f(value[0].get<float>(), value[1].get<float>(), value[2].get<float>());
  return {};
}

std::vector<Path> find_prims(const Reader& reader, PrimKind kind, const std::string& pattern,
                             const std::string& pointer) {
  const bool is_mesh = kind == PrimKind::mesh;
  std::vector<Path> found;
  std::vector<std::string> names;
  for (const Path& path : paths_of_kind(reader.scene(), kind)) {
    if (matches(pattern, path, is_mesh) ||
        (is_mesh && !matching_subsets(pattern, reader.scene().GetMeshes().at(path).topology).empty()))
      found.push_back(path);
    names.push_back(authored_name(path, is_mesh));
  }
  if (!found.empty() || reader.state().posing) return found;
  const std::string none = names.empty() ? std::string(" The scene has none.") : suggestion(pattern, names);
  reader.fail(pointer, std::string("No ") + kind_name(kind) + " matches '" + pattern + "'." + none);
  return found;
}

}  // namespace alabaster::hd::description
