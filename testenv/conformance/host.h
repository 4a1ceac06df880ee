// A small host on the contract's installed headers alone: a scene that is pulled, an index, a pass and its buffers.
// The kit of delegate/host is not used: it lies in the library under test, and another delegate need not have it.
#pragma once

#include <map>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include "delegate/api/render_delegate.h"

namespace conformance {

using namespace alabaster::hd;

/// The library under test.
struct Library {
  decltype(&CreateAlabasterRenderDelegate) create = nullptr;
  decltype(&DestroyAlabasterRenderDelegate) destroy = nullptr;
  double repeat = 1;  // scales the repetitions of tests; 10 is for sanitizers and nights, 0.01 for the bad delegates
};
const Library& library();
/// `full` times that scale, but at least `least`.
int repetitions(int full, int least);

struct Primvar {
  Value value;
  Interpolation interpolation = Interpolation::vertex;
  Token role;
  Array<int32_t> indices;  // empty: not indexed
};

struct Mesh {
  MeshTopology topology;
  SubdivTags tags;
  DisplayStyle style;
  std::map<Token, Primvar> primvars;
  Matrix4d transform;
  bool visible = true, double_sided = true;
  Token tag = "geometry";
  std::vector<Token> categories;
  Path material, instancer;
  TimeSamples<Matrix4d> motion;
  TimeSamples<Value> moving_points;
};

struct InstancerData {
  Matrix4d transform;
  Path parent;
  std::map<Token, Value> primvars;
  std::map<Path, Array<int32_t>> indices;  // by prototype
};

struct Light {
  Matrix4d transform;
  std::map<Token, Value> parameters;
  bool visible = true;
};

struct Camera {
  Matrix4d transform;
  std::map<Token, Value> parameters;
  TimeSamples<Matrix4d> motion;
};

/// Answers from maps, and counts what it is asked.
class Scene : public SceneDelegate {
 public:
  std::map<Path, Mesh> meshes;
  std::map<Path, InstancerData> instancers;
  std::map<Path, MaterialNetwork> materials;
  std::map<Path, Light> lights;
  std::map<Path, Camera> cameras;
  std::map<Path, RenderBufferDescriptor> buffers;

  /// "function path" of every pull since the last call, sorted.
  std::vector<std::string> take_pulls();

  MeshTopology GetMeshTopology(const Path& id) override;
  SubdivTags GetSubdivTags(const Path& id) override;
  DisplayStyle GetDisplayStyle(const Path& id) override;
  Matrix4d GetTransform(const Path& id) override;
  bool GetVisible(const Path& id) override;
  bool GetDoubleSided(const Path& id) override;
  Token GetRenderTag(const Path& id) override;
  std::vector<Token> GetCategories(const Path& id) override;
  Path GetMaterialId(const Path& id) override;
  std::vector<PrimvarDescriptor> GetPrimvarDescriptors(const Path& id) override;
  Value GetPrimvar(const Path& id, const Token& name, Array<int32_t>* indices) override;
  TimeSamples<Matrix4d> SampleTransform(const Path& id) override;
  TimeSamples<Value> SamplePrimvar(const Path& id, const Token& name) override;
  Path GetInstancerId(const Path& id) override;
  Matrix4d GetInstancerTransform(const Path& id) override;
  Array<int32_t> GetInstanceIndices(const Path& id, const Path& prototype) override;
  MaterialNetwork GetMaterialResource(const Path& id) override;
  Value GetLightParamValue(const Path& id, const Token& name) override;
  Value GetCameraParamValue(const Path& id, const Token& name) override;
  RenderBufferDescriptor GetRenderBufferDescriptor(const Path& id) override;
  RenderSettingsDescription GetRenderSettings(const Path& id) override;

 private:
  void count(const char* function, const Path& id);
  std::mutex mutex_;  // Rprims are synced in parallel
  std::vector<std::string> pulls_;
};

/// The pixels of a buffer, as they were mapped: rows from the lowest to the uppermost.
struct Picture {
  int width = 0, height = 0;
  Format format = Format::invalid;
  std::vector<uint8_t> bytes;
  bool operator==(const Picture&) const = default;

  float number(int x, int y, int component = 0) const;  // of a float32 format
  int32_t integer(int x, int y) const;                  // of int32
  /// The pixel at a point of the plane z = 0, of which the host's camera sees [-1, 1] x [-1, 1].
  Vec3f color(double x, double y) const;
  int32_t id(double x, double y) const;
};
Picture read(RenderBuffer& buffer);

/// One delegate with a scene, a camera, a pass and its buffers. The functions named after prims mark `bits` dirty and
/// return the scene's data for editing; a prim that does not exist yet is inserted.
class Host {
 public:
  explicit Host(int width = 16, int height = 16, Dictionary settings = {});
  ~Host();
  Host(const Host&) = delete;
  Host& operator=(const Host&) = delete;

  Mesh& mesh(const Path& id, DirtyBits bits = dirty::kAll);
  InstancerData& instancer(const Path& id, DirtyBits bits = dirty::kAll);
  MaterialNetwork& material(const Path& id, DirtyBits bits = dirty::kAll);
  Light& light(const Path& id, const Token& type, DirtyBits bits = dirty::kAll);
  Camera& camera(DirtyBits bits = dirty::kAll);
  void mark(const Path& id, DirtyBits bits);
  void remove(const Path& id);
  bool has(const Path& id) const { return entries_.contains(id); }
  DirtyBits dirty_bits(const Path& id) const { return entries_.at(id).bits; }
  int32_t prim_id(const Path& id) const;
  void set_prim_id(const Path& id, int32_t number);  // marks it dirty

  /// A buffer of the frame's size; the AOV's own format unless one is given.
  RenderBuffer& bind(const Token& aov, Format format = Format::invalid);
  RenderBuffer& buffer(const Token& aov = "color");
  void unbind(const Token& aov);
  /// Frame and buffers of another size.
  void resize(int width, int height);

  /// The contract's order (1.1), Rprims by several threads, then CommitResources.
  void sync();
  /// Executes until the pass has converged. False if the render is over and a hundred Executes more have not
  /// converged, or after a minute.
  bool converge();
  /// Syncs, converges (a failure of the test if not) and reads.
  Picture render(const Token& aov = "color");
  /// Until the scene that was committed last is there, and Execute has taken it up.
  void take_up();
  double stat(const std::string& key) const;
  std::string text_stat(const std::string& key) const;
  std::vector<Diagnostic> take_diagnostics();

  Scene scene;
  RenderDelegate* delegate = nullptr;
  std::unique_ptr<RenderPass> pass;
  RenderPassState state;
  int sync_threads = 2;

 private:
  enum class Kind { rprim, sprim, bprim, instancer };
  struct Entry {
    Kind kind = Kind::rprim;
    Token type;
    Prim* prim = nullptr;
    Instancer* instancer = nullptr;
    DirtyBits bits = dirty::kAll;
    bool visible = true;
  };
  void insert(const Path& id, Kind kind, const Token& type, DirtyBits bits);
  void destroy(const Entry& entry);
  void sync_entry(const Path& id, Entry& entry);
  void sync_kind(Kind kind, const Token& type);

  std::map<Path, Entry> entries_;
  std::mutex mutex_;
  std::vector<Diagnostic> diagnostics_;
  int32_t next_prim_id_ = 0;
  int width_, height_;
};

}  // namespace conformance
