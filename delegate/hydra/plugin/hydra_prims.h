// OpenUSD's prims, each with one of the contract's inside.
#pragma once

#include <pxr/imaging/hd/basisCurves.h>
#include <pxr/imaging/hd/camera.h>
#include <pxr/imaging/hd/instancer.h>
#include <pxr/imaging/hd/light.h>
#include <pxr/imaging/hd/material.h>
#include <pxr/imaging/hd/mesh.h>
#include <pxr/imaging/hd/points.h>

#include "delegate/api/prims.h"

namespace alabaster::hydra {

class HydraParam;

/// A prim of OpenUSD's over one of the contract's.
template <class Theirs, class Ours>
class HydraPrim : public Theirs {
 public:
  template <class... Arguments>
  explicit HydraPrim(Ours* prim, Arguments&&... arguments)
      : Theirs(std::forward<Arguments>(arguments)...), prim_(prim) {}
  Ours* prim() const { return prim_; }
  void Finalize(pxr::HdRenderParam* param) override;

 private:
  Ours* prim_;
};

/// `Theirs`: HdMesh, HdBasisCurves or HdPoints.
template <class Theirs>
class HydraRprim final : public HydraPrim<Theirs, hd::Rprim> {
 public:
  using HydraPrim<Theirs, hd::Rprim>::HydraPrim;
  pxr::HdDirtyBits GetInitialDirtyBitsMask() const override;
  void Sync(pxr::HdSceneDelegate* scene, pxr::HdRenderParam* param, pxr::HdDirtyBits* bits,
            const pxr::TfToken& repr) override;

 protected:
  pxr::HdDirtyBits _PropagateDirtyBits(pxr::HdDirtyBits bits) const override { return bits; }
  void _InitRepr(const pxr::TfToken& repr, pxr::HdDirtyBits* bits) override;
};

using HydraMesh = HydraRprim<pxr::HdMesh>;
using HydraCurves = HydraRprim<pxr::HdBasisCurves>;
using HydraPoints = HydraRprim<pxr::HdPoints>;

class HydraInstancer final : public HydraPrim<pxr::HdInstancer, hd::Instancer> {
 public:
  using HydraPrim::HydraPrim;
  void Sync(pxr::HdSceneDelegate* scene, pxr::HdRenderParam* param, pxr::HdDirtyBits* bits) override;
};

class HydraMaterial final : public HydraPrim<pxr::HdMaterial, hd::Sprim> {
 public:
  using HydraPrim::HydraPrim;
  pxr::HdDirtyBits GetInitialDirtyBitsMask() const override { return AllDirty; }
  void Sync(pxr::HdSceneDelegate* scene, pxr::HdRenderParam* param, pxr::HdDirtyBits* bits) override;
};

class HydraLight final : public HydraPrim<pxr::HdLight, hd::Sprim> {
 public:
  HydraLight(hd::Sprim* prim, const pxr::SdfPath& id, const pxr::TfToken& type) : HydraPrim(prim, id), type_(type) {}
  pxr::HdDirtyBits GetInitialDirtyBitsMask() const override { return AllDirty; }
  void Sync(pxr::HdSceneDelegate* scene, pxr::HdRenderParam* param, pxr::HdDirtyBits* bits) override;
  void Finalize(pxr::HdRenderParam* param) override;

 private:
  pxr::TfToken type_;
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
