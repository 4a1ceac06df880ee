// Values that cross the contract. Vectors, matrices and quaternions are Imath's (row-vector matrices, p' = p * M).
// Nothing here throws; a Value asked for a type it does not hold answers with null or the given default.
#pragma once

#include <ImathMatrix.h>
#include <ImathQuat.h>
#include <ImathVec.h>
#include <half.h>

#include <array>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <string>
#include <string_view>
#include <utility>
#include <variant>
#include <vector>

#include "delegate/api/export.h"

namespace alabaster::hd {

using Half = Imath::half;
using Vec2f = Imath::V2f;
using Vec3f = Imath::V3f;
using Vec4f = Imath::V4f;
using Vec2i = Imath::V2i;
using Vec3i = Imath::V3i;
using Vec2d = Imath::V2d;
using Vec3d = Imath::V3d;
using Vec4d = Imath::V4d;
using Vec2h = Imath::Vec2<Half>;
using Vec3h = Imath::Vec3<Half>;
using Vec4h = Imath::Vec4<Half>;
using Matrix4d = Imath::M44d;
using Quatf = Imath::Quatf;
using Quath = Imath::Quat<Half>;

/// An interned string: copies and comparisons cost a pointer. Interned strings live as long as the library.
class ALABASTER_API Token {
 public:
  Token() = default;
  Token(const char* text) : Token(std::string_view(text)) {}         // NOLINT(google-explicit-constructor)
  Token(const std::string& text) : Token(std::string_view(text)) {}  // NOLINT(google-explicit-constructor)
  explicit Token(std::string_view text);
  const std::string& str() const;
  bool empty() const { return rep_ == nullptr; }
  bool operator==(const Token& o) const { return rep_ == o.rep_; }
  /// Lexicographic: the same order in every run.
  bool operator<(const Token& o) const { return rep_ != o.rep_ && str() < o.str(); }
  size_t hash() const { return std::hash<const void*>()(rep_); }

 private:
  const std::string* rep_ = nullptr;
};

/// An interned, opaque prim id. Only equality and order are asked of it; '/'-separated by custom.
class ALABASTER_API Path {
 public:
  Path() = default;
  Path(const char* text) : token_(text) {}         // NOLINT(google-explicit-constructor)
  Path(const std::string& text) : token_(text) {}  // NOLINT(google-explicit-constructor)
  const std::string& str() const { return token_.str(); }
  bool empty() const { return token_.empty(); }
  Path append(const std::string& name) const { return Path(str() == "/" ? "/" + name : str() + "/" + name); }
  bool operator==(const Path& o) const { return token_ == o.token_; }
  bool operator<(const Path& o) const { return token_ < o.token_; }
  size_t hash() const { return token_.hash(); }

 private:
  Token token_;
};

/// An array that may be shared: it either owns its elements or holds the host's own memory by an owner handle. Two
/// arrays over the same memory count as equal if their versions are, and are not looked into.
template <class T>
class Array {
 public:
  Array() = default;
  Array(std::vector<T> values) {  // NOLINT(google-explicit-constructor)
    if constexpr (std::is_same_v<T, bool>) {
      auto held = std::make_shared<bool[]>(values.size());
      std::copy(values.begin(), values.end(), held.get());
      data_ = held.get();
      size_ = values.size();
      owner_ = std::move(held);
    } else {
      auto held = std::make_shared<const std::vector<T>>(std::move(values));
      data_ = held->data();
      size_ = held->size();
      owner_ = std::move(held);
    }
  }
  Array(std::initializer_list<T> values) : Array(std::vector<T>(values)) {}
  /// Memory of the host's, valid for as long as `owner` lives. Version 0: it never changes, and is not copied. Any
  /// other version: the host edits it in place, outside of Sync, and gives the array another version after each edit.
  /// Such memory is read by prims in Sync, which copy it, and by nobody else.
  Array(std::shared_ptr<const void> owner, const T* data, size_t size, uint64_t version = 0)
      : owner_(std::move(owner)), data_(data), size_(size), version_(version) {}

  const T* data() const { return data_; }
  size_t size() const { return size_; }
  bool empty() const { return size_ == 0; }
  const T& operator[](size_t i) const { return data_[i]; }
  const T* begin() const { return data_; }
  const T* end() const { return data_ + size_; }
  uint64_t version() const { return version_; }
  /// Itself, or a copy of memory that the host edits in place.
  Array frozen() const { return version_ == 0 ? *this : Array(std::vector<T>(begin(), end())); }
  /// Memory that the host edits in place cannot be compared with its values of before: other memory counts as changed.
  bool operator==(const Array& o) const {
    if (size_ != o.size_) return false;
    if (data_ == o.data_) return version_ == o.version_;
    if (version_ != 0 || o.version_ != 0) return size_ == 0;
    for (size_t i = 0; i < size_; ++i)
      if (!(data_[i] == o.data_[i])) return false;
    return true;
  }

