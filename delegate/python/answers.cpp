#include "delegate/python/answers.h"

#include <cstring>

namespace alabaster::python {
namespace {

struct Layout {
  char kind = 0;  // i: int32, l: int64, u: uint32, f: float, d: double, b: bool; 0: no numbers
  size_t components = 1;

  size_t bytes() const { return components * (kind == 'l' || kind == 'd' ? 8 : kind == 'b' ? 1 : 4); }
};

Layout layout_of(int32_t type) {
  switch (type) {
    case ALABASTER_BOOL:
      return {'b', 1};
    case ALABASTER_INT:
      return {'i', 1};
    case ALABASTER_INT64:
      return {'l', 1};
    case ALABASTER_UINT:
      return {'u', 1};
    case ALABASTER_DOUBLE:
      return {'d', 1};
    case ALABASTER_INT2:
      return {'i', 2};
    case ALABASTER_INT3:
      return {'i', 3};
    case ALABASTER_DOUBLE2:
      return {'d', 2};
    case ALABASTER_DOUBLE3:
      return {'d', 3};
    case ALABASTER_DOUBLE4:
      return {'d', 4};
    case ALABASTER_MATRIX:
      return {'d', 16};
    case ALABASTER_FLOAT:
      return {'f', 1};
    case ALABASTER_FLOAT2:
      return {'f', 2};
    case ALABASTER_FLOAT3:
      return {'f', 3};
    case ALABASTER_FLOAT4:
    case ALABASTER_QUATERNION:
      return {'f', 4};
    default:
      return {};
  }
}

bool is_text(int32_t type) {
  return type == ALABASTER_TOKEN || type == ALABASTER_STRING || type == ALABASTER_PATH || type == ALABASTER_ASSET;
}

template <class T>
T read(const char* at) {
  T value;
  std::memcpy(&value, at, sizeof value);
  return value;
}

py::object number_at(const char* at, char kind) {
  switch (kind) {
    case 'b':
      return py::bool_(*at != 0);
    case 'i':
      return py::int_(read<int32_t>(at));
    case 'l':
      return py::int_(read<int64_t>(at));
    case 'u':
      return py::int_(read<uint32_t>(at));
    case 'f':
      return py::float_(double(read<float>(at)));
    default:
      return py::float_(read<double>(at));
  }
}

py::object element_at(const char* at, const Layout& layout) {
  if (layout.components == 1) return number_at(at, layout.kind);
  const size_t each = layout.bytes() / layout.components;
  py::tuple parts(layout.components);
  for (size_t c = 0; c < layout.components; ++c) parts[c] = number_at(at + c * each, layout.kind);
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
  } else if (const Layout layout = layout_of(type_); layout.kind != 0 && count_ > 0) {
    const auto* first = static_cast<const char*>(value.data);
    numbers_.assign(first, first + count_ * layout.bytes());
  }
}

py::object Answer::to_python() const {
  if (type_ == ALABASTER_DICTIONARY) {
    py::dict entries;
    for (const auto& [name, value] : entries_) entries[name_to_python(name)] = value.to_python();
    return entries;
  }
  const Layout layout = layout_of(type_);
  if (layout.kind == 0 && !is_text(type_)) return py::none();
  const auto one = [&](size_t i) -> py::object {
    return is_text(type_) ? py::object(name_to_python(texts_[i]))
                          : element_at(numbers_.data() + i * layout.bytes(), layout);
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
