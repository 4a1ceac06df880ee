// The parts of a scene as entries of a render description. Internal to this room.
#pragma once

#include "delegate/description/written_gltf.h"

namespace alabaster::hd::description {

/// The files that a written scene consists of, and the names by which it calls those of others.
class WrittenFiles {
 public:
  /// `description`: the file to be written, which ends in .json.
  explicit WrittenFiles(const std::string& description);

  /// The name of a file beside the description: "head.gltf".
  std::string beside(const std::string& ending) const { return name_ + ending; }
  void add(const std::string& ending, std::string bytes);
  /// The name of a file of `id`'s: relative to the description where it lies below its folder, else absolute. Contents
  /// that are in memory become a file of their own. Throws NotWritten where the scene's own files would replace it.
  std::string name_of(const Path& id, const Value& file);
  /// True if glTF has images of this kind.
  static bool is_gltf_image(const Value& file);
  /// Writes all. Returns nothing, or why that failed; then those that were written before stay.
  std::string write() const;

 private:
  void check_taken(const std::string& ending) const;
  std::string folder_, name_;                               // the folder is absolute
  std::vector<std::pair<std::string, std::string>> files_;  // endings and bytes, the description last
  std::map<const void*, std::string> images_;               // those that were in memory, by their bytes
  std::vector<std::pair<Path, std::string>> named_;         // files of others, by absolute paths
};

/// A value as JSON of the type that the property of a schema has. Floats become the doubles that they are, so that
/// readers get the same floats back.
nlohmann::json to_json(const Value& value, const nlohmann::json& property = {});
nlohmann::json to_json(const Matrix4d& matrix);

/// A pattern that matches just this name.
std::string pattern_of(const std::string& name);

/// A material: its entry, and its textures of normals, which belong into the glTF document.
struct WrittenMaterial {
  nlohmann::json entry;
  NormalMaps normals;
};
WrittenMaterial written_material(const Path& id, const MaterialNetwork& network, const UvSets& sets,
                                 WrittenFiles* files);
/// A light without its links and its name.
nlohmann::json written_light(const Path& id, const host::LightDescription& light, WrittenFiles* files);
/// The parts of a mesh that glTF has no place for; empty if there are none.
nlohmann::json written_mesh(const Path& id, const host::MeshDescription& mesh);
/// Placements at times; empty if nothing moves. `now`: the placement at time 0.
nlohmann::json written_motion(const Path& id, const Matrix4d& now, const TimeSamples<Matrix4d>& samples);
nlohmann::json written_camera(const RenderPassState& state, const std::map<Path, host::CameraDescription>& cameras);
nlohmann::json written_settings(const RenderPassState& state, const std::map<Token, Value>& settings);

}  // namespace alabaster::hd::description
