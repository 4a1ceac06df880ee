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
#include <tuple>
#include <utility>
#include <variant>
#include <vector>

#include "delegate/api/export.h"
#include "delegate/api/value_type.h"

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

/// The memory of an Array, whatever its elements are.
class ArrayMemory {
 public:
  size_t size() const { return size_; }
  bool empty() const { return size_ == 0; }
  uint64_t version() const { return version_; }

 protected:
  ArrayMemory() = default;
  ArrayMemory(std::shared_ptr<const void> owner, const void* data, size_t size, uint64_t version)
      : owner_(std::move(owner)), data_(data), size_(size), version_(version) {}
  std::shared_ptr<const void> owner_;
  const void* data_ = nullptr;
  size_t size_ = 0;
  uint64_t version_ = 0;
  friend class Value;
};

/// An array that may be shared: it either owns its elements or holds the host's own memory by an owner handle. Two
/// arrays over the same memory count as equal if their versions are, and are not looked into.
template <class T>
class Array : public ArrayMemory {
 public:
  Array() = default;
  Array(std::vector<T> values) {  // NOLINT(google-explicit-constructor)
    size_ = values.size();
    if constexpr (std::is_same_v<T, bool>) {
      auto held = std::make_shared<bool[]>(values.size());
      std::copy(values.begin(), values.end(), held.get());
      data_ = held.get();
      owner_ = std::move(held);
    } else {
      auto held = std::make_shared<const std::vector<T>>(std::move(values));
      data_ = held->data();
      owner_ = std::move(held);
    }
  }
  Array(std::initializer_list<T> values) : Array(std::vector<T>(values)) {}
  /// Memory of the host's, valid for as long as `owner` lives. Version 0: it never changes, and is not copied. Any
  /// other version: the host edits it in place, outside of Sync, and gives the array another version after each edit.
  /// Prims read such memory in Sync, and copy it.
  Array(std::shared_ptr<const void> owner, const T* data, size_t size, uint64_t version = 0)
      : ArrayMemory(std::move(owner), data, size, version) {}

  const T* data() const { return static_cast<const T*>(data_); }
  const T& operator[](size_t i) const { return data()[i]; }
  const T* begin() const { return data(); }
  const T* end() const { return data() + size_; }
  /// Itself, or a copy of memory that the host edits in place.
  Array frozen() const { return version_ == 0 ? *this : Array(std::vector<T>(begin(), end())); }
  /// Memory that the host edits in place cannot be compared with its values of before: other memory counts as changed.
  bool operator==(const Array& o) const {
    if (size_ != o.size_) return false;
    if (data_ == o.data_) return version_ == o.version_;
    if (version_ != 0 || o.version_ != 0) return size_ == 0;
    for (size_t i = 0; i < size_; ++i)
      if (!((*this)[i] == o[i])) return false;
    return true;
  }
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
  /// Why there is no file to read, as the reader of a scene file found; reported where the asset is used.
  std::string fault = {};
  bool operator==(const AssetPath&) const = default;
};

class Value;
using Dictionary = std::map<std::string, Value>;

/// Values at increasing times, in frames, relative to the frame that is drawn. They may lie outside of the shutter and
/// need not be evenly spaced. Less than two: nothing moves, and the value is the one that is pulled without samples.
template <class T>
struct TimeSamples {
  std::vector<double> times;
  std::vector<T> values;
  bool operator==(const TimeSamples&) const = default;
};

/// The C++ type of each AlabasterType, by its number.
using ValueTypes =
    std::tuple<std::monostate, bool, int32_t, int64_t, uint32_t, float, double, Vec2f, Vec3f, Vec4f, Vec2i, Vec3i,
               Vec3d, Quatf, Matrix4d, Token, std::string, Path, AssetPath, std::shared_ptr<const Dictionary>, Half,
               Vec2h, Vec3h, Vec4h, Vec2d, Vec4d, Quath, std::shared_ptr<const TimeSamples<Value>>>;
static_assert(std::tuple_size_v<ValueTypes> == ALABASTER_SAMPLES + 1);

template <class T, class... Types>
constexpr AlabasterType FindType(const std::tuple<Types...>*) {
  constexpr bool kIsT[] = {std::is_same_v<T, Types>...};
  for (size_t i = 1; i < sizeof...(Types); ++i)
    if (kIsT[i]) return static_cast<AlabasterType>(i);
  return ALABASTER_NONE;
}
/// ALABASTER_NONE: no value is a T.
template <class T>
inline constexpr AlabasterType kTypeOf = FindType<T>(static_cast<ValueTypes*>(nullptr));
template <class T>
inline constexpr bool kIsElement = kTypeOf<T> != ALABASTER_NONE&& kTypeOf<T> != ALABASTER_ASSET&& kTypeOf<T> !=
                                   ALABASTER_DICTIONARY&& kTypeOf<T> != ALABASTER_SAMPLES;

