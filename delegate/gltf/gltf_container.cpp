#include "delegate/gltf/gltf_container.h"

#include "core/files/input_file.h"
#include "delegate/support/json_bounds.h"

namespace alabaster::hd::gltf {
namespace {

// Deeper JSON would overflow the stack of recursive readers. glTF itself needs about ten levels, extras rarely more.
constexpr size_t kMostDepth = 128;
// Commas and brackets outside of strings.
constexpr size_t kMostValues = 10'000'000;
// A parsed JSON value takes up to three hundred bytes while the document is read, beside three copies of its text.
constexpr size_t kValueBytes = 300;

constexpr uint32_t kMagic = 0x46546C67, kJsonChunk = 0x4E4F534A, kBinaryChunk = 0x004E4942;  // glTF 2.0, section 4.4

uint32_t read_u32(const uint8_t* p) {
  return uint32_t(p[0]) | uint32_t(p[1]) << 8 | uint32_t(p[2]) << 16 | uint32_t(p[3]) << 24;
}

bool json_is_bounded(std::string_view text, MemoryReservation* memory, Report& report) {
  const support::JsonBounds bounds = support::bounds_of_json(text, kMostDepth);
  if (bounds.too_deep_at != std::string_view::npos) {
    report.error("json.depth", "",
                 "the JSON is nested deeper than " + std::to_string(kMostDepth) + " levels at byte " +
                     std::to_string(bounds.too_deep_at) + "; flatten it");
    return false;
  }
  if (bounds.values > kMostValues) {
    report.error("json.size", "", "the JSON holds too many values; store bulk data in buffers");
    return false;
  }
  hold_more(memory, bounds.values * kValueBytes + 3 * text.size(),
            "JSON of " + std::to_string(bounds.values) + " values");
  return true;
}

bool parse_json(std::string_view text, MemoryReservation* memory, Report& report, Json* root) {
  if (text.substr(0, 3) == "\xEF\xBB\xBF") {
    report.warning("json.bom", "", "the JSON begins with a byte order mark, which glTF forbids; remove it");
    text.remove_prefix(3);
  }
  const size_t begin = text.find_first_not_of(" \t\r\n");
  if (begin == std::string_view::npos || text[begin] != '{') {
    report.error("json.root", "", "begins with neither '{' nor 'glTF', so this is no glTF document; export it again");
    return false;
  }
  if (!json_is_bounded(text, memory, report)) return false;
  try {
    *root = Json::parse(text.begin(), text.end());
  } catch (const Json::exception& e) {
    std::string what = e.what();  // "[json.exception.parse_error.101] parse error at line 1, ..."
    if (const size_t bracket = what.find("] "); what.starts_with('[') && bracket != std::string::npos)
      what = what.substr(bracket + 2);
    report.error("json.syntax", "", "not valid JSON (" + what.substr(0, 300) + "); export the file again");
    return false;
  }
  return true;
}

struct Chunk {
  uint32_t type = 0;
  size_t begin = 0, size = 0;
};

// The chunks of a GLB, each inside the file. Empty after an error.
std::vector<Chunk> glb_chunks(const std::vector<uint8_t>& file, Report& report) {
  const auto fail = [&](const std::string& text) {
    report.error("glb", "", text + "; the file is damaged, export it again");
    return std::vector<Chunk>();
  };
  if (file.size() < 12) return fail("the GLB header is incomplete");
  if (read_u32(&file[4]) == 1) {
    report.error("version", "", kIsVersion1);
    return {};
  }
  if (read_u32(&file[4]) != 2) {
    return fail("GLB version " + std::to_string(read_u32(&file[4])) + " is not supported, only version 2");
  }
  const size_t length = read_u32(&file[8]);
  if (length > file.size()) return fail("the GLB header declares more bytes than the file has");
  if (length < 12) return fail("the GLB header declares a length shorter than itself");
  if (length < file.size()) report.warning("glb.length", "", "bytes after the end of the GLB are ignored");
  std::vector<Chunk> chunks;
  for (size_t at = 12; at < length;) {
    if (length - at < 8) return fail("a GLB chunk header is incomplete");
    const Chunk chunk{read_u32(&file[at + 4]), at + 8, read_u32(&file[at])};
    if (chunk.size > length - chunk.begin)
      return fail("GLB chunk " + std::to_string(chunks.size()) + " exceeds the file");
    if (chunk.size % 4 != 0) report.warning("glb.padding", "", "a GLB chunk's length is not a multiple of 4");
    chunks.push_back(chunk);
    at = chunk.begin + chunk.size;
  }
  if (chunks.empty() || chunks[0].type != kJsonChunk) return fail("the first GLB chunk is not JSON");
  if (chunks[0].size == 0) return fail("the GLB's JSON chunk is empty");
  return chunks;
}

bool read_glb(const std::vector<uint8_t>& file, MemoryReservation* memory, Report& report, Container* container) {
  const std::vector<Chunk> chunks = glb_chunks(file, report);
  if (chunks.empty()) return false;
  for (size_t i = 1; i < chunks.size(); ++i) {
    const Chunk& chunk = chunks[i];
    if (chunk.type == kJsonChunk || (chunk.type == kBinaryChunk && i > 1)) {
      report.error("glb.duplicate", "",
                   "GLB chunk " + std::to_string(i) + " repeats a chunk or is out of order; " +
                       "the file is damaged, export it again");
      return false;
    }
    if (chunk.type != kBinaryChunk) {
      report.warning("glb.chunk", "", "GLB chunk " + std::to_string(i) + " has an unknown type and is ignored");
      continue;
    }
    hold_more(memory, chunk.size, "the binary chunk");
    const auto begin = file.begin() + std::ptrdiff_t(chunk.begin);
    container->binary_chunk = std::make_shared<const std::vector<uint8_t>>(begin, begin + std::ptrdiff_t(chunk.size));
  }
  const auto* text = reinterpret_cast<const char*>(file.data()) + chunks[0].begin;
  return parse_json({text, chunks[0].size}, memory, report, &container->root);
}

}  // namespace

const Json& at(const Json& object, std::string_view name) {
  static const Json kNone;
  const auto found = object.find(name);
  return found == object.end() ? kNone : *found;
}

Bytes read_file(const FileToRead& file, MemoryReservation* memory, std::string* reason) {
  const InputFile input(file.name, file.within);
  *reason = input.reason();
  if (!input) return nullptr;
  hold_more(memory, input.size(), "'" + file.name + "'");
  auto bytes = std::make_shared<std::vector<uint8_t>>();
  if (input.read(bytes.get())) return bytes;
  *reason = "the file could not be read to its end; check the disk";
  return nullptr;
}

bool read_container(const FileToRead& file, MemoryReservation* memory, Report& report, Container* container) {
  std::string reason;
  const Bytes bytes = read_file(file, memory, &reason);
  if (!bytes) {
    report.error("file", "", reason);
    return false;
  }
  container->is_glb = bytes->size() >= 4 && read_u32(bytes->data()) == kMagic;
  if (bytes->empty()) {
    report.error("json.syntax", "", "the file is empty; export it again");
    return false;
  }
  const std::string_view text(reinterpret_cast<const char*>(bytes->data()), bytes->size());
  const bool good = container->is_glb ? read_glb(*bytes, memory, report, container)
                                      : parse_json(text, memory, report, &container->root);
  memory->shrink(memory->bytes() - bytes->size());
  return good;
}

}  // namespace alabaster::hd::gltf
