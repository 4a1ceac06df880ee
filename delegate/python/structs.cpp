#include "delegate/python/structs.h"

#include <algorithm>

namespace alabaster::python {

int32_t length_of(py::handle value, const std::string& name) {
  const int32_t length = whole(value, name);
  if (length < 0)
    throw py::value_error(name + " is " + std::to_string(length) +
                          "; it must be at least 1, or 0 for that of the render settings");
  return length;
}

AlabasterRect rect_of(py::handle value, const std::string& name) {
  if (value.is_none()) return {};
  const std::vector<py::object> sides = items(value, name);
  if (sides.size() != 4) throw py::value_error(name + " must be (min_x, min_y, max_x, max_y)");
  std::array<int32_t, 4> read{};
  std::transform(sides.begin(), sides.end(), read.begin(),
                 [&](const py::object& side) { return whole(side, "each of " + name); });
  return {read[0], read[1], read[2], read[3]};
}

Tokens::Tokens(py::handle texts, const std::string& name) : given_(!texts.is_none()) {
  if (given_) held_ = python::texts(texts, name);
}

AlabasterValue Tokens::pass() const {
  if (!given_) return {};
  raw_.clear();
  for (const std::string& text : held_) raw_.push_back(text.c_str());
  return {ALABASTER_TOKEN, ALABASTER_ARRAY, raw_.data(), raw_.size(), nullptr, nullptr};
}

}  // namespace alabaster::python