enum class Scalar : uint8_t { other, boolean, int32, int64, uint32, float16, float32, float64 };
struct TypeInfo {
  const char* name;  // for messages: "float3"
  Scalar scalar = Scalar::other;
  uint8_t components = 1;  // of scalars
  uint8_t bytes = 0;       // of an element; 0: no number
};
/// A type that does not exist has the name "unknown type".
ALABASTER_API const TypeInfo& GetTypeInfo(int32_t type);

/// A scalar or an array of one of the ValueTypes. Copies share what is larger than 32 bytes.
class ALABASTER_API Value {
 public:
  Value();
  // In the library, for they are made in many files.
  Value(const Value& o);
  Value(Value&& o) noexcept;
  Value& operator=(const Value& o);
  Value& operator=(Value&& o) noexcept;
  ~Value();
  template <class T>
  requires(kTypeOf<T> != ALABASTER_NONE) Value(T value)  // NOLINT(google-explicit-constructor)
      : type_(kTypeOf<T>) {
    if constexpr (kIsInline<T>)
      new (inline_.data()) T(std::move(value));
    else
      held_ = std::make_shared<const T>(std::move(value));
  }
  template <class T>
  requires(kIsElement<T>) Value(Array<T> array)  // NOLINT(google-explicit-constructor)
      : type_(kTypeOf<T>), is_array_(true) {
    std::shared_ptr<const ArrayMemory> memory = std::make_shared<const Array<T>>(std::move(array));
    held_ = std::move(memory);
  }
  template <class T>
  requires(kIsElement<T>) Value(std::vector<T> values)  // NOLINT(google-explicit-constructor)
      : Value(Array<T>(std::move(values))) {}
  Value(const char* text) : Value(std::string(text)) {}  // NOLINT(google-explicit-constructor)
  Value(std::shared_ptr<Dictionary> dictionary)          // NOLINT(google-explicit-constructor)
      : Value(std::shared_ptr<const Dictionary>(std::move(dictionary))) {}

  /// A scalar number, vector, quaternion or matrix of `type`, copied. Empty if `type` is none of these.
  static Value number(int32_t type, const void* data);
  /// An array of such: of the memory of `owner` (see Array), or of a copy if `owner` is null. Empty if `type` is none
  /// of these. The memory must be aligned as the elements are.
  static Value array(int32_t type, std::shared_ptr<const void> owner, const void* data, size_t count,
                     uint64_t version = 0);

  bool empty() const { return type_ == ALABASTER_NONE; }
  AlabasterType type() const { return type_; }  // of the elements of an array
  bool is_array() const { return is_array_; }
  /// Elements of an array; 1 of a scalar, 0 of an empty value.
  size_t count() const { return is_array_ ? array_memory()->size() : empty() ? 0 : 1; }
  /// The elements, or the scalar.
  const void* data() const {
    if (is_array_) return array_memory()->data_;
    return held_ ? held_.get() : static_cast<const void*>(inline_.data());
  }
  /// Null: it is of another type.
  template <class T>
  const T* get() const {
    if constexpr (kTypeOf<T> != ALABASTER_NONE)
      return type_ == kTypeOf<T> && !is_array_ ? static_cast<const T*>(data()) : nullptr;
    else
      return get_array(static_cast<T*>(nullptr));
  }
  template <class T>
  T get_or(T fallback) const {
    const T* held = get<T>();
    return held ? *held : std::move(fallback);
  }
  /// Number i of those that its elements have, one after the other; NaN if it has none there.
  double component(size_t i) const;
  /// A scalar number as double; `fallback` for the rest.
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

 private:
  template <class T>
  static constexpr bool kIsInline = sizeof(T) <= 32 && alignof(T) <= 8 && std::is_trivially_destructible_v<T>;
  template <class T>
  const Array<T>* get_array(const Array<T>*) const {
    return type_ == kTypeOf<T> && is_array_ ? static_cast<const Array<T>*>(array_memory()) : nullptr;
  }
  const ArrayMemory* array_memory() const { return static_cast<const ArrayMemory*>(held_.get()); }

  AlabasterType type_ = ALABASTER_NONE;
  bool is_array_ = false;
  alignas(8) std::array<std::byte, 32> inline_{};
  std::shared_ptr<const void> held_;  // an ArrayMemory of an array
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
