#include "core/scene/memory_lacks.h"

#include "core/memory/memory_budget.h"

namespace alabaster {
namespace {

struct KindText {
  const char *code, *one, *many;  // `many` follows the number of instances
};
// By LackKind.
constexpr KindText kKinds[] = {
    {"instance.memory", "the instance is left out", "instances of this mesh are left out"},
    {"instance.memory", "the instance is left out with its subsurfaceSet",
     "instances are left out with their subsurfaceSet"},
    {"light.memory", "the light is left out", "lights are left out"},
    {"light.memory", "the mesh emits, but is not sampled as a light, and its light is noisier",
     "instances of this mesh emit, but are not sampled as lights, and their light is noisier"},
    {"subsurface.memory", "walks below its surface take no sphere steps, and render slower",
     "instances scatter light by walks without sphere steps, and render slower"},
};
const KindText& kind_text(LackKind kind) {
  return kKinds[static_cast<size_t>(kind)];
}
std::string outcome_of(LackKind kind, size_t count) {
  return count == 1 ? kind_text(kind).one : std::to_string(count) + " " + kind_text(kind).many;
}

}  // namespace

std::string text_of(const MemoryLack& lack) {
  return lack.name + ": memory ran out: " + outcome_of(lack.kind, lack.count);
}

std::string MemoryLacks::reason_of(const std::bad_alloc& e) {
  const auto* const refused = dynamic_cast<const MemoryRefused*>(&e);
  if (refused) return refused->what();
  return "not enough memory (lower refineLevel, make images smaller, or free memory of other programs)";
}

void MemoryLacks::add(const Concern& of, const std::string& reason) {
  counts_[{of.name, of.kind}] += of.count;
  if (of.shape) {
    const auto [at, is_new] = of_shape_.try_emplace({of.kind, of.shape}, reported_.size());
    if (!is_new) {
      reported_[at->second].count += of.count;
      return;
    }
  }
  reported_.push_back({of.kind, of.name, reason, of.count});
}

std::vector<Diagnostic> MemoryLacks::reports() const {
  std::vector<Diagnostic> reports;
  for (const Reported& lack : reported_)
    reports.push_back({changes_picture(lack.kind) ? Severity::error : Severity::warning, kind_text(lack.kind).code,
                       lack.first,
                       lack.reason + ": " + outcome_of(lack.kind, lack.count) + "; the next commit tries again"});
  return reports;
}

std::vector<MemoryLack> MemoryLacks::all() const {
  std::vector<MemoryLack> all;
  for (const auto& [prim, count] : counts_) all.push_back({prim.second, prim.first, count});
  return all;
}

}  // namespace alabaster
