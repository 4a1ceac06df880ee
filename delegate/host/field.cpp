#include "delegate/host/field.h"

#include <algorithm>
#include <cmath>

#include "delegate/support/nearest_name.h"

namespace alabaster::hd::host {
namespace {

bool is_text(const Value& value) {
  return !value.is_array() &&
         (value.type() == ALABASTER_TOKEN || value.type() == ALABASTER_STRING || value.type() == ALABASTER_PATH);
}

std::string range_text(const Limits& limits, const char* what) {
  if (std::isinf(limits.low) && std::isinf(limits.high)) return what;
  if (std::isinf(limits.high)) return std::string(what) + ", at least " + limit_text(limits.low);
  return std::string(what) + " from " + limit_text(limits.low) + " to " + limit_text(limits.high);
}

template <class T>
void append_names(const Value& value, std::vector<Token>* out) {
  if (const auto* array = value.get<Array<T>>())
    for (const T& name : *array) {
      if constexpr (std::is_same_v<T, std::string>)
        out->emplace_back(name);
      else
        out->emplace_back(name.str());
    }
}

}  // namespace

int read_word(const Value& value, const Limits& limits, std::string* must) {
  const std::string word = value.text_or("");
  std::string known;
  for (size_t i = 0; i < limits.words.size() && limits.words[i]; ++i) {
    if (is_text(value) && word == limits.words[i]) return static_cast<int>(i);
    known += (known.empty() ? "" : ", ") + std::string(limits.words[i]);
  }
  *must = "one of " + known;
  return -1;
}

std::string read(const Value& value, const Limits& limits, Token* out) {
  if (!limits.words[0] && !is_text(value)) return "a text";
  std::string must;
  if (limits.words[0] && read_word(value, limits, &must) < 0) return must;
  *out = value.text_or("");
  return {};
}
std::string read(const Value& value, const Limits&, Path* out) {
  if (!is_text(value)) return "a path";
  *out = value.text_or("");
  return {};
}
std::string read(const Value& value, const Limits&, std::string* out) {
  if (!is_text(value) && !value.get<AssetPath>()) return "a text";
  *out = value.text_or("");
  return {};
}
std::string read(const Value& value, const Limits&, bool* out) {
  const double number = value.number_or(std::numeric_limits<double>::quiet_NaN());
  if (std::isnan(number)) return "true or false";
  *out = number != 0;
  return {};
}
template <class Number>
requires std::is_arithmetic_v<Number> std::string read(const Value& value, const Limits& limits, Number* out) {
  constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
  const double number = value.type() == ALABASTER_BOOL ? kNone : value.number_or(kNone);
  constexpr bool kIsWhole = std::is_integral_v<Number>;
  const bool fits = number >= std::max(limits.low, double(std::numeric_limits<Number>::lowest())) &&
                    number <= std::min(limits.high, double(std::numeric_limits<Number>::max()));
  if (!fits || (kIsWhole && number != std::floor(number)))
    return range_text(limits, kIsWhole ? "a whole number" : "a number");
  *out = static_cast<Number>(number);
  return {};
}
template std::string read(const Value& value, const Limits& limits, int* out);
template std::string read(const Value& value, const Limits& limits, float* out);
template std::string read(const Value& value, const Limits& limits, double* out);
std::string read(const Value& value, const Limits&, Matrix4d* out) {
  if (const auto* matrix = value.get<Matrix4d>()) return *out = *matrix, "";
  return "a matrix";
}
template <class T>
std::string read(const Value& value, const Limits&, Array<T>* out) {
  if (const auto* array = value.get<Array<T>>()) return *out = *array, "";
  return std::string("an array of ") + GetTypeInfo(kTypeOf<T>).name;
}
template std::string read(const Value& value, const Limits& limits, Array<int32_t>* out);
template std::string read(const Value& value, const Limits& limits, Array<float>* out);
std::string read(const Value& value, const Limits&, std::vector<Token>* out) {
  if (!value.is_array() || GetTypeInfo(value.type()).bytes != 0) return "an array of texts";
  out->clear();
  append_names<Token>(value, out);
  append_names<std::string>(value, out);
  append_names<Path>(value, out);
  return {};
}
std::string read(const Value& value, const Limits&, TimeSamples<Value>* out) {
  const auto* samples = value.get<std::shared_ptr<const TimeSamples<Value>>>();
  if (!samples) return "samples: values at times";
  *out = **samples;
  return {};
}
std::string read(const Value& value, const Limits& limits, TimeSamples<Matrix4d>* out) {
  TimeSamples<Value> samples;
  const bool are_samples = read(value, limits, &samples).empty();
  TimeSamples<Matrix4d> matrices;
  matrices.times = std::move(samples.times);
  for (const Value& one : samples.values)
    if (const auto* matrix = one.get<Matrix4d>()) matrices.values.push_back(*matrix);
  if (!are_samples || matrices.values.size() != matrices.times.size()) return "samples: matrices at times";
  *out = std::move(matrices);
  return {};
}
std::string read(const Value& value, const Limits&, std::optional<Rect2i>* out) {
  const auto* sides = value.get<Array<int32_t>>();
  if (!sides || sides->size() != 4) return "an array of the ints minX, minY, maxX and maxY";
  const Rect2i rect = {(*sides)[0], (*sides)[1], (*sides)[2], (*sides)[3]};
  *out = rect.empty() ? std::nullopt : std::optional(rect);
  return {};
}

bool is_default(const Value& value) {
  return value.empty() || (is_text(value) && value.text_or("").empty());
}

Value write(const TimeSamples<Value>& member, const Limits&) {
  return std::make_shared<const TimeSamples<Value>>(member);
}
Value write(const TimeSamples<Matrix4d>& member, const Limits& limits) {
  return write(TimeSamples<Value>{member.times, {member.values.begin(), member.values.end()}}, limits);
}
Value write(const std::optional<Rect2i>& member, const Limits&) {
  return member ? Value(Array<int32_t>{member->minX, member->minY, member->maxX, member->maxY}) : Value();
}

std::string fault_text(std::string_view name, const std::string& must, const Value& value,
                       const std::vector<std::string>& words) {
  constexpr size_t kMostBytes = 60;
  const bool is_long = value.is_array() || value.type() == ALABASTER_SAMPLES || value.type() == ALABASTER_DICTIONARY;
  std::string is = is_long ? (value.is_array() ? "an array of " : "") + std::string(GetTypeInfo(value.type()).name)
                           : value.to_string();
  if (is.size() > kMostBytes) {
    size_t end = kMostBytes - 3;
    while (end > 0 && (is[end] & 0xC0) == 0x80) --end;  // no part of a character
    is = is.substr(0, end) + "...";
  }
  return "'" + std::string(name) + "' must be " + must + ", and is " + is +
         (is_text(value) ? support::DidYouMean(value.text_or(""), words) : "");
}

std::vector<std::string> words_of(const Limits& limits) {
  std::vector<std::string> words;
  for (const char* word : limits.words)
    if (word) words.emplace_back(word);
  return words;
}

}  // namespace alabaster::hd::host
