#include "delegate/rendering/checkpoint_header.h"

#include <algorithm>
#include <array>
#include <type_traits>
#include <utility>

namespace alabaster::hd::rendering {
namespace {

using nlohmann::json;

constexpr size_t kMemberBytes = 256;  // of memory, for a name and a value, beside their text
constexpr size_t kMostNamed = 1000;   // members of an object, but for the scene's, of which each has a digest
constexpr size_t kDigestBytes = 32;   // of text: core/digest/digest.h
constexpr size_t kRange = 2;          // numbers of `samples`

/// Builds the header, and stops the parser at the first thing that no header has.
class HeaderBuilder : public nlohmann::json_sax<json> {
 public:
  HeaderBuilder(MemoryReservation* held, CheckpointHeader* header) : held_(*held), header_(*header) {}

  bool null() override { return false; }
  bool boolean(bool value) override { return depth_ == 1 && name_ == "complete" && put(value); }
  bool number_integer(number_integer_t) override { return false; }
  bool number_unsigned(number_unsigned_t value) override {
    if (!in_range_ || header_["samples"].size() == kRange) return false;
    header_["samples"].push_back(value);
    return true;
  }
  bool number_float(number_float_t, const string_t&) override { return false; }
  bool string(string_t& value) override {
    if (in_range_) return false;
    if (depth_ == 1) return (name_ == "aovs" || (name_ == "note" && value.size() <= kMostNoteBytes)) && put(value);
    if (depth_ != 2 || (is_scene() && value.size() != kDigestBytes)) return false;
    return put(value);
  }
  bool binary(binary_t&) override { return false; }
  bool start_object(size_t) override {
    constexpr std::array kObjects = {"library", "scene", "frame", "settings"};
    if (depth_ == 1 && std::find(kObjects.begin(), kObjects.end(), name_) == kObjects.end()) return false;
    if (++depth_ > 2 || in_range_) return false;
    at_ = depth_ == 1 ? &header_ : &header_[name_];
    *at_ = json::object();
    if (depth_ == 2) object_ = name_;
    return true;
  }
  bool key(string_t& name) override {
    if (at_->contains(name) || (!is_scene() && at_->size() == kMostNamed)) return false;
    name_ = name;
    bytes_ += kMemberBytes + name.size();
    return true;
  }
  bool end_object() override {
    if (--depth_ == 1) at_ = &header_, object_.clear();
    return true;
  }
  bool start_array(size_t) override {
    if (depth_ != 1 || name_ != "samples" || in_range_) return false;
    in_range_ = true;
    header_["samples"] = json::array();
    return true;
  }
  bool end_array() override {
    in_range_ = false;
    return true;
  }
  bool parse_error(size_t, const std::string&, const nlohmann::detail::exception&) override { return false; }

 private:
  bool is_scene() const { return depth_ == 2 && object_ == "scene"; }
  // The budget is asked now and then.
  template <class T>
  bool put(const T& value) {
    constexpr size_t kStep = size_t(1) << 16;
    if constexpr (std::is_same_v<T, string_t>) bytes_ += value.size();
    if (bytes_ > kStep) held_.resize(held_.bytes() + std::exchange(bytes_, 0), "the header of a checkpoint");
    (*at_)[name_] = value;
    return true;
  }

  MemoryReservation& held_;
  CheckpointHeader& header_;
  json* at_ = nullptr;  // the object that is read
  std::string name_, object_;
  int depth_ = 0;
  bool in_range_ = false;
  size_t bytes_ = 0;  // that are not held yet
};

}  // namespace

std::string parse_checkpoint_header(std::string_view text, MemoryReservation* held, CheckpointHeader* header) {
  HeaderBuilder builder(held, header);
  if (json::sax_parse(text.begin(), text.end(), &builder) && header->is_object()) return {};
  *header = json::object();
  return "it is damaged: its header does not describe a render";
}

}  // namespace alabaster::hd::rendering
