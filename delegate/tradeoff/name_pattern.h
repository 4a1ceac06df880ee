// Patterns for names, as people type them: POSIX extended regular expressions without what makes them slow.
#pragma once

#include <memory>
#include <string>

namespace alabaster::tradeoff {

/// A pattern matches in time proportional to its length times the name's, whatever it is: it is at most 500 bytes long
/// and has neither back references nor counts ("{3}"), nor a + after a group or a repetition ("(a|b)+").
class NamePattern {
 public:
  explicit NamePattern(const std::string& text);
  /// The pattern's fault with its remedy; empty if it has none.
  const std::string& fault() const { return fault_; }
  /// True if a part of `name` matches, or if the pattern is empty. False for a faulty pattern.
  bool matches(const std::string& name) const;

 private:
  struct Compiled;
  std::shared_ptr<const Compiled> compiled_;
  std::string fault_;
};

}  // namespace alabaster::tradeoff
