#include "delegate/c_api/values.h"

#include <limits>

namespace alabaster::hd::c_api {
namespace {

std::string type_name(const AlabasterValue& in) {
  return std::string(in.is_array ? "an array of " : "a value of ") + GetTypeInfo(in.type).name;
}
Failure bad_value(const char* name, const std::string& text) {
  return bad_argument("'" + std::string(name) + "': " + text);
}

// Each time it is lent, memory that the host edits counts as edited.
uint64_t version_of(const AlabasterValue& in) {
  static std::atomic<uint64_t> lent{0};
  return in.is_array == ALABASTER_EDITED_ARRAY ? ++lent : 0;
}

Value numbers(const AlabasterValue& in, std::shared_ptr<const void> owner) {
  const TypeInfo& info = GetTypeInfo(in.type);
  if (in.count > std::numeric_limits<size_t>::max() / 2 / info.bytes)
    throw bad_argument("an array of " + std::to_string(in.count) + " elements is larger than any memory");
  if (in.type == ALABASTER_BOOL) {  // bytes other than 0 and 1 are no bools of C++
    const auto* bytes = static_cast<const uint8_t*>(in.data);
    return std::vector<bool>(bytes, bytes + in.count);
  }
  const size_t alignment = info.bytes / info.components;
  if (owner && reinterpret_cast<uintptr_t>(in.data) % alignment != 0) throw bad_argument("a lent array is not aligned");
  return Value::array(in.type, std::move(owner), in.data, in.count, version_of(in));
}

template <class T>
Value texts(const AlabasterValue& in) {
  const auto* data = static_cast<const char* const*>(in.data);
  std::vector<T> held;
  for (size_t i = 0; i < in.count; ++i) held.emplace_back(std::string(text_or(data[i], "")));
  return Array<T>(std::move(held));
}

Value array_of(const AlabasterValue& in, std::shared_ptr<const void> owner) {
  if (GetTypeInfo(in.type).bytes > 0) return numbers(in, std::move(owner));
  if (in.type == ALABASTER_PATH) return texts<Path>(in);
  if (in.type == ALABASTER_TOKEN) return texts<Token>(in);
  if (in.type == ALABASTER_STRING) return texts<std::string>(in);
  throw bad_argument(std::string("there are no arrays of ") + GetTypeInfo(in.type).name);
}

Value scalar_of(const AlabasterValue& in) {
  const auto* text = static_cast<const char*>(in.data);
  if (in.type == ALABASTER_BOOL) return *static_cast<const uint8_t*>(in.data) != 0;
  if (GetTypeInfo(in.type).bytes > 0) return Value::number(in.type, in.data);
  if (in.type == ALABASTER_TOKEN) return Token(text);
  if (in.type == ALABASTER_STRING) return std::string(text);
  if (in.type == ALABASTER_PATH) return Path(text);
  if (in.type == ALABASTER_ASSET) return AssetPath{text, text, nullptr};
  throw bad_argument(std::string("there are no values of ") + GetTypeInfo(in.type).name);
}

Value read_value(const AlabasterValue& in, std::shared_ptr<const void> owner) {
  if (in.type == ALABASTER_NONE) return {};
  if (in.is_array < ALABASTER_SCALAR || in.is_array > ALABASTER_EDITED_ARRAY)
    throw bad_argument("there is no is_array " + std::to_string(in.is_array));
  if (in.is_array && in.count == 0) {
    static constexpr double kNothing = 0;
    AlabasterValue empty = in;
    empty.data = &kNothing;
    return array_of(empty, nullptr);
  }
  if (!in.data) throw bad_argument("the data of " + type_name(in) + " is null");
  return in.is_array ? array_of(in, std::move(owner)) : scalar_of(in);
}

std::string name_of(const AlabasterParameter& parameter) {
  if (!parameter.name || !*parameter.name) throw bad_argument("a parameter has no name");
  return parameter.name;
}

}  // namespace

ValueReader::Loan::~Loan() {
  if (!is_taken) return;
  const CallbackScope scope;
  release(owner);
}

// Null: the array is not lent.
std::shared_ptr<const void> ValueReader::borrow(const AlabasterValue& in) {
  if (!in.release) return nullptr;
  loans_.push_back(std::make_shared<Loan>(Loan{in.release, in.owner}));
  return loans_.back();
}

Value ValueReader::value(const AlabasterValue& in, const char* name) {
  try {
    if (in.type == ALABASTER_SAMPLES) return samples(in, name);
    return read_value(in, borrow(in));
  } catch (const Failure& failure) {
    throw bad_value(name, failure.what());
  }
}

Value ValueReader::samples(const AlabasterValue& in, const char* name) {
  borrow(in);
  auto read = std::make_shared<TimeSamples<Value>>();
  for (const AlabasterSample& sample : items(static_cast<const AlabasterSample*>(in.data), in.count, name)) {
    if (sample.value.type == ALABASTER_SAMPLES) throw bad_argument("samples cannot be samples of samples");
    read->times.push_back(sample.time);
    read->values.push_back(value(sample.value, name));
  }
  return std::shared_ptr<const TimeSamples<Value>>(std::move(read));
}

std::vector<Token> ValueReader::tokens(const AlabasterValue& in, const char* name) {
  const Value held = value(in, name);
  const auto names = held.get_or(Array<Token>());
  if (!held.empty() && !held.get<Array<Token>>())
    throw bad_argument(std::string(name) + " has the wrong type: it must be an array of tokens, and is " +
                       type_name(in));
  return {names.begin(), names.end()};
}

host::Fields ValueReader::fields(const ParameterList& in) {
  host::Fields read;
  for (const AlabasterParameter& one : items(in.first, in.count, "fields")) {
    std::string name = name_of(one);
    Value held = value(one.value, name.c_str());
    read.emplace_back(std::move(name), std::move(held));
  }
  return read;
}

Dictionary ValueReader::dictionary(const ParameterList& in, const char* name) {
  Dictionary read;
  for (const AlabasterParameter& one : items(in.first, in.count, name)) {
    const std::string own_name = name_of(one);
    read[own_name] = value(one.value, own_name.c_str());
  }
  return read;
}

// Gives back the arrays that a host lends with an argument, in the order in which it has them.
namespace {

template <class T>
std::span<const T> all_of(const T* first, size_t count) {
  return {first, first ? count : 0};
}

void give_back(const AlabasterValue& in) {
  if (in.type == ALABASTER_SAMPLES)
    for (const auto& sample : all_of(static_cast<const AlabasterSample*>(in.data), in.count)) give_back(sample.value);
  if (!in.release) return;
  const CallbackScope scope;
  in.release(in.owner);
}
void give_back(const ParameterList& in) {
  for (const auto& parameter : all_of(in.first, in.count)) give_back(parameter.value);
}
void give_back(const AlabasterDelegateOptions& in) {
  give_back(ParameterList{in.settings, in.setting_count});
}
void give_back(const AlabasterFrame& in) {
  for (const auto* value : {&in.render_tags, &in.roots, &in.excluded}) give_back(*value);
  give_back(ParameterList{in.free_camera, in.free_camera_count});
}

}  // namespace

template <class T>
void ValueReader::give_back_all(const void* given) {
  const T& in = *static_cast<const T*>(given);
  if constexpr (requires { in.size; })
    give_back(members_of(in));
  else
    give_back(in);
}
template void ValueReader::give_back_all<AlabasterValue>(const void*);
template void ValueReader::give_back_all<ParameterList>(const void*);
template void ValueReader::give_back_all<AlabasterDelegateOptions>(const void*);
template void ValueReader::give_back_all<AlabasterFrame>(const void*);

void ValueReader::take() {
  given_ = nullptr;
  for (const auto& loan : loans_) loan->is_taken = true;
  loans_.clear();
}

namespace {
template <class T>
void add_texts(const Value& value, std::vector<const char*>* texts) {
  const auto* array = value.get<Array<T>>();
  if (!array) return;
  for (const T& text : *array) {
    if constexpr (std::is_same_v<T, std::string>)
      texts->push_back(text.c_str());
    else
      texts->push_back(text.str().c_str());
  }
}
}  // namespace

ValueView::ValueView(const Value& value) {
  view_.type = value.type();
  view_.is_array = value.is_array() ? ALABASTER_ARRAY : ALABASTER_SCALAR;
  view_.data = value.data(), view_.count = value.is_array() ? value.count() : 1;
  if (const auto* dictionary = value.get<std::shared_ptr<const Dictionary>>()) {
    if (*dictionary)
      for (const auto& [name, held] : **dictionary) entries_.push_back({name.c_str(), inner_.emplace_back(held).get()});
    view_.data = entries_.data(), view_.count = entries_.size();
  } else if (const auto* samples = value.get<std::shared_ptr<const TimeSamples<Value>>>()) {
    if (*samples)
      for (size_t i = 0; i < (*samples)->values.size(); ++i)
        samples_.push_back({(*samples)->times[i], inner_.emplace_back((*samples)->values[i]).get()});
    view_.data = samples_.data(), view_.count = samples_.size();
  } else if (const auto* text = value.get<std::string>()) {
    view_.data = text->c_str();
  } else if (const auto* token = value.get<Token>()) {
    view_.data = token->str().c_str();
  } else if (const auto* path = value.get<Path>()) {
    view_.data = path->str().c_str();
  } else if (const auto* asset = value.get<AssetPath>()) {
    view_.data = asset->authored.c_str();
  } else if (value.is_array() && GetTypeInfo(value.type()).bytes == 0) {
    add_texts<Token>(value, &texts_);
    add_texts<Path>(value, &texts_);
    add_texts<std::string>(value, &texts_);
    view_.data = texts_.data();
  }
}

void visit_value(const char* name, const Value& value, AlabasterVisit visit, void* user) {
  if (!visit) throw bad_argument("visit is null");
  const ValueView view(value);
  visit(user, name, &view.get());
}
void visit_dictionary(const Dictionary& values, AlabasterVisit visit, void* user) {
  if (!visit) throw bad_argument("visit is null");
  for (const auto& [name, value] : values) visit_value(name.c_str(), value, visit, user);
}

}  // namespace alabaster::hd::c_api
