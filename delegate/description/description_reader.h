// The parts of a render description, each applied to the scene in its own file. Every reader takes values that the
// schema has accepted; what a schema cannot say (names, indices, contradictions) is checked here.
#pragma once

#include <optional>

#include "delegate/description/json_document.h"
#include "delegate/description/render_description.h"

namespace alabaster::hd::description {

/// The camera while it is put together: the description first, then the overrides.
struct CameraPlan {
  std::string use, use_place;  // name of an existing camera, and where it was asked for
  std::optional<Matrix4d> transform;
  std::map<Token, Value> parameters;  // in the contract's units
};

/// Where products of one size go.
struct FramePlan {
  std::optional<Vec2i> resolution;
  std::optional<Rect2i> crop;
  bool operator==(const FramePlan&) const = default;
};
struct ProductPlan {
  FramePlan frame;
  RenderProduct product;
};

/// What loading works on.
struct LoadState {
  host::RetainedSceneDelegate* scene = nullptr;
  const DiagnosticSink* sink = nullptr;
  SceneFile* result = nullptr;
  CameraPlan camera;
  RenderSettingsDescription settings;
  std::vector<ProductPlan> products;
};

/// One document being applied.
class Reader {
 public:
  Reader(const JsonDocument& document, std::string folder, LoadState* state)
      : document_(document), folder_(std::move(folder)), state_(*state) {}

  const nlohmann::json& value() const { return document_.value; }
  LoadState& state() const { return state_; }
  host::RetainedSceneDelegate& scene() const { return *state_.scene; }
  std::string place(const std::string& pointer) const { return document_.place(pointer); }
  /// Reports an error; returns false.
  bool fail(const std::string& pointer, const std::string& text) const;
  void warn(const std::string& pointer, const std::string& text) const;
  /// A file's name as the description means it.
  std::string resolve(const std::string& file) const;
  /// An existing file; empty after an error.
  AssetPath asset(const std::string& pointer, const std::string& file) const;
  /// One that is an image of a kind that can be read; empty after an error.
  AssetPath image(const std::string& pointer, const std::string& file) const;

 private:
  const JsonDocument& document_;
  std::string folder_;
  LoadState& state_;
};

bool apply_models(const Reader& reader);
bool apply_materials(const Reader& reader);
bool apply_meshes(const Reader& reader);
bool apply_lights(const Reader& reader);
bool apply_camera(const Reader& reader);
bool apply_settings(const Reader& reader);
bool apply_products(const Reader& reader);

/// The camera, default lights and RenderSettings prims, once everything has been applied.
bool complete_scene(LoadState* state);

/// A number, truth value, text (as std::string) or list of two or three numbers, as the contract holds it.
Value to_value(const nlohmann::json& value);

enum class PrimKind { mesh, material, light, camera };

/// Those of a kind of prim that `pattern` means; if none, reports the nearest existing name.
std::vector<Path> find_prims(const Reader& reader, PrimKind kind, const std::string& pattern,
                             const std::string& pointer);

/// An override ("materials/skin.roughness=0.3") and a dome ("sky.hdr,0.5") as render descriptions of their own, for
/// the same checks and readers.
bool override_document(const std::string& assignment, JsonDocument* document, std::string* error);
JsonDocument dome_document(const std::string& dome);

}  // namespace alabaster::hd::description
