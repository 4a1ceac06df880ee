// The hidden prims. Each caches what it has pulled, so that a Sync pulls only what is dirty, and posts one record.
#pragma once

#include <map>
#include <optional>

#include "core/light/light_description.h"
#include "delegate/api/prims.h"
#include "delegate/prims/mesh_cage.h"
#include "delegate/prims/render_param.h"

namespace alabaster::hd::prims {

/// A mesh is refined and its BVH built only when its shape changed; transform, visibility, material and instancing cost
/// a record.
class MeshPrim final : public Rprim {
 public:
  using Rprim::Rprim;
  DirtyBits GetInitialDirtyBitsMask() const override { return dirty::kAll; }
  void Sync(SceneDelegate* scene, RenderParam* param, DirtyBits* bits) override;
  void Finalize(RenderParam* param) override;

 private:
  void pull(SceneDelegate& scene, DirtyBits bits, const alabaster::DiagnosticSink& sink);
  void pull_shape(SceneDelegate& scene, DirtyBits bits, const alabaster::DiagnosticSink& sink);
  bool build(SceneParam& param);

  PulledMesh pulled_;
  bool shape_changed_ = false;
  Path material_;
  bool tag_visible_ = true, visible_ = true;
  MeshRecord record_;
};

class InstancerPrim final : public Instancer {
 public:
  using Instancer::Instancer;
  void Sync(SceneDelegate* scene, RenderParam* param, DirtyBits* bits) override;
  void Finalize(RenderParam* param) override;

 private:
  InstancerRecord record_;
};

class MaterialPrim final : public Sprim {
 public:
  using Sprim::Sprim;
  DirtyBits GetInitialDirtyBitsMask() const override { return dirty::kAll; }
  void Sync(SceneDelegate* scene, RenderParam* param, DirtyBits* bits) override;
  void Finalize(RenderParam* param) override;

 private:
  std::optional<MaterialNetwork> network_;
};

/// Prim types of lights, in the order of LightType.
inline constexpr const char* kLightTypes[] = {"rectLight", "sphereLight", "distantLight", "domeLight"};

class LightPrim final : public Sprim {
 public:
  LightPrim(const Path& id, LightType type) : Sprim(id) { light_.type = type; }
  DirtyBits GetInitialDirtyBitsMask() const override { return dirty::kAll; }
  void Sync(SceneDelegate* scene, RenderParam* param, DirtyBits* bits) override;
  void Finalize(RenderParam* param) override;

 private:
  alabaster::LightDescription light_;
};

class CameraPrim final : public Sprim {
 public:
  using Sprim::Sprim;
  DirtyBits GetInitialDirtyBitsMask() const override { return dirty::kAll; }
  void Sync(SceneDelegate* scene, RenderParam* param, DirtyBits* bits) override;
  void Finalize(RenderParam* param) override;

 private:
  CameraParameters camera_;
};

class RenderSettingsPrim final : public Bprim {
 public:
  using Bprim::Bprim;
  DirtyBits GetInitialDirtyBitsMask() const override { return dirty::kAll; }
  void Sync(SceneDelegate* scene, RenderParam* param, DirtyBits* bits) override;
  void Finalize(RenderParam* param) override;
};

}  // namespace alabaster::hd::prims
