#include "delegate/python/structs.h"

#include <pybind11/stl.h>

namespace alabaster::python {

Tokens::Tokens(py::handle texts) : given_(!texts.is_none()) {
  if (py::isinstance<py::str>(texts)) throw py::type_error("a list of texts is expected, and not one text");
  if (given_) held_ = texts.cast<std::vector<std::string>>();
}

AlabasterValue Tokens::pass() const {
  if (!given_) return {};
  raw_.clear();
  for (const std::string& text : held_) raw_.push_back(text.c_str());
  return {ALABASTER_TOKEN, ALABASTER_ARRAY, raw_.data(), raw_.size(), nullptr, nullptr};
}

template <class Read>
Motion Motion::read(py::handle samples, const Read& value_of) {
  Motion motion;
  if (samples.is_none()) return motion;
  for (const py::handle sample : samples) {
    const auto pair = sample.cast<py::tuple>();
    if (pair.size() != 2) throw py::value_error("a motion is a list of pairs of a time and a value");
    motion.times_.push_back(pair[0].cast<double>());
    motion.values_.push_back(value_of(pair[1]));
  }
  return motion;
}

Motion Motion::of_arrays(py::handle samples, int32_t type, const char* name) {
  return read(samples, [&](const py::object& value) { return array(type, value, name); });
}

Motion Motion::of_transforms(py::handle samples) {
  return read(samples, [](const py::object& value) { return Value(matrix(value)); });
}

AlabasterMotion Motion::pass() const {
  raw_.clear();
  for (const Value& value : values_) raw_.push_back(value.pass());
  return {times_.data(), raw_.data(), raw_.size()};
}

Camera::Camera(const py::dict& options)
    : transform_(matrix(options.contains("transform") ? py::object(options["transform"]) : py::none())),
      motion_(Motion::of_transforms(options.contains("motion") ? py::object(options["motion"]) : py::none())) {
  py::dict rest;
  for (const auto& [name, value] : options) {
    const auto key = name.cast<std::string>();
    if (key != "transform" && key != "motion") rest[name] = value;
  }
  parameters_ = python::parameters(rest);
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
