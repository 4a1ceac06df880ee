#include "delegate/api/types.h"

#include <mutex>
#include <unordered_set>

namespace alabaster::hd {
namespace {

// Interned strings are shared by every delegate in the process and never freed: node addresses of an unordered_set are
// stable.
struct TokenTable {
  std::mutex mutex;
  std::unordered_set<std::string> strings;
};
TokenTable& token_table() {
  static auto* table = new TokenTable;
  return *table;
}

}  // namespace

Token::Token(std::string_view text) {
  if (text.empty()) return;
  TokenTable& table = token_table();
  const std::lock_guard lock(table.mutex);
  rep_ = &*table.strings.emplace(text).first;
}

const std::string& Token::str() const {
  static const std::string empty;
  return rep_ ? *rep_ : empty;
}

bool Path::has_prefix(const Path& prefix) const {
  const std::string &s = str(), &p = prefix.str();
  if (s.compare(0, p.size(), p) != 0) return false;
  return s.size() == p.size() || p.empty() || p.back() == '/' || s[p.size()] == '/';
}

}  // namespace alabaster::hd
