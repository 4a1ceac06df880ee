// Digests that tell contents apart, and checksums that find damage. The only room that sees xxHash.
#pragma once

#include <concepts>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <type_traits>
#include <vector>

namespace alabaster {

/// Numbers, vectors, matrices and structs of them, without padding. Imath's are not trivially copyable, though they
/// could be.
template <class T>
concept PlainValue = std::is_trivially_destructible_v<T> && std::is_standard_layout_v<T> && !std::is_pointer_v<T>;

/// 128 bits of everything that was added, in order (XXH3; Collet 2020). Not for secrets: who wants to can make two
/// contents with one digest.
class Digest {
 public:
  Digest();
  ~Digest();
  Digest(const Digest&) = delete;
  Digest& operator=(const Digest&) = delete;

  void add_bytes(std::span<const std::byte> bytes);
  template <PlainValue T>
  void add(const T& value) {
    add_bytes(std::as_bytes(std::span(&value, 1)));
  }
  /// Their number first, so that neighbours do not run into each other.
  template <PlainValue T>
  void add_array(const T* values, size_t count) {
    add(count);
    add_bytes(std::as_bytes(std::span(values, count)));
  }
  template <PlainValue T>
  void add(const std::vector<T>& values) {
    add_array(values.data(), values.size());
  }
  void add(const std::string& text) { add_array(text.data(), text.size()); }

  /// 32 hexadecimal digits.
  std::string text() const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

/// Sums up a block of bytes. `number`: its place among its neighbours, so that blocks in another order are found.
uint64_t checksum(std::span<const std::byte> bytes, uint64_t number);

}  // namespace alabaster
