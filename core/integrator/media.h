// The interiors of clear bodies that a ray is in: a small stack that a path carries through nested and overlapping
// dielectrics (Schmidt and Budge 2002, "Simple Nested Dielectrics in Ray Traced Images").
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <memory>
#include <type_traits>
#include <vector>

#include "core/color/rgb.h"
#include "core/math/elementary.h"
#include "core/math/vector.h"

namespace alabaster {

/// A stack, of which the first few need no memory of their own. A copy costs what is on it.
template <class T>
class SmallStack {
 public:
  static_assert(std::is_trivially_copyable_v<T>);
  SmallStack() {}
  SmallStack(const SmallStack& o) { *this = o; }
  SmallStack& operator=(const SmallStack& o) {
    if (this == &o) return *this;
    size_ = o.size_;
    std::memcpy(few_, o.few_, sizeof(T) * std::min(size_, kFew));
    if (o.more_ || more_) [[unlikely]]
      more_ = o.more_ ? std::make_unique<std::vector<T>>(*o.more_) : nullptr;
    return *this;
  }

  uint32_t size() const { return size_; }
  const T& operator[](uint32_t i) const { return i < kFew ? reinterpret_cast<const T*>(few_)[i] : (*more_)[i - kFew]; }
  void push(const T& item) {
    if (size_ >= kFew) [[unlikely]] {
      if (!more_) more_ = std::make_unique<std::vector<T>>();
      more_->resize(size_ - kFew);
      more_->push_back(item);
    } else {
      std::memcpy(few_ + sizeof(T) * size_, &item, sizeof(T));
    }
    ++size_;
  }
  /// The others keep their order.
  void erase(uint32_t i) {
    --size_;
    for (; i < size_; ++i) at(i) = at(i + 1);
  }

 private:
  static constexpr uint32_t kFew = 8;
  T& at(uint32_t i) { return const_cast<T&>((*this)[i]); }

  alignas(T) std::byte few_[sizeof(T) * kFew];
  uint32_t size_ = 0;
  std::unique_ptr<std::vector<T>> more_;
};

struct Interior {
  uint32_t instance = 0;
  uint64_t priority = 0;  // of two that overlap, the body of the higher one is there: interior_priority()
  float ior = 1;
  float spread = 0;            // of ior, between one channel and the next
  Rgb sigma_a{0.0f};           // absorption per world distance
  bool index_matched = false;  // diffuse light alone passes its surface: it has the index of the medium around it
  bool scatters = false;       // light walks in it
  bool occupied = false;       // and something stands in it: SubsurfaceBody::occupied

  /// Index of refraction for a channel: red light is refracted least.
  float index(int channel) const { return ior + static_cast<float>(channel - 1) * spread; }
  bool operator==(const Interior&) const = default;
};

class MediumStack {
 public:
  bool empty() const { return size() == 0; }
  bool contains(uint32_t instance) const { return find(instance) < size(); }
  /// How often it has been entered: shells of one mesh may overlap.
  uint32_t count(uint32_t instance) const {
    uint32_t count = 0;
    for (uint32_t i = 0; i < size(); ++i) count += stack_[i].instance == instance;
    return count;
  }
  /// True if both hold the same interiors, in any order, and the same one is current.
  bool agrees_with(const MediumStack& other) const {
    if (size() != other.size()) return false;
    for (uint32_t i = 0; i < size(); ++i) {
      const uint32_t at = other.find(stack_[i].instance);
      if (at == size() || other.stack_[at] != stack_[i]) return false;
    }
    return empty() || *current() == *other.current();
  }

  /// The interior of the highest priority; null in air. `instance`: as if it had been left.
  const Interior* current() const { return best(size()); }
  const Interior* current_without(uint32_t instance) const { return best(find(instance)); }

  /// Index of refraction of the current one; for all channels that of green.
  float index(int channel = 1) const {
    const Interior* const at = current();
    return at ? at->index(channel) : 1;
  }

  /// index() of each channel.
  Rgb indices() const {
    const Interior* const at = current();
    return at ? Rgb(at->index(0), at->index(1), at->index(2)) : Rgb(1.0f);
  }

  /// Beer and Lambert's law. An infinite distance tells of a body that is not closed, and of none.
  Rgb transmittance(float distance) const {
    const Interior* const at = current();
    if (!at || is_black(at->sigma_a) || std::isinf(distance)) return Rgb(1.0f);
    return {quick_exp(-at->sigma_a.r * distance), quick_exp(-at->sigma_a.g * distance),
            quick_exp(-at->sigma_a.b * distance)};
  }

  uint32_t size() const { return stack_.size(); }
  const Interior& operator[](uint32_t i) const { return stack_[i]; }

  /// One that is index-matched takes the index of the current one.
  void enter(Interior interior) {
    const Interior* const around = interior.index_matched ? current() : nullptr;
    if (interior.index_matched) interior.ior = around ? around->ior : 1, interior.spread = around ? around->spread : 0;
    stack_.push(interior);
  }
  /// Where the ray was not in it, nothing happens.
  void leave(uint32_t instance) {
    const uint32_t at = find(instance);
    if (at < size()) stack_.erase(at);
  }

 private:
  /// The last that was entered of this instance; size(): none.
  uint32_t find(uint32_t instance) const {
    for (uint32_t i = size(); i > 0; --i)
      if (stack_[i - 1].instance == instance) return i - 1;
    return size();
  }
  const Interior* best(uint32_t left_out) const {
    const Interior* best = nullptr;
    for (uint32_t i = 0; i < size(); ++i)
      if (i != left_out && (!best || stack_[i].priority >= best->priority)) best = &stack_[i];
    return best;
  }

  SmallStack<Interior> stack_;
};

/// Factor of a path's throughput where it goes from index `from` to index `to` by lobes without an index of their own:
/// radiance over the squared index is conserved (Veach 1997, section 5.2).
inline Rgb index_factor(const Rgb& from, const Rgb& to) {
  return {sqr(from.r / to.r), sqr(from.g / to.g), sqr(from.b / to.b)};
}

/// The closed bodies in which a path is in air, because it passed their surface at a hole. A body counts once for each
/// of its shells that the path is in.
class AirPockets {
 public:
  bool empty() const { return size() == 0; }
  bool contains(uint32_t instance) const { return find(instance) < size(); }
  void enter(uint32_t instance) { stack_.push(instance); }
  /// Does nothing if the path is not in it.
  void leave(uint32_t instance) {
    const uint32_t at = find(instance);
    if (at < size()) stack_.erase(at);
  }
  uint32_t operator[](uint32_t i) const { return stack_[i]; }
  uint32_t size() const { return stack_.size(); }

 private:
  uint32_t find(uint32_t instance) const {
    uint32_t i = 0;
    while (i < size() && stack_[i] != instance) ++i;
    return i;
  }

  SmallStack<uint32_t> stack_;
};

}  // namespace alabaster
