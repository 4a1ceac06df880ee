// Arguments of calls of the C interface, right and wrong ones: nulls, sizes that no header has, counts without arrays,
// fields of every kind, with values of their type or of any other. Arrays are lent now and then, and it is counted how
// often each comes back.
#pragma once

#include <array>
#include <atomic>
#include <deque>
#include <span>
#include <tuple>
#include <utility>
#include <vector>

#include "delegate/c_api/alabaster.h"
#include "testenv/fuzz/small_render.h"
#include "testenv/fuzz/structured_input.h"

namespace alabaster::fuzz {

/// A field of a kind of prim, and what it takes.
struct FieldOfKind {
  enum Takes { words, numbers, few_ints, samples };  // few_ints: small ones, for what costs time or memory by them
  const char* name;
  int32_t type;
  bool is_array;
  Takes takes;
};
struct Kind {
  const char* name;
  std::span<const FieldOfKind> fields;
};
using F = FieldOfKind;
inline constexpr F kMeshFields[] = {{"faceVertexCounts", ALABASTER_INT, true, F::few_ints},
                                    {"faceVertexIndices", ALABASTER_INT, true, F::few_ints},
                                    {"holeIndices", ALABASTER_INT, true, F::numbers},
                                    {"invisibleFaces", ALABASTER_INT, true, F::few_ints},
                                    {"scheme", ALABASTER_TOKEN, false, F::words},
                                    {"refineLevel", ALABASTER_INT, false, F::few_ints},
                                    {"primvars:points", ALABASTER_FLOAT3, true, F::numbers},
                                    {"primvars:points:samples", ALABASTER_SAMPLES, false, F::samples},
                                    {"primvars:points:indices", ALABASTER_INT, true, F::few_ints},
                                    {"primvars:st", ALABASTER_FLOAT2, true, F::numbers},
                                    {"primvars:st:interpolation", ALABASTER_TOKEN, false, F::words},
                                    {"subsets:a:faces", ALABASTER_INT, true, F::few_ints},
                                    {"subsets:a:material", ALABASTER_PATH, false, F::words},
                                    {"creaseIndices", ALABASTER_INT, true, F::few_ints},
                                    {"creaseLengths", ALABASTER_INT, true, F::few_ints},
                                    {"cornerWeights", ALABASTER_FLOAT, true, F::numbers},
                                    {"transform", ALABASTER_MATRIX, false, F::numbers},
                                    {"transform:samples", ALABASTER_SAMPLES, false, F::samples},
                                    {"visible", ALABASTER_INT, false, F::few_ints},
                                    {"cullStyle", ALABASTER_STRING, false, F::words},
                                    {"material", ALABASTER_PATH, false, F::words},
                                    {"instancer", ALABASTER_PATH, false, F::words},
                                    {"renderTag", ALABASTER_TOKEN, false, F::words},
                                    {"categories", ALABASTER_TOKEN, true, F::words}};
inline constexpr F kInstancerFields[] = {
    {"primvars:hydra:instanceTranslations", ALABASTER_FLOAT3, true, F::numbers},
    {"primvars:hydra:instanceTranslations:samples", ALABASTER_SAMPLES, false, F::samples},
    {"primvars:hydra:instanceRotations", ALABASTER_QUATERNION, true, F::numbers},
    {"prototypes:/mesh", ALABASTER_INT, true, F::few_ints},
    {"prototypes:/many", ALABASTER_INT, true, F::few_ints},
    {"categories:a", ALABASTER_INT, true, F::few_ints},
    {"transform", ALABASTER_MATRIX, false, F::numbers},
    {"parent", ALABASTER_PATH, false, F::words}};
inline constexpr F kMaterialFields[] = {{"surface.type", ALABASTER_TOKEN, false, F::words},
                                        {"image.type", ALABASTER_STRING, false, F::words},
                                        {"surface.baseColor", ALABASTER_FLOAT3, false, F::numbers},
                                        {"surface.roughness", ALABASTER_FLOAT, false, F::numbers},
                                        {"surface.normal", ALABASTER_PATH, false, F::words},
                                        {"surface.baseColor", ALABASTER_PATH, true, F::words},
                                        {"image.file", ALABASTER_ASSET, false, F::words},
                                        {"surface", ALABASTER_TOKEN, false, F::words},
                                        {"displacement", ALABASTER_TOKEN, false, F::words}};
inline constexpr F kLightFields[] = {
    {"intensity", ALABASTER_FLOAT, false, F::numbers}, {"color", ALABASTER_FLOAT3, false, F::numbers},
    {"radius", ALABASTER_DOUBLE, false, F::numbers},   {"texture:file", ALABASTER_ASSET, false, F::words},
    {"lightLink", ALABASTER_TOKEN, false, F::words},   {"transform", ALABASTER_MATRIX, false, F::numbers},
    {"visible", ALABASTER_BOOL, false, F::few_ints}};
inline constexpr F kCameraFields[] = {{"focalLength", ALABASTER_FLOAT, false, F::numbers},
                                      {"fStop", ALABASTER_FLOAT, false, F::numbers},
                                      {"shutterOpen", ALABASTER_DOUBLE, false, F::numbers},
                                      {"shutterClose", ALABASTER_DOUBLE, false, F::numbers},
                                      {"projection", ALABASTER_TOKEN, false, F::words},
                                      {"clipPlanes", ALABASTER_FLOAT4, true, F::numbers},
                                      {"clippingRange", ALABASTER_FLOAT2, false, F::numbers},
                                      {"transform", ALABASTER_MATRIX, false, F::numbers},
                                      {"transform:samples", ALABASTER_SAMPLES, false, F::samples},
                                      {"fStop:samples", ALABASTER_SAMPLES, false, F::samples}};
inline constexpr F kSettingsFields[] = {{"camera", ALABASTER_PATH, false, F::words},
                                        {"width", ALABASTER_INT, false, F::few_ints},
                                        {"height", ALABASTER_INT, false, F::few_ints},
                                        {"pixelAspectRatio", ALABASTER_FLOAT, false, F::numbers},
                                        {"windowPolicy", ALABASTER_TOKEN, false, F::words},
                                        {"crop", ALABASTER_INT, true, F::few_ints},
                                        {"frame", ALABASTER_DOUBLE, false, F::numbers},
                                        {"includedPurposes", ALABASTER_TOKEN, true, F::words},
                                        {"samples", ALABASTER_INT, false, F::few_ints},
                                        {"products:0:file", ALABASTER_STRING, false, F::words},
                                        {"products:1:width", ALABASTER_INT, false, F::few_ints},
                                        {"products:0:vars:a", ALABASTER_TOKEN, false, F::words},
                                        {"products:0:vars:a:dataType", ALABASTER_TOKEN, false, F::words}};
inline constexpr Kind kKinds[] = {{"mesh", kMeshFields},         {"instancer", kInstancerFields},
                                  {"material", kMaterialFields}, {"sphereLight", kLightFields},
                                  {"camera", kCameraFields},     {"renderSettings", kSettingsFields}};

/// Whatever a call points at lives as long as this.
class CallArguments {
 public:
  explicit CallArguments(Bytes bytes) : in_(bytes) {
    for (auto& byte : memory_) byte = in_.byte();
  }
  virtual ~CallArguments() = default;
  CallArguments(const CallArguments&) = delete;
  CallArguments& operator=(const CallArguments&) = delete;

