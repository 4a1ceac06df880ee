// Reads numbers and choices from the bytes of a fuzzer. When they end, everything is zero.
#pragma once

#include <cmath>
#include <cstring>
#include <limits>
#include <string>

#include "testenv/fuzz/fuzz_target.h"

namespace alabaster::fuzz {

class StructuredInput {
 public:
  explicit StructuredInput(Bytes bytes) : left_(bytes) {}

  bool empty() const { return left_.empty(); }
  uint8_t byte() {
    if (left_.empty()) return 0;
    const uint8_t value = left_[0];
    left_ = left_.subspan(1);
    return value;
  }
  bool flag() { return (byte() & 1) != 0; }
  /// One of 0 .. count - 1.
  int choice(int count) { return byte() % count; }
  template <class T>
  T raw() {
    T value{};
    const size_t size = std::min(sizeof value, left_.size());
    std::memcpy(&value, left_.data(), size);
    left_ = left_.subspan(size);
    return value;
  }
  /// An extreme, a small number, one within 0 and 1, or any bits.
  float number() {
    constexpr float kExtremes[] = {0,
                                   -0.0f,
                                   1,
                                   -1,
                                   std::numeric_limits<float>::max(),
                                   std::numeric_limits<float>::lowest(),
                                   std::numeric_limits<float>::min(),
                                   std::numeric_limits<float>::denorm_min(),
                                   std::numeric_limits<float>::epsilon(),
                                   std::numeric_limits<float>::infinity(),
                                   -std::numeric_limits<float>::infinity(),
                                   std::numeric_limits<float>::quiet_NaN(),
                                   1e18f,
                                   1e-18f,
                                   1 + std::numeric_limits<float>::epsilon(),
                                   1e30f};
    switch (choice(4)) {
      case 0:
        return kExtremes[choice(std::size(kExtremes))];
      case 1:
        return static_cast<float>(choice(255)) - 127;
      case 2:
        return static_cast<float>(byte()) / 255;
      default:
        return raw<float>();
    }
  }
  std::string text(size_t size) {
    size = std::min(size, left_.size());
    std::string value(reinterpret_cast<const char*>(left_.data()), size);
    left_ = left_.subspan(size);
    return value;
  }

 private:
  Bytes left_;
};

}  // namespace alabaster::fuzz
