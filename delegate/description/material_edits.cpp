// Edits of materials as fields of their prims.
#include "delegate/description/load_state.h"
#include "delegate/looks/looks.h"
#include "delegate/support/extension.h"
#include "delegate/usd/usd_source.h"

namespace alabaster::hd::description {
namespace {

using host::Fields;
using nlohmann::json;

/// Fields of a node of that name that reads an image, in the place of one that is there.
void add_texture(LoadState& load, const std::string& pointer, const json& texture, const std::string& node,
                 Fields* fields) {
  const std::string layer = texture.value("layer", "");
  const Token wrap(texture.value("wrap", "repeat"));
  fields->insert(fields->end(), {{node + ".type", {}},
                                 {node + ".type", Token("AlabasterTexture")},
                                 {node + ".file", load.image(pointer + "/file", texture["file"], layer)},
                                 {node + ".sourceColorSpace", Token(texture.value("colorSpace", "auto"))},
                                 {node + ".wrapS", wrap},
                                 {node + ".wrapT", wrap},
                                 {node + ".st", Token(texture.value("st", "st"))}});
  if (!layer.empty()) fields->emplace_back(node + ".layer", Token(layer));
}

void set_texture(LoadState& load, const std::string& pointer, const json& texture, const std::string& surface,
                 const std::string& parameter, Fields* fields) {
  const std::string channel = texture.value("channel", "rgb"), name = surface + "." + parameter;
  if (channel == "direction" && parameter != "anisotropicRotation")
    load.fail(pointer + "/channel", "Only anisotropicRotation reads an angle; name r, g, b or a.");
  const std::string node = surface + "/" + parameter + "_texture";
  add_texture(load, pointer, texture, node, fields);
  // The constant multiplies the texture; without one it is 1.
  fields->emplace_back(name, Value());
  if (texture.contains("scale")) fields->emplace_back(name, field_value(texture["scale"]));
  fields->emplace_back(name, Path(node + "." + channel));
}

/// Tells of the images that a parameter loses.
void tell_lost_textures(LoadState& load, const Path& material, const std::string& name) {
  const MaterialNetwork& network = load.scene->GetMaterials().at(material);
  const auto& surface = network.nodes.at(network.terminals.at("surface").upstreamNode);
  const auto input = surface.inputConnections.find(name);
  if (input == surface.inputConnections.end()) return;
  for (const MaterialConnection& connection : input->second) {
    const auto node = network.nodes.find(connection.upstreamNode);
    if (node == network.nodes.end()) continue;
    const auto file = node->second.parameters.find("file");
    const AssetPath* image = file == node->second.parameters.end() ? nullptr : file->second.get<AssetPath>();
    if (image)
      load.report(Severity::info, "description.texture", material.str(),
                  name + " loses its texture '" + image->authored +
                      "': a value takes its place. To tint it, name it with a scale: {\"file\": ..., \"scale\": ...}");
  }
}

/// `keeps`: those of the material that is there already.
void set_parameters(LoadState& load, const std::string& pointer, const json& parameters, const Path& path,
                    const std::string& surface, bool keeps, Fields* fields) {
  if (surface.empty()) load.fail(pointer, "The material has no Disney surface; use replace instead of set.");
  for (const auto& [name, value] : parameters.items()) {
    if (value.is_object()) {
      set_texture(load, pointer_append(pointer, name), value, surface, name, fields);
      continue;
    }
    if (keeps) tell_lost_textures(load, path, name);
    fields->emplace_back(surface + "." + name, Value());  // takes its textures away
    fields->emplace_back(surface + "." + name, field_value(value));
  }
}

void set_bump(LoadState& load, const std::string& pointer, const json& bump, const std::string& surface,
              Fields* fields) {
  if (surface.empty()) load.fail(pointer, "The material has no Disney surface.");
  const std::string node = surface + "/bump_texture";
  add_texture(load, pointer, bump, node, fields);
  fields->insert(fields->end(), {{node + ".scale", Vec4f(bump.value("scale", 1.0f))},
                                 {surface + ".normal", {}},
                                 {surface + ".bump", Path(node + "." + bump.value("channel", "r"))}});
}

void set_displacement(LoadState& load, const std::string& pointer, const json& displacement, Fields* fields) {
  const std::string space = displacement.value("space", "normal"), image = "displacement/texture";
  if (space != "normal" && displacement.contains("channel"))
    load.fail(pointer + "/channel", "A vector takes all three channels; leave channel out.");
  add_texture(load, pointer, displacement, image, fields);
  const std::string channel = space == "normal" ? displacement.value("channel", "r") : "rgb";
  fields->insert(fields->end(), {{"displacement.type", {}},
                                 {"displacement.type", Token("AlabasterDisplacement")},
                                 {"displacement.scale", displacement.value("scale", 1.0f)},
                                 {"displacement.midlevel", displacement.value("midlevel", 0.0f)},
                                 {"displacement.space", Token(space)},
                                 {"displacement.displacement", Path(image + "." + channel)},
                                 {"displacement", Path("displacement.displacement")}});
}

using Looks = std::map<std::string, MaterialNetwork>;

/// The materials of a file of MaterialX, which is read once.
const Looks& looks_of(LoadState& load, const std::string& pointer, const AssetPath& file) {
  const auto [known, is_new] = load.looks.try_emplace(file.resolved);
  if (!is_new) return known->second;
  host::SourceOptions options;
  options.allow_outside = load.options.allow_outside, options.within = file.within;
  options.memory_limit = std::max(load.memory->left(), size_t(1));
  options.keep_going = load.options.keep_going;
  options.stage.allowed_folders = load.options.stage.allowed_folders,
  options.stage.seconds = load.options.stage.seconds;
  const auto source = usd::MakeStageSource();
  host::SceneEdits edits;
  host::SourceFault fault = source->Open(file.resolved, options, *load.sink);
  if (fault == host::SourceFault::none) fault = source->Pose({}, *load.sink, &edits);
  if (fault != host::SourceFault::none) {
    load.note_cause(fault == host::SourceFault::out_of_memory ? LoadCause::out_of_memory : LoadCause::input);
    throw LoadFailed();
  }
  for (auto& [path, prim] : edits.prims)
    if (auto* network = std::get_if<MaterialNetwork>(&prim))
      known->second[path.str().substr(path.str().rfind('/') + 1)] = std::move(*network);
  if (known->second.empty()) load.fail(pointer, "'" + file.resolved + "' has no material with a surface.");
  SceneFile::Model read{source->Facts(), {}, {}, {}};
  read.timeCodesPerSecond = 0, read.range.reset();  // it is no stage
  load.held.resize(load.held.bytes() + read.memory_bytes, file.resolved);
  load.result->models.push_back(std::move(read));
  return known->second;
}

const MaterialNetwork& find_look(LoadState& load, const std::string& pointer, const json& given) {
  const AssetPath file = load.asset(pointer + "/file", given["file"]);
  if (support::lower_extension(file.resolved) != ".mtlx")
    load.fail(pointer + "/file", "'" + file.resolved + "' is no file of MaterialX: name one that ends in .mtlx.");
  const Looks& looks = looks_of(load, pointer + "/file", file);
  const auto name = given.value("material", "");
  if (const auto found = looks.find(name); found != looks.end()) return found->second;
  if (name.empty() && looks.size() == 1) return looks.begin()->second;
  std::string all;
  for (const auto& look : looks) all += (all.empty() ? "" : ", ") + look.first;
  load.fail(pointer + (name.empty() ? "" : "/material"),
            name.empty() ? "The file has several materials; name one by 'material': " + all + "."
                         : "The file has no material '" + name + "'; it has " + all + ".");
}

}  // namespace

void read_material(LoadState& load, PrimEdit* edit) {
  const std::string& pointer = edit->pointer;
  const json& entry = edit->entry;
  const Path& path = edit->path;
  const bool set = entry.contains("set"), replace = entry.contains("replace"), mtlx = entry.contains("mtlx");
  const bool keep = mtlx || (!replace && !edit->is_new);
  if (set && replace) load.fail(pointer, "Give either set or replace, not both.");
  if (mtlx && replace) load.fail(pointer, "Give either mtlx or replace, not both; set changes what mtlx gives.");
  if (!set && !replace && !mtlx && !entry.contains("bump") && !entry.contains("displacement"))
    load.fail(pointer, "There is nothing to change: add 'set', 'replace', 'mtlx', 'bump' or 'displacement'.");
  if (mtlx) load.scene->SetMaterial(path, find_look(load, pointer + "/mtlx", entry["mtlx"]));
  std::string surface = "surface";
  if (keep) {  // a look of another kind is changed as the AlabasterDisney that it is drawn as
    const auto warn = [&](const char* code, const std::string& text) {
      load.report(Severity::warning, code, path.str(), text);
    };
    load.scene->SetMaterial(path, looks::ReadLook(load.scene->GetMaterials().at(path), warn));
    surface = host::DisneySurface(path, load.scene->GetMaterials().at(path));
  } else {
    edit->kind = "material";
    edit->fields = {{"surface.type", Token("AlabasterDisney")}, {"surface", Path("surface.surface")}};
  }
  for (const char* key : {"set", "replace"})
    if (entry.contains(key))
      set_parameters(load, pointer_append(pointer, key), entry[key], path, surface, keep, &edit->fields);
  if (entry.contains("bump")) set_bump(load, pointer + "/bump", entry["bump"], surface, &edit->fields);
  if (entry.contains("displacement"))
    set_displacement(load, pointer + "/displacement", entry["displacement"], &edit->fields);
}

}  // namespace alabaster::hd::description
