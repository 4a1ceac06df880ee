// A row of a table of fields, and the values that a member takes. Internal to this room.
#pragma once

#include <algorithm>
#include <array>
#include <limits>
#include <optional>
#include <string>
#include <type_traits>

#include "delegate/host/scene_fields.h"

namespace alabaster::hd::host {

/// The values that a field takes.
struct Limits {
  double low = -std::numeric_limits<double>::infinity(), high = std::numeric_limits<double>::infinity();
  std::array<const char*, 10> words{};  // of a token or an enumeration, in its order; null: no more
};
constexpr Limits range(double low, double high = std::numeric_limits<double>::infinity()) {
  return {low, high, {}};
}
template <class... Words>
constexpr Limits words(Words... all) {
  Limits limits;
  limits.words = {all...};
  return limits;
}
template <size_t kCount>
constexpr Limits words(const std::array<const char*, kCount>& all) {
  Limits limits;
  std::copy(all.begin(), all.end(), limits.words.begin());
  return limits;
}

// Each reads a value into a member. Returns what the value must be, or "" if it is that.
std::string read(const Value& value, const Limits& limits, Token* out);
std::string read(const Value& value, const Limits& limits, Path* out);
std::string read(const Value& value, const Limits& limits, std::string* out);
std::string read(const Value& value, const Limits& limits, bool* out);
template <class Number>
requires std::is_arithmetic_v<Number> std::string read(const Value& value, const Limits& limits, Number* out);
std::string read(const Value& value, const Limits& limits, Matrix4d* out);
template <class T>
std::string read(const Value& value, const Limits& limits, Array<T>* out);
std::string read(const Value& value, const Limits& limits, std::vector<Token>* out);
std::string read(const Value& value, const Limits& limits, TimeSamples<Matrix4d>* out);
std::string read(const Value& value, const Limits& limits, TimeSamples<Value>* out);
/// An empty rectangle is none.
std::string read(const Value& value, const Limits& limits, std::optional<Rect2i>* out);
/// The place of a word among `limits.words`; negative: it is none of them, and `must` says so.
int read_word(const Value& value, const Limits& limits, std::string* must);

template <class Enum>
requires std::is_enum_v<Enum> std::string read(const Value& value, const Limits& limits, Enum* out) {
  std::string must;
  if (const int place = read_word(value, limits, &must); place >= 0) *out = static_cast<Enum>(place);
  return must;
}
template <class T>
std::string read(const Value& value, const Limits& limits, std::optional<T>* out) {
  T held{};
  std::string must = read(value, limits, &held);
  if (must.empty()) *out = held;
  return must;
}

/// The value that read() reads as the same member. Empty: none.
template <class T>
Value write(const T& member, const Limits& limits) {
  if constexpr (std::is_enum_v<T>)
    return Token(limits.words[static_cast<size_t>(member)]);
  else
    return Value(member);
}
Value write(const TimeSamples<Matrix4d>& member, const Limits& limits);
Value write(const TimeSamples<Value>& member, const Limits& limits);
Value write(const std::optional<Rect2i>& member, const Limits& limits);
template <class T>
Value write(const std::optional<T>& member, const Limits& limits) {
  return member ? write(*member, limits) : Value();
}

/// "'refineLevel' must be 0 to 8, and is 9". `words`: that the field takes; the nearest one is named.
std::string fault_text(std::string_view name, const std::string& must, const Value& value,
                       const std::vector<std::string>& words = {});
std::vector<std::string> words_of(const Limits& limits);
/// An end of a range: "4294967295".
std::string limit_text(double limit);

/// No value, or an empty text.
bool is_default(const Value& value);

/// The type of the values of a member.
template <class T>
inline constexpr FieldType kFieldType = {std::is_enum_v<T> ? ALABASTER_TOKEN : kTypeOf<T>, false};
template <class T>
inline constexpr FieldType kFieldType<Array<T>> = {kTypeOf<T>, true};
template <class T>
inline constexpr FieldType kFieldType<std::vector<T>> = {kTypeOf<T>, true};
template <class T>
inline constexpr FieldType kFieldType<TimeSamples<T>> = {ALABASTER_SAMPLES, false};
template <class T>
inline constexpr FieldType kFieldType<std::optional<T>> = kFieldType<T>;
template <>
inline constexpr FieldType kFieldType<std::optional<Rect2i>> = {ALABASTER_INT, true};

struct Field {
  const char* name;
  DirtyBits dirty;   // what an edit of it marks
  const char* text;  // a sentence or two
  Limits limits;
  FieldType type;
  bool (*equal)(const void* a, const void* b) = nullptr;
  /// An empty value sets the default. Returns a fault, or "".
  std::string (*put)(const Field& field, void* object, const Value& value) = nullptr;
  /// The value that put() sets.
  Value (*get)(const Field& field, const void* object) = nullptr;
  /// An object with the defaults.
  const void* (*defaults)() = nullptr;
  const char* unit = "none";

  constexpr Field in(const char* its_unit) const {
    Field field = *this;
    field.unit = its_unit;
    return field;
  }
};

template <class Object, class Member>
Object class_of(Member Object::*);

template <auto kFirst, auto... kRest, class Object>
constexpr auto& follow(Object& object) {
  if constexpr (sizeof...(kRest) == 0)
    return object.*kFirst;
  else
    return follow<kRest...>(object.*kFirst);
}

/// The row of a member, or of a member of a member.
template <auto kFirst, auto... kRest>
constexpr Field field(const char* name, DirtyBits dirty, const char* text, const Limits& limits = {}) {
  using Object = decltype(class_of(kFirst));
  using Member = std::decay_t<decltype(follow<kFirst, kRest...>(std::declval<Object&>()))>;
  return {name,
          dirty,
          text,
          limits,
          kFieldType<Member>,
          [](const void* a, const void* b) {
            return follow<kFirst, kRest...>(*static_cast<const Object*>(a)) ==
                   follow<kFirst, kRest...>(*static_cast<const Object*>(b));
          },
          [](const Field& row, void* object, const Value& value) -> std::string {
            auto& member = follow<kFirst, kRest...>(*static_cast<Object*>(object));
            if (is_default(value)) {
              const Object defaults{};
              member = follow<kFirst, kRest...>(defaults);
              return {};
            }
            const std::string must = read(value, row.limits, &member);
            return must.empty() ? must : fault_text(row.name, must, value, words_of(row.limits));
          },
          [](const Field& row, const void* object) {
            return write(follow<kFirst, kRest...>(*static_cast<const Object*>(object)), row.limits);
          },
          []() -> const void* {
            static const Object made{};
            return &made;
          }};
}

}  // namespace alabaster::hd::host
