// The parts that a snapshot is without because memory ran out while it was compiled.
#pragma once

#include <map>
#include <new>
#include <string>
#include <utility>
#include <vector>

#include "core/diagnostics/report.h"

namespace alabaster {

enum class LackKind {
  instance,   // it is left out
  set,        // it is left out with its subsurfaceSet
  light,      // it is left out
  sampling,   // a mesh that emits is met by paths alone: the same picture, with more noise
  shortcuts,  // walks below the surface take no sphere steps: the same picture, in more time
};

/// False: the picture is the same but for its noise.
constexpr bool changes_picture(LackKind kind) {
  return kind != LackKind::sampling && kind != LackKind::shortcuts;
}

/// There is one for each prim and kind.
struct MemoryLack {
  LackKind kind;
  std::string name;  // prim path
  size_t count;      // of its instances
  bool operator==(const MemoryLack&) const = default;
};

/// "/prim: memory ran out: the instance is left out".
std::string text_of(const MemoryLack& lack);

/// Collects them while a snapshot is compiled.
class MemoryLacks {
 public:
  /// A step that concerns `count` instances of a prim.
  struct Concern {
    LackKind kind;
    const std::string& name;
    const void* shape = nullptr;  // shared by several prims, which then have one report; null: the prim's own
    size_t count = 1;
  };
  /// Runs a step. False: memory ran out in it.
  template <class Step>
  bool has_memory_for(const Concern& of, const Step& step) {
    try {
      step();
      return true;
    } catch (const std::bad_alloc& e) {
      add(of, reason_of(e));
    }
    return false;
  }
  void add(const Concern& of, const std::string& reason);
  /// With the remedy.
  static std::string reason_of(const std::bad_alloc& e);

  /// In the order in which they were found; for each shape, or each prim, one. Those that leave the picture as it is
  /// are warnings, the others errors.
  std::vector<Diagnostic> reports() const;
  /// In the order of prims and kinds.
  std::vector<MemoryLack> all() const;

 private:
  struct Reported {
    LackKind kind;
    std::string first, reason;  // of the first instance
    size_t count;
  };
  std::vector<Reported> reported_;
  std::map<std::pair<LackKind, const void*>, size_t> of_shape_;  // in reported_
  std::map<std::pair<std::string, LackKind>, size_t> counts_;    // of instances
};

}  // namespace alabaster
