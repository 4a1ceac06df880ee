#include "delegate/support/json_values.h"

#include <algorithm>
#include <charconv>
#include <limits>
#include <nlohmann/json.hpp>

namespace alabaster::hd::support {
namespace {

using nlohmann::json;

json number_of(const Value& value, size_t i) {
  switch (GetTypeInfo(value.type()).scalar) {
    case Scalar::boolean:
      return value.component(i) != 0;
    case Scalar::float16:
    case Scalar::float32:
      return shortest_decimal(static_cast<float>(value.component(i)));
    case Scalar::float64:
      return value.component(i);
    default:
      return static_cast<int64_t>(value.component(i));
  }
}

template <class T>
json texts_of(const Array<T>& texts) {
  json list = json::array();
  for (const T& text : texts) list.push_back(Value(text).text_or(""));
  return list;
}

template <class T>
Value array_of(const json& list) {
  return list.get<std::vector<T>>();
}

}  // namespace

double shortest_decimal(float value) {
  char text[64];
  const auto end = std::to_chars(text, text + sizeof text, value);
  double read = 0;
  std::from_chars(text, end.ptr, read);
  return read;
}

json json_of(const Value& value) {
  if (value.empty()) return nullptr;
  if (const auto* held = value.get<std::shared_ptr<const Dictionary>>()) {
    json object = json::object();
    if (*held)
      for (const auto& [key, member] : **held) object[key] = json_of(member);
    return object;
  }
  if (const auto* number = value.get<int64_t>()) return *number;
  if (const auto* texts = value.get<Array<std::string>>()) return texts_of(*texts);
  if (const auto* texts = value.get<Array<Token>>()) return texts_of(*texts);
  if (const auto* texts = value.get<Array<Path>>()) return texts_of(*texts);
  const TypeInfo& info = GetTypeInfo(value.type());
  if (info.bytes == 0) return value.text_or(value.to_string());
  if (!value.is_array() && info.components == 1) return number_of(value, 0);
  json list = json::array();
  for (size_t i = 0; i < value.count(); ++i) {
    json element = json::array();
    for (size_t c = 0; c < info.components; ++c) element.push_back(number_of(value, i * info.components + c));
    list.push_back(info.components == 1 ? element[0] : std::move(element));
  }
  return value.is_array() ? list : list[0];
}

Value value_of(const json& value) {
  if (value.is_boolean()) return value.get<bool>();
  if (value.is_string()) return value.get<std::string>();
  if (value.is_number_integer() && !(value.is_number_unsigned() && value.get<uint64_t>() >> 63)) {
    const auto number = value.get<int64_t>();
    const bool fits = number >= std::numeric_limits<int32_t>::min() && number <= std::numeric_limits<int32_t>::max();
    return fits ? Value(static_cast<int32_t>(number)) : Value(number);
  }
  if (value.is_number()) {
    const auto number = value.get<double>();
    const auto nearest = static_cast<float>(number);
    return shortest_decimal(nearest) == number ? Value(nearest) : Value(number);
  }
  if (!value.is_array() || value.empty()) return {};
  const auto all = [&](const auto& is) { return std::all_of(value.begin(), value.end(), is); };
  if (all([](const json& text) { return text.is_string(); })) return array_of<std::string>(value);
  const auto is_number = [](const json& number) { return number.is_number(); };
  const auto is_row = [&](const json& row) {
    return row.is_array() && row.size() == 4 && std::all_of(row.begin(), row.end(), is_number);
  };
  if (all(is_row)) {
    std::vector<Vec4f> rows;
    for (const json& row : value)
      rows.emplace_back(row[0].get<float>(), row[1].get<float>(), row[2].get<float>(), row[3].get<float>());
    return rows;
  }
  if (!all(is_number)) return {};
  if (value.size() == 2) return Vec2f(value[0].get<float>(), value[1].get<float>());
  if (value.size() == 3) return Vec3f(value[0].get<float>(), value[1].get<float>(), value[2].get<float>());
  const bool whole = all([](const json& number) { return number.is_number_integer(); });
  return whole ? array_of<int32_t>(value) : array_of<float>(value);
}

std::string readable_json(const nlohmann::ordered_json& value, const std::string& indent) {
  constexpr size_t kMostInLine = 140;
  std::string line = value.dump(-1, ' ');
  if (!value.is_structured() || indent.size() + line.size() < kMostInLine) return line;
  std::string text;
  for (const auto& [key, item] : value.items())
    text += (text.empty() ? "" : ",") + indent + "  " +
            (value.is_array() ? "" : nlohmann::ordered_json(key).dump() + ": ") + readable_json(item, indent + "  ");
  return (value.is_array() ? "[" : "{") + text + indent + (value.is_array() ? "]" : "}");
}

}  // namespace alabaster::hd::support