 protected:
  static constexpr int kSide = 4;
  /// An array has come back, in any thread.
  virtual void came_back() = 0;
  /// Aborts unless each array has come back once.
  void check_loans() const {
    for (const Loan& loan : loans_)
      if (loan.given_back != 1) broken("an array was given back " + std::to_string(loan.given_back) + " times");
  }

  template <class T>
  T* or_null(T* handle) {
    return in_.choice(12) == 11 ? nullptr : handle;
  }
  const char* text() {
    static constexpr const char* kTexts[] = {"/mesh",
                                             "/many",
                                             "/wax",
                                             "/lamp",
                                             "/camera",
                                             "/settings",
                                             "/settings/buffer_color",
                                             "",
                                             "mesh",
                                             "points",
                                             "normals",
                                             "st",
                                             "surface",
                                             "AlabasterDisney",
                                             "sphereLight",
                                             "domeLight",
                                             "catmullClark",
                                             "color",
                                             "primId",
                                             "samples",
                                             "intensity",
                                             "surface.baseColor",
                                             "ocio",
                                             "hydra:instanceTranslations",
                                             "dumpScene",
                                             "flush",
                                             "resumeCheckpoint"};
    const int at = in_.choice(static_cast<int>(std::size(kTexts)) + 1);
    return at == static_cast<int>(std::size(kTexts)) ? nullptr : kTexts[at];
  }
  /// A count for an array of `most`, with or without the array.
  template <class T>
  std::pair<const T*, size_t> items(const T* array, size_t most) {
    const size_t count = static_cast<size_t>(in_.choice(static_cast<int>(most) + 1));
    return {in_.choice(8) == 7 ? nullptr : array, count};
  }
  template <class T>
  T sized() {
    T made = {};
    static constexpr size_t kWrong[] = {0, 1, 4, 8, 12, sizeof(T) - 1, sizeof(T) - 4, sizeof(T) + 3};
    made.size = in_.choice(8) == 7 ? kWrong[in_.choice(static_cast<int>(std::size(kWrong)))] : sizeof(T);
    if (in_.choice(32) == 31) made.size += 64;
    return made;
  }
  /// A value of any type. Samples stand within samples to a small depth, which is an error.
  AlabasterValue value(int depth = 0) {
    constexpr int kTypes = 30, kDeepest = 2;
    const int32_t type = in_.choice(kTypes), is_array = in_.choice(3);
    if (type == ALABASTER_SAMPLES) return depth < kDeepest ? samples(depth) : AlabasterValue{};
    AlabasterValue made = of_type(type, is_array);
    if (in_.choice(10) == 9) made.data = nullptr;
    if (in_.choice(40) == 39) made.type = ALABASTER_DOUBLE, made.is_array = 1, made.count = ~size_t(0) / 4;
    return lent_or_not(made);
  }
  AlabasterValue samples(int depth = 0) {
    AlabasterValue made = {ALABASTER_SAMPLES, ALABASTER_SCALAR, nullptr, 2, nullptr, nullptr};
    if (in_.choice(8) == 7) return lent_or_not(made);
    made.data = keep(&samples_, {AlabasterSample{0, value(depth + 1)}, {1, value(depth + 1)}}).data();
    return lent_or_not(made);
  }
  AlabasterValue of_type(int32_t type, int32_t is_array) {
    constexpr int kMost = 8;
    AlabasterValue made = {};
    made.type = type, made.is_array = is_array;
    made.count = static_cast<size_t>(in_.choice(kMost + 1));
    const bool is_text = made.type >= ALABASTER_TOKEN && made.type <= ALABASTER_ASSET;
    made.data = memory_.data() + (in_.flag() ? 0 : 8);
    if (made.type == ALABASTER_BOOL) made.data = kBools;
    if (is_text && made.is_array) made.data = kNames;
    if (is_text && !made.is_array) made.data = kNames[in_.choice(static_cast<int>(std::size(kNames)))];
    return made;
  }
  AlabasterValue lent_or_not(AlabasterValue made) {
    if (!in_.flag()) return made;
    loans_.emplace_back().lender = this;
    made.release = &CallArguments::give_back, made.owner = &loans_.back();
    return made;
  }
  AlabasterParameter field(std::span<const FieldOfKind> of_kind) {
    if (in_.choice(12) == 11) return {text(), value()};
    const FieldOfKind& field = of_kind[static_cast<size_t>(in_.choice(static_cast<int>(of_kind.size())))];
    if (in_.choice(8) == 7) return {field.name, value()};
    if (field.takes == FieldOfKind::samples) return {field.name, samples()};
    AlabasterValue made = of_type(field.type, field.is_array ? ALABASTER_ARRAY : ALABASTER_SCALAR);
    if (field.takes == FieldOfKind::few_ints && field.type == ALABASTER_INT)
      made.data = kFewInts + in_.choice(static_cast<int>(std::size(kFewInts)) / 2);
    return {field.name, lent_or_not(made)};
  }
  std::pair<const AlabasterParameter*, size_t> fields(std::span<const FieldOfKind> of_kind) {
    if (in_.choice(16) == 15) return {nullptr, static_cast<size_t>(in_.choice(3))};
    std::vector<AlabasterParameter>& made = keep(&fields_, {});
    for (int left = in_.choice(9); left > 0; --left) made.push_back(field(of_kind));
    return {made.data(), made.size()};
  }
  std::pair<const AlabasterParameter*, size_t> parameters() {
    if (in_.choice(8) == 7) return {nullptr, static_cast<size_t>(in_.choice(3))};
    auto& made = keep(&fields_, {{text(), value()}, {text(), value()}});
    return {made.data(), made.size()};
  }
  template <class T>
  T& keep(std::deque<T>* in, T value) {
    in->push_back(std::move(value));
    return in->back();
  }

