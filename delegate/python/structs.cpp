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

template <class Read>
Motion Motion::read(py::handle samples, const std::string& name, const Read& value_of) {
  Motion motion;
  if (samples.is_none()) return motion;
  for (const py::object& sample : items(samples, name)) {
    const std::vector<py::object> pair = items(sample, "each of " + name);
    if (pair.size() != 2) throw py::value_error(name + " is a list of pairs of a time and a value");
    motion.times_.push_back(number(pair[0], "a time of " + name));
    motion.values_.push_back(value_of(pair[1]));
  }
  return motion;
}

Motion Motion::of_arrays(py::handle samples, int32_t type, const std::string& name) {
  return read(samples, name, [&](const py::object& value) { return array(type, value, name); });
}

Motion Motion::of_transforms(py::handle samples, const std::string& name) {
  return read(samples, name, [&](const py::object& value) { return Value(matrix(value, name)); });
}

AlabasterMotion Motion::pass() const {
  raw_.clear();
  for (const Value& value : values_) raw_.push_back(value.pass());
  return {times_.data(), raw_.data(), raw_.size()};
}

Camera::Camera(py::handle options) : transform_(matrix(py::none(), "transform")) {
  for (const auto& [name, value] : entries(options, "camera")) {
    if (name == "transform")
      transform_ = matrix(value, name);
    else if (name == "motion")
      motion_ = Motion::of_transforms(value, name);
    else
      parameters_.emplace_back(name, parameter(value, name));
  }
}

AlabasterCamera Camera::pass() const {
  raw_ = door::pass(parameters_);
  auto camera = door::sized<AlabasterCamera>();
  camera.transform = transform_.data();
  camera.parameters = raw_.data(), camera.parameter_count = raw_.size();
  camera.motion = motion_.pass();
  return camera;
}

}  // namespace alabaster::python
