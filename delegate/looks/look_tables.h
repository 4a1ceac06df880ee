// One table for each look: our parameter by a formula of its inputs. Internal to this room.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "delegate/looks/signal.h"

namespace alabaster::hd::looks {

struct LookInput {
  LookInput(const char* name_, float initial_ = 0, bool may_be_word_ = false)  // NOLINT(google-explicit-constructor)
      : LookInput(name_, Vec3f(initial_)) {
    may_be_word = may_be_word_;
  }
  LookInput(const char* name_, const Vec3f& initial_) : name(name_), initial(initial_) {}

  const char* name;
  Vec3f initial;  // the definition's default; of a number: three times
  bool may_be_word = false;
};

/// The inputs of a row.
class Terms {
 public:
  using Tell = std::function<void(const std::string& text)>;
  Terms(const std::vector<LookInput>& inputs, std::vector<Signal> signals, std::vector<std::string> words, float factor,
        const Tell& tell)
      : inputs_(inputs), signals_(std::move(signals)), words_(std::move(words)), factor_(factor), tell_(tell) {}

  const Signal& operator[](size_t i) const { return signals_[i]; }
  size_t size() const { return signals_.size(); }
  float factor() const { return factor_; }
  /// The constant of what cannot be textured here: a texture is told.
  Vec3f color(size_t i) const;
  float number(size_t i) const { return color(i).x; }
  const std::string& word(size_t i) const { return words_[i]; }  // of a value that is text
  void tell(const std::string& text) const { tell_(text); }

 private:
  const std::vector<LookInput>& inputs_;
  std::vector<Signal> signals_;
  std::vector<std::string> words_;
  float factor_;
  const Tell& tell_;
};
using Formula = Signal (*)(const Terms& in);

/// The product of the row's inputs and its factor.
Signal product_of(const Terms& in);
/// A map of normals in tangent space.
Signal normals_of(const Terms& in);

/// Targets are parameters of AlabasterDisney, or what ReadLook joins to some, because AlabasterDisney has no lobe for
/// it: transmissionColor, transmissionDepth, transmissionScatter, transmissionAnisotropy.
struct LookRow {
  const char* target;
  std::vector<LookInput> inputs;
  const char* when = nullptr;  // the weight without which the row is not read
  Formula formula = product_of;
  float factor = 1;
};

/// An input that is drawn as if it had a certain value, and told where it has another.
struct ToldInput {
  LookInput input;
  float drawn = 0;
  const char* when = nullptr;
};

struct Look {
  std::vector<const char*> types;  // of the surface node
  std::vector<LookRow> rows;
  std::vector<ToldInput> told;
  std::vector<const char*> ignored = {};  // inputs without an effect in a path tracer
  bool has_others = false;                // inputs that are not in the table are not told
};
const std::vector<Look>& look_tables();

}  // namespace alabaster::hd::looks
