#include "delegate/archive/tensors.h"

#include <cmath>
#include <limits>
#include <utility>

#include "delegate/support/json_values.h"

namespace alabaster::hd::archive {
namespace {

using nlohmann::json;

std::string type_key(const Value& value) {
  return std::string(GetTypeInfo(value.type()).name) + (value.is_array() ? "[]" : "");
}
int32_t type_named(const std::string& name) {
  for (int32_t type = ALABASTER_BOOL; type <= ALABASTER_SAMPLES; ++type)
    if (name == GetTypeInfo(type).name) return type;
  throw Fault("there are no values of type '" + name + "'");
}

bool is_finite(const Value& value) {
  for (size_t i = 0; i < GetTypeInfo(value.type()).components; ++i)
    if (!std::isfinite(value.component(i))) return false;
  return true;
}

Fault unlike(const char* expected, const json& given) {
  return Fault(std::string("expected ") + expected + ", and found " + given.type_name());
}

const std::string& text_of(const json& value) {
  if (!value.is_string()) throw unlike("a text", value);
  return value.get_ref<const std::string&>();
}

template <class T>
Value read_texts(const json& list) {
  if (!list.is_array()) throw unlike("a list of texts", list);
  std::vector<T> texts;
  for (const json& text : list) texts.emplace_back(text_of(text));
  return texts;
}

template <class T>
Value packed(const json& list, int32_t type) {
  std::vector<T> numbers;
  for (const json& number : list) {
    if (!number.is_number()) throw unlike("a number", number);
    if constexpr (std::is_same_v<T, Half>) {
      numbers.push_back(Half(number.get<float>()));
    } else if constexpr (std::is_integral_v<T>) {
      const bool fits = number.is_number_unsigned()  ? std::in_range<T>(number.get<uint64_t>())
                        : number.is_number_integer() ? std::in_range<T>(number.get<int64_t>())
                                                     : false;
      if (!fits) throw Fault(number.dump() + " is not a whole number of its type");
      numbers.push_back(number.get<T>());
    } else {
      if (std::abs(number.get<double>()) > double(std::numeric_limits<T>::max()))
        throw Fault(number.dump() + " is too large for its type");
      numbers.push_back(number.get<T>());
    }
  }
  if (numbers.size() != GetTypeInfo(type).components) throw Fault("a vector has the wrong number of components");
  return Value::number(type, numbers.data());
}

Value read_numbers(const json& given, int32_t type, const TensorReader& tensors) {
  if (given.is_string()) return tensors.number(given.get<std::string>(), type);
  if (type == ALABASTER_BOOL) {
    if (!given.is_boolean()) throw unlike("a bool", given);
    return given.get<bool>();
  }
  const json list = given.is_array() ? given : json::array({given});
  switch (GetTypeInfo(type).scalar) {
    case Scalar::int32:
      return packed<int32_t>(list, type);
    case Scalar::int64:
      return packed<int64_t>(list, type);
    case Scalar::uint32:
      return packed<uint32_t>(list, type);
    case Scalar::float16:
      return packed<Half>(list, type);
    case Scalar::float32:
      return packed<float>(list, type);
    default:
      return packed<double>(list, type);
  }
}

}  // namespace

json write_value(const Value& value, TensorWriter* tensors, const std::function<json(const AssetPath&)>& asset) {
  if (value.empty()) return nullptr;
  json written;
  if (GetTypeInfo(value.type()).bytes > 0 && (value.is_array() || !is_finite(value))) {
    written = tensors->add(value);
  } else if (const auto* path = value.get<AssetPath>()) {
    written = asset(*path);
  } else if (const auto* samples = value.get<std::shared_ptr<const TimeSamples<Value>>>()) {
    written = json::array();
    for (size_t i = 0; i < (*samples)->times.size(); ++i)
      written.push_back({(*samples)->times[i], write_value((*samples)->values[i], tensors, asset)});
  } else if (value.type() == ALABASTER_DICTIONARY) {
    throw Fault("a dictionary is no value of a field");
  } else {
    written = support::json_of(value);
  }
  return {{type_key(value), written}};
}

Value read_value(const json& given, const TensorReader& tensors, const std::function<AssetPath(const json&)>& asset) {
  if (given.is_null()) return {};
  if (!given.is_object() || given.size() != 1) throw Fault("a value is no object with one type");
  std::string name = given.begin().key();
  const json& held = given.begin().value();
  const bool is_array = name.ends_with("[]");
  if (is_array) name.resize(name.size() - 2);
  const int32_t type = type_named(name);
  if (GetTypeInfo(type).bytes > 0)
    return is_array ? tensors.array(text_of(held), type) : read_numbers(held, type, tensors);
  if (type == ALABASTER_TOKEN) return is_array ? read_texts<Token>(held) : Value(Token(text_of(held)));
  if (type == ALABASTER_STRING) return is_array ? read_texts<std::string>(held) : Value(text_of(held));
  if (type == ALABASTER_PATH) return is_array ? read_texts<Path>(held) : Value(Path(text_of(held)));
  if (type == ALABASTER_ASSET) return asset(held);
  if (type != ALABASTER_SAMPLES) throw Fault("a field holds a " + name);
  auto samples = std::make_shared<TimeSamples<Value>>();
  if (!held.is_array()) throw unlike("samples", held);
  for (const json& sample : held) {
    if (!sample.is_array() || sample.size() != 2 || !sample[0].is_number())
      throw Fault("a sample is no pair of a time and a value");
    samples->times.push_back(sample[0].get<double>());
    if (sample[1].is_object() && sample[1].contains("samples")) throw Fault("samples hold samples");
    samples->values.push_back(read_value(sample[1], tensors, asset));
  }
  return std::shared_ptr<const TimeSamples<Value>>(std::move(samples));
}

}  // namespace alabaster::hd::archive