 private:
  std::shared_ptr<const void> owner_;
  const T* data_ = nullptr;
  size_t size_ = 0;
  uint64_t version_ = 0;
};

/// An asset as authored and as found on disk; or, when `bytes` is set, encoded contents held in memory (an image
/// embedded in a scene file) and `authored` its name for reports.
struct AssetPath {
  std::string authored;
  std::string resolved;
  std::shared_ptr<const std::vector<uint8_t>> bytes;
  /// The real path of a folder that the file must lie in or below when it is opened, symbolic links followed: that of
  /// the untrusted file that names it. Empty: anywhere.
  std::string within = {};
  bool operator==(const AssetPath&) const = default;
};

class Value;
using Dictionary = std::map<std::string, Value>;

/// One of a closed set of types.
class ALABASTER_API Value {
 public:
  using Storage =
      std::variant<std::monostate, bool, int32_t, int64_t, uint32_t, float, double, Vec2f, Vec3f, Vec4f, Vec2i, Vec3i,
                   Vec3d, Quatf, Matrix4d, Token, std::string, Path, AssetPath, std::shared_ptr<const Dictionary>,
                   Array<int32_t>, Array<float>, Array<double>, Array<Vec2f>, Array<Vec3f>, Array<Vec4f>, Array<Quatf>,
                   Array<Matrix4d>, Array<Token>, Array<std::string>, Half, Vec2d, Vec4d, Vec2h, Vec3h, Vec4h,
                   Array<bool>, Array<int64_t>, Array<uint32_t>, Array<Half>, Array<Vec2i>, Array<Vec3i>, Array<Vec2d>,
                   Array<Vec3d>, Array<Vec4d>, Array<Vec2h>, Array<Vec3h>, Array<Vec4h>, Array<Quath>, Array<Path>>;
  template <class T, class... Types>
  static constexpr bool is_one_of(const std::variant<Types...>*) {
    return (std::is_same_v<T, Types> || ...);
  }
  template <class T>
  static constexpr bool kIsAlternative = is_one_of<T>(static_cast<Storage*>(nullptr));
  /// No other number becomes a Half by itself.
  template <class T>
  static constexpr bool kIsNarrowed =
      std::is_arithmetic_v<T> &&
      !std::is_constructible_v<std::variant<bool, int32_t, int64_t, uint32_t, float, double>, T>;
  Value();
  // In the library: these of a variant of fifty types would be half of what a file that includes this takes to compile.
  Value(const Value& o);
  Value(Value&& o) noexcept;
  Value& operator=(const Value& o);
  Value& operator=(Value&& o) noexcept;
  ~Value();
  template <class T>
  requires(kIsAlternative<T>) Value(T value)  // NOLINT(google-explicit-constructor)
      : storage_(std::in_place_type<T>, std::move(value)) {}
  /// Takes what converts to just one of the types.
  template <class T>
  requires(!kIsAlternative<T> && !std::is_same_v<T, Value> && std::is_constructible_v<Storage, T> && !kIsNarrowed<T>)
      Value(T value)  // NOLINT(google-explicit-constructor)
      : storage_(std::move(value)) {}
  Value(const char* text) : storage_(std::string(text)) {}  // NOLINT(google-explicit-constructor)

  bool empty() const { return std::holds_alternative<std::monostate>(storage_); }
  template <class T>
  const T* get() const {
    return std::get_if<T>(&storage_);
  }
  template <class T>
  T get_or(T fallback) const {
    const T* held = get<T>();
    return held ? *held : std::move(fallback);
  }
  /// Any arithmetic alternative, and half, as double; `fallback` for the rest.
  double number_or(double fallback) const;
  /// The components of a vector, or one number. Returns how many: 0 for the rest.
  size_t components(std::array<double, 4>* out) const;
  /// Without memory that the host edits in place: see Array::frozen().
  Value frozen() const;
  /// Token, string, path or asset path as text; `fallback` for the rest.
  std::string text_or(std::string fallback) const;
  /// Stable text for dumps and messages: a float is the shortest decimal that reads back as the same float.
  std::string to_string() const;
  bool operator==(const Value& o) const;
  const Storage& storage() const { return storage_; }

 private:
  Storage storage_;
};

enum class Severity { info, warning, error };
struct Diagnostic {
  Severity severity = Severity::info;
  std::string code;   // stable: "mesh.points.short"
  std::string where;  // prim path, file, element
  std::string text;   // what is wrong, and the remedy
};
/// Called from a thread of the host's or of ours, never under a lock of ours; must not call back into the delegate.
using DiagnosticSink = std::function<void(const Diagnostic&)>;

}  // namespace alabaster::hd
