#include "delegate/api/types.h"

#include <charconv>
#include <cmath>
#include <cstddef>
#include <cstring>
#include <limits>
#include <mutex>
#include <type_traits>
#include <unordered_set>

#include "delegate/api/scene_types.h"

namespace alabaster::hd {
namespace {

// Interned strings are shared by every delegate in the process and never freed: node addresses of an unordered_set are
// stable.
struct TokenTable {
  std::mutex mutex;
  std::unordered_set<std::string> strings;
};
TokenTable& token_table() {
  static auto* table = new TokenTable;
  return *table;
}

}  // namespace

Token::Token(std::string_view text) {
  if (text.empty()) return;
  TokenTable& table = token_table();
  const std::lock_guard lock(table.mutex);
  rep_ = &*table.strings.emplace(text).first;
}

const std::string& Token::str() const {
  static const std::string empty;
  return rep_ ? *rep_ : empty;
}

namespace {

constexpr const char* kTypeNames[] = {
    "none",   "bool",       "int",  "int64",   "uint",       "float",  "double",  "float2",  "float3",
    "float4", "int2",       "int3", "double3", "quaternion", "matrix", "token",   "string",  "path",
    "asset",  "dictionary", "half", "half2",   "half3",      "half4",  "double2", "double4", "quaternion of halves",
    "samples"};

template <class T>
constexpr Scalar scalar_of() {
  if constexpr (std::is_same_v<T, bool>) return Scalar::boolean;
  if constexpr (std::is_same_v<T, int32_t>) return Scalar::int32;
  if constexpr (std::is_same_v<T, int64_t>) return Scalar::int64;
  if constexpr (std::is_same_v<T, uint32_t>) return Scalar::uint32;
  if constexpr (std::is_same_v<T, Half>) return Scalar::float16;
  if constexpr (std::is_same_v<T, float>) return Scalar::float32;
  if constexpr (std::is_same_v<T, double>) return Scalar::float64;
  return Scalar::other;
}

// Hosts' numbers are read as Imath's types where they lie: scalars of one type, one after the other.
template <class T>
constexpr TypeInfo info_of(const char* name) {
  if constexpr (scalar_of<T>() != Scalar::other) {
    return {name, scalar_of<T>(), 1, sizeof(T)};
  } else if constexpr (requires { typename T::BaseType; }) {
    using Base = typename T::BaseType;
    static_assert(sizeof(T) % sizeof(Base) == 0);
    return {name, scalar_of<Base>(), sizeof(T) / sizeof(Base), sizeof(T)};
  } else {
    return {name};
  }
}
static_assert(sizeof(bool) == 1 && sizeof(Vec3f) == 12 && sizeof(Vec3h) == 6 && sizeof(Matrix4d) == 128);

template <size_t... kIndex>
constexpr auto make_type_infos(std::index_sequence<kIndex...>) {
  return std::array{info_of<std::tuple_element_t<kIndex, ValueTypes>>(kTypeNames[kIndex])...};
}
constexpr size_t kTypeCount = std::tuple_size_v<ValueTypes>;
static_assert(std::size(kTypeNames) == kTypeCount);
constexpr auto kTypeInfos = make_type_infos(std::make_index_sequence<kTypeCount>());

/// Calls visit(std::type_identity<T>) with the C++ type of `type`.
template <class Visit, size_t... kIndex>
void visit_type_of(int32_t type, const Visit& visit, std::index_sequence<kIndex...>) {
  const auto at = [&](auto place) {
    constexpr size_t kPlace = decltype(place)::value;
    if (static_cast<size_t>(type) == kPlace) visit(std::type_identity<std::tuple_element_t<kPlace, ValueTypes>>());
  };
  (at(std::integral_constant<size_t, kIndex>()), ...);
}
template <class Visit>
void visit_type(int32_t type, const Visit& visit) {
  visit_type_of(type, visit, std::make_index_sequence<kTypeCount>());
}

bool is_of_numbers(int32_t type) {
  return GetTypeInfo(type).bytes != 0;
}
bool is_quaternion(int32_t type) {
  return type == ALABASTER_QUATERNION || type == ALABASTER_QUATERNION16;
}

// The shortest decimal that reads back as the same float or integer. A double has nine digits: the further ones of a
// transform are rounding, which differs between machines.
template <class T>
std::string number_text(T v) {
  char text[40];
  if constexpr (std::is_same_v<T, bool>)
    return v ? "true" : "false";
  else if constexpr (std::is_same_v<T, Half>)
    return {text, std::to_chars(text, text + sizeof text, float(v)).ptr};
  else if constexpr (std::is_same_v<T, double>)
    return {text, std::to_chars(text, text + sizeof text, v, std::chars_format::general, 9).ptr};
  else
    return {text, std::to_chars(text, text + sizeof text, v).ptr};
}

/// Calls visit(number) with the i-th of `data`, in its own type. False: there are no numbers.
template <class Visit>
bool visit_number(Scalar scalar, const void* data, size_t i, const Visit& visit) {
  switch (scalar) {
    case Scalar::boolean:
      return visit(static_cast<const bool*>(data)[i]), true;
    case Scalar::int32:
      return visit(static_cast<const int32_t*>(data)[i]), true;
    case Scalar::int64:
      return visit(static_cast<const int64_t*>(data)[i]), true;
    case Scalar::uint32:
      return visit(static_cast<const uint32_t*>(data)[i]), true;
    case Scalar::float16:
      return visit(static_cast<const Half*>(data)[i]), true;
    case Scalar::float32:
      return visit(static_cast<const float*>(data)[i]), true;
    case Scalar::float64:
      return visit(static_cast<const double*>(data)[i]), true;
    case Scalar::other:
      break;
  }
  return false;
}
std::string number_text_at(Scalar scalar, const void* data, size_t i) {
  std::string text;
  visit_number(scalar, data, i, [&](auto number) { text = number_text(number); });
  return text;
}
std::string numbers_text(const TypeInfo& info, const void* data, size_t element) {
  const size_t first = element * info.components;
  if (info.components == 1) return number_text_at(info.scalar, data, first);
  const bool is_matrix = info.components == 16;
  std::string text = is_matrix ? "((" : "(";
  for (size_t i = 0; i < info.components; ++i) {
    if (i > 0) text += is_matrix && i % 4 == 0 ? "), (" : ", ";
    text += number_text_at(info.scalar, data, first + i);
  }
  return text + (is_matrix ? "))" : ")");
}

std::string text_of(const std::string& v) {
  return '"' + v + '"';
}
std::string text_of(const Token& v) {
  return v.str();
}
std::string text_of(const Path& v) {
  return '<' + v.str() + '>';
}
std::string text_of(const AssetPath& v) {
  return '@' + v.authored + '@';
}
std::string text_of(const std::shared_ptr<const Dictionary>& v) {
  std::string text = "{";
  if (v)
    for (const auto& [key, value] : *v) text += (text.size() > 1 ? ", " : "") + key + ": " + value.to_string();
  return text + "}";
}
std::string text_of(const std::shared_ptr<const TimeSamples<Value>>& v) {
  std::string text = "{";
  for (size_t i = 0; v && i < v->times.size() && i < v->values.size(); ++i)
    text += (i ? ", " : "") + number_text(v->times[i]) + ": " + v->values[i].to_string();
  return text + "}";
}
template <class T>
std::string element_text(const void* data, size_t i) {
  if constexpr (info_of<T>("").bytes != 0)
    return numbers_text(kTypeInfos[kTypeOf<T>], data, i);
  else
    return text_of(static_cast<const T*>(data)[i]);
}

template <class T>
bool same(const T& a, const T& b) {
  // NaN set twice is no change: it must not restart a render again and again.
  if constexpr (std::is_floating_point_v<T>)
    return a == b || (std::isnan(a) && std::isnan(b));
  else
    return a == b;
}
template <class T>
bool same(const std::shared_ptr<const T>& a, const std::shared_ptr<const T>& b) {
  return a == b || (a && b && *a == *b);
}

}  // namespace

const TypeInfo& GetTypeInfo(int32_t type) {
  static constexpr TypeInfo kUnknown = {"unknown type"};
  return type >= 0 && static_cast<size_t>(type) < kTypeCount ? kTypeInfos[static_cast<size_t>(type)] : kUnknown;
}

Value::Value() = default;
Value::Value(const Value& o) = default;
Value::Value(Value&& o) noexcept
    : type_(std::exchange(o.type_, ALABASTER_NONE)),
      is_array_(std::exchange(o.is_array_, false)),
      inline_(o.inline_),
      held_(std::move(o.held_)) {}
Value& Value::operator=(const Value& o) = default;
Value& Value::operator=(Value&& o) noexcept {
  if (this == &o) return *this;
  type_ = std::exchange(o.type_, ALABASTER_NONE);
  is_array_ = std::exchange(o.is_array_, false);
  inline_ = o.inline_;
  held_ = std::move(o.held_);
  return *this;
}
Value::~Value() = default;

Value Value::number(int32_t type, const void* data) {
  Value made;
  if (!is_of_numbers(type)) return made;
  visit_type(type, [&](auto type_of) {
    using T = typename decltype(type_of)::type;
    if constexpr (info_of<T>("").bytes != 0) {
      T value;
      std::memcpy(static_cast<void*>(&value), data, sizeof value);
      made = value;
    }
  });
  return made;
}

Value Value::array(int32_t type, std::shared_ptr<const void> owner, const void* data, size_t count, uint64_t version) {
  Value made;
  if (!is_of_numbers(type)) return made;
  visit_type(type, [&](auto type_of) {
    using T = typename decltype(type_of)::type;
    if constexpr (info_of<T>("").bytes != 0) {
      if (owner) {
        made = Array<T>(std::move(owner), static_cast<const T*>(data), count, version);
      } else if constexpr (std::is_same_v<T, bool>) {
        made = std::vector<bool>(static_cast<const bool*>(data), static_cast<const bool*>(data) + count);
      } else {
        std::vector<T> copy(count);
        if (count > 0) std::memcpy(static_cast<void*>(copy.data()), data, count * sizeof(T));
        made = std::move(copy);
      }
    }
  });
  return made;
}

double Value::component(size_t i) const {
  const TypeInfo& info = GetTypeInfo(type_);
  double read = std::numeric_limits<double>::quiet_NaN();
  if (i >= count() * info.components) return read;
  visit_number(info.scalar, data(), i, [&](auto number) {
    if constexpr (std::is_same_v<decltype(number), Half>)
      read = double(float(number));
    else
      read = static_cast<double>(number);
  });
  return read;
}

double Value::number_or(double fallback) const {
  const bool is_number = !is_array_ && GetTypeInfo(type_).bytes != 0 && GetTypeInfo(type_).components == 1;
  return is_number ? component(0) : fallback;
}

size_t Value::components(std::array<double, 4>* out) const {
  const TypeInfo& info = GetTypeInfo(type_);
  if (is_array_ || info.bytes == 0 || info.components > 4 || is_quaternion(type_)) return 0;
  for (size_t i = 0; i < info.components; ++i) (*out)[i] = component(i);
  return info.components;
}

Value Value::frozen() const {
  if (!is_array_ || array_memory()->version() == 0) return *this;
  Value copy;
  visit_type(type_, [&](auto type_of) {
    using T = typename decltype(type_of)::type;
    if constexpr (kIsElement<T>) copy = get<Array<T>>()->frozen();
  });
  return copy;
}

std::string Value::text_or(std::string fallback) const {
  if (const auto* token = get<Token>()) return token->str();
  if (const auto* text = get<std::string>()) return *text;
  if (const auto* path = get<Path>()) return path->str();
  if (const auto* asset = get<AssetPath>()) return asset->resolved.empty() ? asset->authored : asset->resolved;
  return fallback;
}

std::string Value::to_string() const {
  std::string text = is_array_ ? "[" : "";
  visit_type(type_, [&](auto type_of) {
    using T = typename decltype(type_of)::type;
    if constexpr (std::is_same_v<T, std::monostate>)
      text = "empty";
    else
      for (size_t i = 0; i < count(); ++i) text += (i ? ", " : "") + element_text<T>(data(), i);
  });
  return is_array_ ? text + "]" : text;
}

bool Value::operator==(const Value& o) const {
  if (type_ != o.type_ || is_array_ != o.is_array_) return false;
  bool equal = true;
  visit_type(type_, [&](auto type_of) {
    using T = typename decltype(type_of)::type;
    if constexpr (kIsElement<T>)
      if (is_array_) {
        equal = *get<Array<T>>() == *o.get<Array<T>>();
        return;
      }
    if constexpr (kTypeOf<T> != ALABASTER_NONE) equal = same(*get<T>(), *o.get<T>());
  });
  return equal;
}

int FormatComponents(Format format) {
  switch (format) {
    case Format::invalid:
      return 0;
    case Format::unorm8:
    case Format::float16:
    case Format::float32:
    case Format::int32:
      return 1;
    case Format::float32vec2:
      return 2;
    case Format::unorm8vec3:
    case Format::float16vec3:
    case Format::float32vec3:
      return 3;
    case Format::unorm8vec4:
    case Format::float16vec4:
    case Format::float32vec4:
      return 4;
  }
  return 0;
}

size_t FormatSize(Format format) {
  const auto components = static_cast<size_t>(FormatComponents(format));
  switch (format) {
    case Format::unorm8:
    case Format::unorm8vec3:
    case Format::unorm8vec4:
      return components;
    case Format::float16:
    case Format::float16vec3:
    case Format::float16vec4:
      return components * 2;
    default:
      return components * 4;
  }
}

}  // namespace alabaster::hd
