// Arguments of calls of the C interface, right and wrong ones: nulls, sizes that no header has, counts without arrays,
// values of any type. Arrays are lent now and then, and it is counted how often each comes back.
#pragma once

#include <array>
#include <atomic>
#include <deque>
#include <tuple>
#include <utility>

#include "delegate/c_api/alabaster.h"
#include "testenv/fuzz/small_render.h"
#include "testenv/fuzz/structured_input.h"

namespace alabaster::fuzz {

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
  AlabasterValue value() {
    constexpr int kTypes = 29, kMost = 8;
    AlabasterValue made = {};
    made.type = in_.choice(kTypes), made.is_array = in_.choice(3);
    made.count = static_cast<size_t>(in_.choice(kMost + 1));
    const bool is_text = made.type >= ALABASTER_TOKEN && made.type <= ALABASTER_ASSET;
    made.data = memory_.data() + (in_.flag() ? 0 : 8);
    if (made.type == ALABASTER_BOOL) made.data = kBools;
    if (is_text && made.is_array) made.data = kNames;
    if (is_text && !made.is_array) made.data = kNames[made.count % std::size(kNames)];
    if (in_.choice(10) == 9) made.data = nullptr;
    if (in_.choice(40) == 39) made.type = ALABASTER_DOUBLE, made.is_array = 1, made.count = ~size_t(0) / 4;
    if (in_.flag()) {
      loans_.emplace_back().lender = this;
      made.release = &CallArguments::give_back, made.owner = &loans_.back();
    }
    return made;
  }
  AlabasterMotion motion() {
    AlabasterMotion made = {};
    if (in_.choice(4) != 3) return made;
    auto& values = keep(&values_, {value(), value()});
    static constexpr double kTimes[] = {0, 1};
    made.times = in_.choice(8) == 7 ? nullptr : kTimes, made.values = values.data(), made.count = 2;
    return made;
  }
  AlabasterPrimvar primvar() { return {text(), text(), in_.choice(7), value(), value(), motion()}; }
  std::pair<const AlabasterPrimvar*, size_t> primvars() {
    if (in_.choice(8) == 7) return {nullptr, static_cast<size_t>(in_.choice(3))};
    auto& made = keep(&primvars_, {primvar(), primvar()});
    return {made.data(), made.size()};
  }
  std::pair<const AlabasterParameter*, size_t> parameters() {
    if (in_.choice(8) == 7) return {nullptr, static_cast<size_t>(in_.choice(3))};
    auto& made = keep(&parameters_, {{{text(), value()}, {text(), value()}}});
    return {made.data(), made.size()};
  }
  const double* matrix() { return in_.choice(4) == 3 ? nullptr : reinterpret_cast<const double*>(memory_.data()); }
  template <class T>
  T& keep(std::deque<T>* in, T value) {
    in->push_back(std::move(value));
    return in->back();
  }

  AlabasterMesh mesh() {
    auto made = sized<AlabasterMesh>();
    made.scheme = text(), made.orientation = text();
    made.face_vertex_counts = value(), made.face_vertex_indices = value(), made.hole_indices = value();
    std::tie(made.primvars, made.primvar_count) = primvars();
    auto& subset = keep(&subsets_, {text(), text(), value()});
    made.subsets = &subset, made.subset_count = 1;
    auto tags = sized<AlabasterSubdivTags>();
    tags.crease_indices = value(), tags.corner_weights = value();
    made.subdiv_tags = &keep(&tags_, tags);
    made.refine_level = in_.choice(3), made.transform = matrix();
    made.material = text(), made.instancer = text();
    made.motion = motion();
    // The first version did not have these: of a struct whose size is wrong they are not looked at.
    if (made.size < sizeof made || made.size % alignof(AlabasterMesh) != 0) return made;
    made.categories = value(), made.invisible_faces = value(), made.cull_style = in_.choice(7);
    return made;
  }
  AlabasterFrame frame(AlabasterBuffer* buffer) {
    auto made = sized<AlabasterFrame>();
    auto& binding = keep(&bindings_, {text(), buffer});
    std::tie(made.bindings, made.binding_count) = items(&binding, 1);
    made.settings = in_.choice(4) == 3 ? text() : nullptr;
    made.camera = in_.choice(4) == 3 ? text() : "/camera";
    made.width = made.height = in_.choice(8) == 7 ? in_.raw<int32_t>() : kSide;
    made.window_policy = in_.choice(6);
    if (made.size < sizeof made || made.size % alignof(AlabasterFrame) != 0) return made;
    made.render_tags = value(), made.roots = value(), made.excluded = value();
    if (in_.choice(3) == 2) made.free_camera = &keep(&cameras_, camera());
    return made;
  }
  AlabasterCamera camera() {
    auto made = sized<AlabasterCamera>();
    made.transform = matrix();
    std::tie(made.parameters, made.parameter_count) = parameters();
    made.motion = motion();
    return made;
  }
  AlabasterInstancer instancer() {
    auto made = sized<AlabasterInstancer>();
    std::tie(made.primvars, made.primvar_count) = primvars();
    auto& prototype = keep(&prototypes_, {text(), value()});
    made.prototypes = &prototype, made.prototype_count = 1;
    made.transform = matrix(), made.parent = text(), made.motion = motion();
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

  static constexpr bool kBools[8] = {true, false, true};
  static constexpr const char* kNames[] = {"/mesh", "proxy", "", "render", "/many", "geometry", nullptr, "/wax", "a"};

  alignas(16) std::array<uint8_t, 2048> memory_;
  std::deque<Loan> loans_;
  std::deque<std::array<AlabasterValue, 2>> values_;
  std::deque<std::array<AlabasterParameter, 2>> parameters_;
  std::deque<std::array<AlabasterPrimvar, 2>> primvars_;
  std::deque<AlabasterSubset> subsets_;
  std::deque<AlabasterSubdivTags> tags_;
  std::deque<AlabasterPrototype> prototypes_;
  std::deque<AlabasterBinding> bindings_;
  std::deque<AlabasterCamera> cameras_;
};

}  // namespace alabaster::fuzz
