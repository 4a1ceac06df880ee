// The hidden prims. Each caches what it has pulled, so that a Sync pulls only what is dirty, and posts one record.
#pragma once

#include "core/light/light_parameters.h"
#include "delegate/api/prims.h"
#include "delegate/prims/mesh_cage.h"
#include "delegate/prims/points.h"
#include "delegate/prims/scene_param.h"

namespace alabaster::hd::prims {

/// An instancer or prim that is one record for the renderer. An exception in Sync is reported and leaves the bits as
/// they were.
template <class Base>
class Recorded : public Base {
 public:
  using Base::Base;
  void Sync(SceneDelegate* scene, RenderParam* param, DirtyBits* bits) final {
    SceneParam& channel = SceneParam::of(param);
    const bool synced = guarded(
        channel.sink(), this->GetId().str(), [&] { *bits = post_record(*scene, channel, *bits); }, kEarlierStateIsKept);
    channel.set_failed(&failed_, !synced);
  }
  void Finalize(RenderParam* param) override {
    SceneParam::of(param).set_failed(&failed_, false);
    SceneParam::of(param).remove(this->GetId());
  }

 private:
  /// Pulls what is dirty and posts the record. Returns the bits that are still dirty.
  virtual DirtyBits post_record(SceneDelegate& scene, SceneParam& param, DirtyBits bits) = 0;
  bool failed_ = false;
};

template <class Base>
class RecordedPrim : public Recorded<Base> {
 public:
  using Recorded<Base>::Recorded;
  DirtyBits GetInitialDirtyBitsMask() const final { return dirty::kAll; }
};

/// With `param` a colour's space counts.
PulledPrimvar pull_primvar(SceneDelegate& scene, const Path& id, const PrimvarDescriptor& descriptor,
                           SceneParam* param);

/// The primvars by instance of an instancer of so many points (0: as many as are asked for). Those that do not fit are
/// reported. `held` is another object where they differ. `each`: of what they are in reports.
void update_by_instance(std::map<Token, PulledPrimvar> now, size_t points, const char* each, const Path& where,
                        SceneParam* param, std::shared_ptr<const OtherPrimvars>* held);

/// Pulls only: the shape is built where it is first drawn (built_meshes.h), once for each edit of it. Curves and points
/// are meshes from here on: their tubes are made with the shape (tubes.h), and points are one sphere in many places.
class MeshPrim final : public RecordedPrim<Rprim> {
 public:
  MeshPrim(const Path& id, const Token& type)
      : RecordedPrim(id),
        is_curves_(type == Token("basisCurves")),
        spheres_(type == Token("points") ? id.str() + "#places" : std::string()) {}
  void Finalize(RenderParam* param) override {
    if (!spheres_.empty()) SceneParam::of(param).remove(spheres_);
    RecordedPrim::Finalize(param);
  }

 private:
  DirtyBits post_record(SceneDelegate& scene, SceneParam& param, DirtyBits bits) override;
  void pull(SceneDelegate& scene, SceneParam& param, DirtyBits bits);
  void pull_shape(SceneDelegate& scene, DirtyBits bits);
  void pull_primvars(SceneDelegate& scene, SceneParam& param);
  void update_slots(SceneParam& param);
  void update_values_by_point(PulledMesh* shape, SceneParam& param);
  void post_points(SceneParam& param);

  const bool is_curves_;
  const Path spheres_;  // of points: the path of the record of their places
  PulledMesh pulled_;
  PlacedPoints places_;                                        // of points
  std::shared_ptr<const OtherPrimvars> by_point_, of_sphere_;  // of points, by what has them; null: none
  bool shape_changed_ = false;
  std::vector<GeomSubset> subsets_;
  Path material_;
  MeshRecord record_;
};

class InstancerPrim final : public Recorded<Instancer> {
 public:
  using Recorded::Recorded;

 private:
  DirtyBits post_record(SceneDelegate& scene, SceneParam& param, DirtyBits bits) override;
  InstancerRecord record_;
};

class MaterialPrim final : public RecordedPrim<Sprim> {
 public:
  using RecordedPrim::RecordedPrim;

 private:
  DirtyBits post_record(SceneDelegate& scene, SceneParam& param, DirtyBits bits) override;
  void post(const std::shared_ptr<const MaterialNetwork>& network, SceneParam& param);
  std::shared_ptr<const MaterialNetwork> network_;  // as posted last
  Token display_name_;
  const std::shared_ptr<KnownFaults> faults_ = std::make_shared<KnownFaults>();  // of the builder's thread
};

struct LightFiles;

class LightPrim final : public RecordedPrim<Sprim> {
 public:
  LightPrim(const Path& id, LightType type) : RecordedPrim(id) {
    record_.light.type = type;
    record_.light.name = id.str();
  }

 private:
  DirtyBits post_record(SceneDelegate& scene, SceneParam& param, DirtyBits bits) override;
  void reread(const std::string& file, SceneParam& param);
  void post(SceneParam& param);
  LightRecord record_;                 // without what its files hold
  std::shared_ptr<LightFiles> files_;  // null: it names none
};

class CameraPrim final : public RecordedPrim<Sprim> {
 public:
  using RecordedPrim::RecordedPrim;

 private:
  DirtyBits post_record(SceneDelegate& scene, SceneParam& param, DirtyBits bits) override;
  CameraRecord record_;
  KnownFaults faults_;
};

/// A camera by value. `where`: its name in reports. `faults`: those of its camera before it, which are not reported
/// again.
CameraRecord record_of(const CameraDescription& camera, const Path& where, const alabaster::DiagnosticSink& sink,
                       KnownFaults* faults);

class RenderSettingsPrim final : public RecordedPrim<Bprim> {
 public:
  /// `changed` is called in Sync and Finalize, after the record or its end has been posted.
  RenderSettingsPrim(const Path& id, std::function<void()> changed) : RecordedPrim(id), changed_(std::move(changed)) {}
  void Finalize(RenderParam* param) override {
    RecordedPrim::Finalize(param);
    guarded(SceneParam::of(param).sink(), GetId().str(), [&] { changed_(); });
  }

 private:
  DirtyBits post_record(SceneDelegate& scene, SceneParam& param, DirtyBits bits) override;
  const std::function<void()> changed_;
};

}  // namespace alabaster::hd::prims
