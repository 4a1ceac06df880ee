#include "delegate/cli/shell_word.h"

#include <cstdio>

namespace alabaster::cli {
namespace {

/// Bytes of the control character that begins at `at`; 0 if another one does.
size_t control_bytes(const std::string& text, size_t at) {
  const auto byte = static_cast<unsigned char>(text[at]);
  if (byte < 32 || byte == 127) return 1;
  const auto next = at + 1 < text.size() ? static_cast<unsigned char>(text[at + 1]) : 0;
  return byte == 0xc2 && next >= 0x80 && next < 0xa0 ? 2 : 0;
}

}  // namespace

std::string shell_word(const std::string& word) {
  constexpr const char* kPlain = "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789_-./,:=+@%";
  if (!word.empty() && word.find_first_not_of(kPlain) == std::string::npos) return word;
  std::string quoted = "'";
  for (const char c : word) quoted += c == '\'' ? std::string("'\\''") : std::string(1, c);
  return quoted + "'";
}

std::string shell_path(const std::string& name) {
  return shell_word(name.starts_with("-") ? "./" + name : name);
}

bool has_control_character(const std::string& text) {
  for (size_t i = 0; i < text.size(); ++i)
    if (control_bytes(text, i) > 0) return true;
  return false;
}

std::string without_control_characters(const std::string& text, const std::string& kept) {
  std::string out;
  for (size_t i = 0; i < text.size(); ++i) {
    const size_t count = control_bytes(text, i);
    if (count == 0 || kept.find(text[i]) != std::string::npos) {
      out += text[i];
      continue;
    }
    i += count - 1;
    char code[16];
    std::snprintf(code, sizeof code, "\\x%02x", unsigned(static_cast<unsigned char>(text[i])));
    out += code;
  }
  return out;
}

}  // namespace alabaster::cli
