#include <algorithm>
#include <cctype>
#include <filesystem>

#include "core/files/input_file.h"
#include "core/files/real_path.h"
#include "delegate/gltf/gltf_container.h"

namespace alabaster::hd::gltf {
namespace {

int base64_digit(char c) {
  if (c >= 'A' && c <= 'Z') return c - 'A';
  if (c >= 'a' && c <= 'z') return c - 'a' + 26;
  if (c >= '0' && c <= '9') return c - '0' + 52;
  if (c == '+') return 62;
  if (c == '/') return 63;
  return -1;
}

// RFC 4648 section 4. Missing padding is accepted because exporters omit it; any other deviation is an error.
bool decode_base64(std::string_view text, std::vector<uint8_t>* bytes) {
  for (int padding = 0; padding < 2 && !text.empty() && text.back() == '='; ++padding) text.remove_suffix(1);
  if (text.size() % 4 == 1) return false;
  bytes->reserve(text.size() / 4 * 3 + 2);
  uint32_t bits = 0;
  int held = 0;
  for (const char c : text) {
    const int digit = base64_digit(c);
    if (digit < 0) return false;
    bits = (bits << 6 | uint32_t(digit)) & 0xffffff;
    held += 6;
    if (held >= 8) {
      held -= 8;
      bytes->push_back(uint8_t(bits >> held & 0xff));
    }
  }
  return true;
}

int hex_digit(char c) {
  if (c >= '0' && c <= '9') return c - '0';
  if (c >= 'a' && c <= 'f') return c - 'a' + 10;
  if (c >= 'A' && c <= 'F') return c - 'A' + 10;
  return -1;
}

// RFC 3986 section 2.1. A % without two hexadecimal digits stands for itself: exporters write names as they are.
std::string percent_decode(std::string_view uri) {
  std::string text;
  for (size_t i = 0; i < uri.size(); ++i) {
    const bool escapes = uri[i] == '%' && i + 2 < uri.size();
    const int high = escapes ? hex_digit(uri[i + 1]) : -1, low = escapes ? hex_digit(uri[i + 2]) : -1;
    if (high < 0 || low < 0) {
      text.push_back(uri[i]);
      continue;
    }
    text.push_back(char(high * 16 + low));
    i += 2;
  }
  return text;
}

bool is_media_type_character(char c) {
  return std::isalnum(static_cast<unsigned char>(c)) != 0 || std::string_view("/.+-_=\"'").find(c) != std::string::npos;
}

}  // namespace

std::optional<DataUri> decode_data_uri(std::string_view uri, std::string* reason) {
  const size_t comma = uri.find(',');
  if (!is_data_uri(uri) || comma == std::string_view::npos) {
    *reason = "the data URI has no payload; write data:<type>;base64,<data>";
    return {};
  }
  const std::string_view head = uri.substr(5, comma - 5);
  constexpr std::string_view kEncoding = ";base64";
  if (head.size() < kEncoding.size() || head.substr(head.size() - kEncoding.size()) != kEncoding) {
    *reason = "the data URI is not base64; write data:<type>;base64,<data>";
    return {};
  }
  std::string type(head.substr(0, head.size() - kEncoding.size()));
  const bool empty_parameter = !type.empty() && (type.back() == ';' || type.find(";;") != std::string::npos);
  type.resize(std::min(type.find(';'), type.size()));
  if (empty_parameter || !std::all_of(type.begin(), type.end(), is_media_type_character)) {
    *reason = "the data URI's media type is malformed; write data:<type>;base64,<data>";
    return {};
  }
  std::transform(type.begin(), type.end(), type.begin(), [](unsigned char c) { return char(std::tolower(c)); });
  DataUri data{type, {}};
  std::string_view payload = uri.substr(comma + 1);
  std::string decoded;
  if (payload.find('%') != std::string_view::npos) payload = decoded = percent_decode(payload);
  if (!decode_base64(payload, &data.bytes)) {
    *reason = "the data URI's payload is not base64; encode the data again";
    return {};
  }
  return data;
}

std::optional<std::string> resolve_uri(const UriBase& base, std::string_view uri, std::string* reason) {
  std::string path = percent_decode(uri);
  if (path.empty() || path.find('\0') != std::string::npos) {
    *reason = "the URI names no file; write a relative path";
    return {};
  }
  // A colon before the first slash ends a scheme (RFC 3986, section 4.2).
  const size_t colon = uri.find(':');
  std::string foreign = foreign_name(path);
  if (foreign.empty() && colon != std::string_view::npos && colon < uri.find('/'))
    foreign = foreign_name(path.substr(0, colon + 1));
  const bool is_share = path.starts_with("\\\\"), has_backslashes = path.find('\\') != std::string::npos;
  if (!foreign.empty() && (is_share || !has_backslashes || colon != std::string_view::npos)) {
    *reason = "'" + std::string(uri.substr(0, 200)) + "': " + foreign;
    return {};
  }
  std::replace(path.begin(), path.end(), '\\', '/');
  const std::filesystem::path relative = std::filesystem::path(path).lexically_normal();
  std::string file = (std::filesystem::path(base.folder) / relative).string();
  if (base.within.empty()) return file;
  *reason = outside_fault(base.within, file);
  if (!reason->empty()) *reason = (path.starts_with('/') ? "the URI is an absolute path: " : "") + *reason;
  if (!reason->empty()) return {};
  return file;
}

}  // namespace alabaster::hd::gltf
