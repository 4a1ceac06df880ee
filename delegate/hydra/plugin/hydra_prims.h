// OpenUSD's prims, each with one of the contract's inside.
#pragma once

#include <pxr/imaging/hd/camera.h>
#include <pxr/imaging/hd/instancer.h>
#include <pxr/imaging/hd/light.h>
#include <pxr/imaging/hd/material.h>
#include <pxr/imaging/hd/mesh.h>

#include "delegate/api/prims.h"

namespace alabaster::hydra {

class HydraParam;

class HydraMesh final : public pxr::HdMesh {
 public:
  HydraMesh(const pxr::SdfPath& id, hd::Rprim* prim) : HdMesh(id), prim_(prim) {}
  hd::Rprim* prim() const { return prim_; }
  pxr::HdDirtyBits GetInitialDirtyBitsMask() const override;
  void Sync(pxr::HdSceneDelegate* scene, pxr::HdRenderParam* param, pxr::HdDirtyBits* bits,
            const pxr::TfToken& repr) override;
  void Finalize(pxr::HdRenderParam* param) override;

 protected:
  pxr::HdDirtyBits _PropagateDirtyBits(pxr::HdDirtyBits bits) const override { return bits; }
  void _InitRepr(const pxr::TfToken& repr, pxr::HdDirtyBits* bits) override;

 private:
  hd::Rprim* prim_;
};

class HydraInstancer final : public pxr::HdInstancer {
 public:
  HydraInstancer(pxr::HdSceneDelegate* scene, const pxr::SdfPath& id, hd::Instancer* instancer)
      : HdInstancer(scene, id), instancer_(instancer) {}
  hd::Instancer* instancer() const { return instancer_; }
  void Sync(pxr::HdSceneDelegate* scene, pxr::HdRenderParam* param, pxr::HdDirtyBits* bits) override;
  void Finalize(pxr::HdRenderParam* param) override;

 private:
  hd::Instancer* instancer_;
};

class HydraMaterial final : public pxr::HdMaterial {
 public:
  HydraMaterial(const pxr::SdfPath& id, hd::Sprim* prim) : HdMaterial(id), prim_(prim) {}
  hd::Sprim* prim() const { return prim_; }
  pxr::HdDirtyBits GetInitialDirtyBitsMask() const override { return AllDirty; }
  void Sync(pxr::HdSceneDelegate* scene, pxr::HdRenderParam* param, pxr::HdDirtyBits* bits) override;
  void Finalize(pxr::HdRenderParam* param) override;

 private:
  hd::Sprim* prim_;
};

class HydraLight final : public pxr::HdLight {
 public:
  HydraLight(const pxr::TfToken& type, const pxr::SdfPath& id, hd::Sprim* prim)
      : HdLight(id), type_(type), prim_(prim) {}
  hd::Sprim* prim() const { return prim_; }
  pxr::HdDirtyBits GetInitialDirtyBitsMask() const override { return AllDirty; }
  void Sync(pxr::HdSceneDelegate* scene, pxr::HdRenderParam* param, pxr::HdDirtyBits* bits) override;
  void Finalize(pxr::HdRenderParam* param) override;

 private:
  pxr::TfToken type_;
  hd::Sprim* prim_;
};

/// Passes take the camera by value, so that it needs no prim of the contract.
class HydraCamera final : public pxr::HdCamera {
 public:
  using HdCamera::HdCamera;
  void Sync(pxr::HdSceneDelegate* scene, pxr::HdRenderParam* param, pxr::HdDirtyBits* bits) override;
  const hd::CameraDescription& description() const { return description_; }

 private:
  /// Once: a part of the camera that is not read.
  void warn_of_unread(const HydraParam& param);

  hd::CameraDescription description_;
  bool warned_of_distortion_ = false;
};

}  // namespace alabaster::hydra
