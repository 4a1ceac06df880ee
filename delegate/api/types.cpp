#include "delegate/api/types.h"

#include <pthread.h>

#include <charconv>
#include <cmath>
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
  static auto* table = [] {
    auto* made = new TokenTable;
    // A child that is forked while another thread holds the lock could never take it.
    const auto unlock = [] { token_table().mutex.unlock(); };
    pthread_atfork([] { token_table().mutex.lock(); }, unlock, unlock);
    return made;
  }();
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

// The shortest decimal that reads back as the same float or integer. A double has nine digits: the further ones of a
// transform are rounding, which differs between machines.
template <class T>
std::string number_text(T v) {
  char text[40];
  if constexpr (std::is_same_v<T, Half>)
    return {text, std::to_chars(text, text + sizeof text, float(v)).ptr};
  else if constexpr (std::is_same_v<T, double>)
    return {text, std::to_chars(text, text + sizeof text, v, std::chars_format::general, 9).ptr};
  else
    return {text, std::to_chars(text, text + sizeof text, v).ptr};
}

template <class V>
std::string components_text(const V& v) {
  std::string text = "(";
  for (unsigned i = 0; i < V::dimensions(); ++i) text += (i ? ", " : "") + number_text(v[int(i)]);
  return text + ")";
}

template <class V>
requires requires {
  V::dimensions();
}
std::string text_of(const V& v) {
  return components_text(v);
}
template <class T>
std::string text_of(const Imath::Quat<T>& q) {
  return components_text(Vec4f(float(q.r), float(q.v.x), float(q.v.y), float(q.v.z)));
}
std::string text_of(const Matrix4d& m) {
  std::string text = "(";
  for (int row = 0; row < 4; ++row)
    text += (row ? ", " : "") + components_text(Imath::V4d(m[row][0], m[row][1], m[row][2], m[row][3]));
  return text + ")";
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
std::string text_of(Half v) {
  return number_text(v);
}
template <class T>
requires std::is_arithmetic_v<T> std::string text_of(T v) {
  if constexpr (std::is_same_v<T, bool>)
    return v ? "true" : "false";
  else
    return number_text(v);
}
template <class T>
std::string text_of(const Array<T>& array) {
  std::string text = "[";
  for (size_t i = 0; i < array.size(); ++i) text += (i ? ", " : "") + text_of(array[i]);
  return text + "]";
}

template <class T>
T float_or_double(T v) {
  return v;
}
float float_or_double(Half v) {
  return v;
}

template <class T>
bool same(const T& a, const T& b) {
  // NaN set twice is no change: it must not restart a render again and again.
  if constexpr (std::is_floating_point_v<T>)
    return a == b || (std::isnan(a) && std::isnan(b));
  else
    return a == b;
}
bool same(const std::shared_ptr<const Dictionary>& a, const std::shared_ptr<const Dictionary>& b) {
  return a == b || (a && b && *a == *b);
}

}  // namespace

Value::Value() = default;
Value::Value(const Value& o) = default;
Value::Value(Value&& o) noexcept = default;
Value& Value::operator=(const Value& o) = default;
Value& Value::operator=(Value&& o) noexcept = default;
Value::~Value() = default;

double Value::number_or(double fallback) const {
  return std::visit(
      [&](const auto& v) {
        using T = std::decay_t<decltype(v)>;
        if constexpr (std::is_same_v<T, Half>)
          return double(float(v));
        else if constexpr (std::is_arithmetic_v<T>)
          return static_cast<double>(v);
        else
          return fallback;
      },
      storage_);
}

size_t Value::components(std::array<double, 4>* out) const {
  return std::visit(
      [&]<class T>(const T& v) -> size_t {
        if constexpr (requires { T::dimensions(); } && !std::is_same_v<T, Matrix4d>) {
          for (unsigned i = 0; i < T::dimensions(); ++i) (*out)[i] = double(float_or_double(v[int(i)]));
          return T::dimensions();
        } else if constexpr (std::is_arithmetic_v<T> || std::is_same_v<T, Half>) {
          (*out)[0] = double(float_or_double(v));
          return 1;
        } else {
          return 0;
        }
      },
      storage_);
}

Value Value::frozen() const {
  return std::visit(
      [&](const auto& v) -> Value {
        if constexpr (requires { v.frozen(); })
          return v.version() != 0 ? Value(v.frozen()) : *this;
        else
          return *this;
      },
      storage_);
}

std::string Value::text_or(std::string fallback) const {
  if (const auto* token = get<Token>()) return token->str();
  if (const auto* text = get<std::string>()) return *text;
  if (const auto* path = get<Path>()) return path->str();
  if (const auto* asset = get<AssetPath>()) return asset->resolved.empty() ? asset->authored : asset->resolved;
  return fallback;
}

std::string Value::to_string() const {
  return std::visit(
      [](const auto& v) {
        if constexpr (std::is_same_v<std::decay_t<decltype(v)>, std::monostate>)
          return std::string("empty");
        else
          return text_of(v);
      },
      storage_);
}

bool Value::operator==(const Value& o) const {
  if (storage_.index() != o.storage_.index()) return false;
  return std::visit(
      [&](const auto& v) {
        using T = std::decay_t<decltype(v)>;
        return same(v, *std::get_if<T>(&o.storage_));
      },
      storage_);
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
