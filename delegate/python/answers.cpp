#include "delegate/python/answers.h"

#include "delegate/python/values.h"

namespace alabaster::python {
namespace {

bool is_text(int32_t type) {
  return type == ALABASTER_TOKEN || type == ALABASTER_STRING || type == ALABASTER_PATH || type == ALABASTER_ASSET;
}

py::object number_at(const char* at, const Element& element) {
  if (element.kind == 'f') return py::float_(real_at(at, element));
  const int64_t number = integer_at(at, element);
  return element.bytes == 1 ? py::object(py::bool_(number != 0)) : py::object(py::int_(number));
}

py::object value_at(const char* at, const Elements& elements) {
  if (elements.components == 1) return number_at(at, elements.of);
  py::tuple parts(elements.components);
  for (size_t c = 0; c < elements.components; ++c) parts[c] = number_at(at + c * elements.of.bytes, elements.of);
  return parts;
}

py::str decoded(const std::string& text, const char* errors) {
  PyObject* const made = PyUnicode_DecodeUTF8(text.data(), Py_ssize_t(text.size()), errors);
  if (!made) throw py::error_already_set();
  return py::reinterpret_steal<py::str>(made);
}

}  // namespace

Answer::Answer(const AlabasterValue& value)
    : type_(value.type), is_array_(value.is_array != 0), count_(value.is_array ? value.count : 1) {
  if (type_ == ALABASTER_DICTIONARY) {
    const auto* held = static_cast<const AlabasterParameter*>(value.data);
    for (size_t i = 0; i < value.count; ++i) entries_.emplace_back(held[i].name, Answer(held[i].value));
  } else if (is_text(type_)) {
    for (size_t i = 0; i < count_; ++i)
      texts_.emplace_back(is_array_ ? static_cast<const char* const*>(value.data)[i]
                                    : static_cast<const char*>(value.data));
  } else if (const Elements elements = elements_of(type_); elements.components > 0 && count_ > 0) {
    const auto* first = static_cast<const char*>(value.data);
    numbers_.assign(first, first + count_ * elements.bytes());
  }
}

py::object Answer::to_python() const {
  if (type_ == ALABASTER_DICTIONARY) {
    py::dict entries;
    for (const auto& [name, value] : entries_) entries[name_to_python(name)] = value.to_python();
    return entries;
  }
  const Elements elements = elements_of(type_);
  if (elements.components == 0 && !is_text(type_)) return py::none();
  const auto one = [&](size_t i) -> py::object {
    return is_text(type_) ? py::object(name_to_python(texts_[i]))
                          : value_at(numbers_.data() + i * elements.bytes(), elements);
  };
  if (!is_array_) return one(0);
  py::list all;
  for (size_t i = 0; i < count_; ++i) all.append(one(i));
  return all;
}

void keep_answer(void* user, const char* name, const AlabasterValue* value) {
  static_cast<Answers*>(user)->emplace_back(name, Answer(*value));
}

py::str name_to_python(const std::string& name) {
  return decoded(name, "surrogateescape");
}
py::str message_to_python(const std::string& text) {
  return decoded(text, "backslashreplace");
}

}  // namespace alabaster::python
