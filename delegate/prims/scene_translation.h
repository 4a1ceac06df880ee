// Committed records -> what core renders. Here, and only here, paths are resolved: to materials and instancers that
// exist, or to their fallbacks.
#pragma once

#include <set>

#include "core/scene/scene.h"
#include "delegate/prims/diagnostics.h"
#include "delegate/prims/records.h"

namespace alabaster::hd::sync {

/// A prototype's place: innermost index fastest. `used` is false where an index names no point of its instancer.
struct Placement {
  Matrix4d matrix;
  bool used = true;
};

struct Translation {
  SceneDescription scene;
  std::vector<Path> material_paths;  // of all instances' materials, in order; empty path: default
  std::vector<Path> light_paths;     // parallel to scene.lights
};

/// Remembers what it has reported, so that a fault is told once and not at every commit.
class SceneTranslator {
 public:
  explicit SceneTranslator(alabaster::DiagnosticSink sink);
  Translation translate(const Records& records);

 private:
  struct Run;
  void report_once(const char* code, const Path& where, const std::string& text);

  alabaster::DiagnosticSink sink_;
  std::shared_ptr<const DisneyMaterial> default_material_;
  std::set<std::pair<std::string, std::string>> reported_;
};

/// Stable text of a translated scene and its cameras: what "dumpScene" answers.
std::string dump_scene(const Translation& translation, const Records& records);
/// What a snapshot requires, and which prim is the reason: what "requirements" answers.
std::string describe_requirements(const SceneSnapshot& snapshot, const Translation& translation);

}  // namespace alabaster::hd::sync