  AlabasterFrame frame(AlabasterBuffer* buffer) {
    auto made = sized<AlabasterFrame>();
    auto& binding = keep(&bindings_, {text(), buffer});
    std::tie(made.bindings, made.binding_count) = items(&binding, 1);
    made.settings = in_.choice(4) == 3 ? text() : nullptr;
    made.camera = in_.choice(4) == 3 ? text() : "/camera";
    made.width = made.height = in_.choice(8) == 7 ? in_.raw<int32_t>() : kSide;
    made.window_policy = in_.choice(6);
    made.render_tags = value(), made.roots = value(), made.excluded = value();
    if (in_.choice(3) == 2) std::tie(made.free_camera, made.free_camera_count) = fields(kCameraFields);
    return made;
  }
  StructuredInput in_;

 private:
  /// An array that has been lent.
  struct Loan {
    CallArguments* lender = nullptr;
    std::atomic<int> given_back{0};
  };
  static void give_back(void* owner) {
    Loan& loan = *static_cast<Loan*>(owner);
    ++loan.given_back;
    loan.lender->came_back();
  }

  static constexpr int32_t kFewInts[] = {0, 1, 2, 3, 4, 4, -1, 3, 2, 1, 0, 9, 0, 70000, 1, 2};
  static constexpr bool kBools[8] = {true, false, true};
  static constexpr const char* kNames[] = {
      "/mesh",   "proxy",    "",  "render",       "/many",           "geometry",
      nullptr,   "/wax",     "a", "catmullClark", "AlabasterDisney", "AlabasterTexture",
      "surface", "image.rgb"};

  alignas(16) std::array<uint8_t, 2048> memory_;
  std::deque<Loan> loans_;
  std::deque<std::array<AlabasterSample, 2>> samples_;
  std::deque<std::vector<AlabasterParameter>> fields_;
  std::deque<AlabasterBinding> bindings_;
};

}  // namespace alabaster::fuzz
