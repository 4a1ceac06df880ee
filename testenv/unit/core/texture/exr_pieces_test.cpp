// EXR files whose compressed pieces hold less than their pixels. OpenEXR would show memory as it was.
#include <zlib.h>

#include <algorithm>
#include <bit>

#include "testenv/support/texture_file.h"

namespace alabaster {
namespace {

using testing::noise;
using testing::TextureFile;

using Bytes = std::vector<uint8_t>;

constexpr uint32_t kWidth = 24, kHeight = 20, kRowBytes = kWidth * 3 * 2;  // R, G and B as halves
constexpr uint8_t kNone = 0, kRle = 1, kZips = 2, kZip = 3, kPiz = 4, kPxr24 = 5, kB44 = 6, kB44a = 7, kDwaa = 8;

void add(Bytes& to, uint64_t value, size_t bytes) {
  for (size_t i = 0; i < bytes; ++i) to.push_back(uint8_t(value >> (8 * i)));
}
void add(Bytes& to, const std::string& text) {
  to.insert(to.end(), text.begin(), text.end());
  to.push_back(0);
}
void add_attribute(Bytes& to, const std::string& name, const std::string& type, const Bytes& value) {
  add(to, name);
  add(to, type);
  add(to, value.size(), 4);
  to.insert(to.end(), value.begin(), value.end());
}

/// The attributes that every header has.
void add_required(Bytes& file, const Bytes& channels, uint8_t compression, const Bytes& window) {
  add_attribute(file, "channels", "chlist", channels);
  add_attribute(file, "compression", "compression", {compression});
  add_attribute(file, "dataWindow", "box2i", window);
  add_attribute(file, "displayWindow", "box2i", window);
  add_attribute(file, "lineOrder", "lineOrder", {0});
  add_attribute(file, "pixelAspectRatio", "float", {0, 0, 0x80, 0x3f});
  add_attribute(file, "screenWindowCenter", "v2f", Bytes(8, 0));
  add_attribute(file, "screenWindowWidth", "float", {0, 0, 0x80, 0x3f});
}

Bytes header(uint8_t compression) {
  Bytes channels, window;
  for (const char* name : {"B", "G", "R"}) {
    add(channels, name);
    for (const uint32_t value : {1u, 0u, 1u, 1u}) add(channels, value, 4);
  }
  channels.push_back(0);
  for (const uint32_t value : {0u, 0u, kWidth - 1, kHeight - 1}) add(window, value, 4);
  Bytes file;
  add(file, 20000630, 4);
  add(file, 2, 4);
  add_required(file, channels, compression, window);
  file.push_back(0);
  return file;
}

/// A file whose pieces are all `piece`, `lines` rows each.
Bytes file_of(uint8_t compression, uint32_t lines, const Bytes& piece) {
  Bytes file = header(compression), pieces;
  const uint32_t count = (kHeight + lines - 1) / lines;
  const size_t first = file.size() + 8 * size_t(count);
  for (uint32_t i = 0; i < count; ++i) {
    add(file, first + pieces.size(), 8);
    add(pieces, uint64_t(i) * lines, 4);
    add(pieces, piece.size(), 4);
    pieces.insert(pieces.end(), piece.begin(), piece.end());
  }
  file.insert(file.end(), pieces.begin(), pieces.end());
  return file;
}

Bytes deflated(size_t zeros) {
  const Bytes raw(zeros, 0);
  Bytes result(compressBound(uLong(zeros)));
  uLongf size = uLongf(result.size());
  EXPECT_EQ(compress(result.data(), &size, raw.data(), uLong(zeros)), Z_OK);
  result.resize(size);
  return result;
}

/// DWA, version 2, without rules, so that no channel is of a known kind. `zeros`: the number of their bytes that is
/// stored.
Bytes dwa(uint64_t claimed, size_t zeros) {
  const Bytes stored = deflated(zeros);
  Bytes piece;
  for (const uint64_t count : {uint64_t(2), claimed, uint64_t(stored.size())}) add(piece, count, 8);
  piece.resize(11 * 8, 0);
  add(piece, 2, 2);
  piece.insert(piece.end(), stored.begin(), stored.end());
  return piece;
}

class ExrPieces : public TextureFile {
 protected:
  void expect_refused(uint8_t compression, uint32_t lines, const Bytes& piece) {
    EXPECT_FALSE(load(spit("short.exr", file_of(compression, lines, piece))))
        << "compression " << int(compression) << ", " << piece.size() << " bytes";
    ASSERT_EQ(reports_.all.size(), 1u);
    EXPECT_NE(reports_.text().find("is missing or too short"), std::string::npos) << reports_.text();
  }
  void expect_read(uint8_t compression, uint32_t lines, const Bytes& piece) {
    EXPECT_TRUE(load(spit("whole.exr", file_of(compression, lines, piece)))) << int(compression) << reports_.text();
  }
};

TEST_F(ExrPieces, EmptyPiecesAreRefused) {
  for (const uint8_t compression : {kNone, kRle, kZips}) expect_refused(compression, 1, {});
  for (const uint8_t compression : {kZip, kPxr24}) expect_refused(compression, 16, {});
  for (const uint8_t compression : {kPiz, kB44, kB44a, kDwaa}) expect_refused(compression, 32, {});
}

// promise: security.image_memory
TEST_F(ExrPieces, TooShortPiecesAreRefused) {
  expect_read(kNone, 1, Bytes(kRowBytes, 0));
  expect_refused(kNone, 1, Bytes(kRowBytes - 2, 0));
  expect_read(kZips, 1, deflated(kRowBytes));
  expect_refused(kZips, 1, deflated(kRowBytes - 2));
  expect_refused(kZips, 1, deflated(0));
  expect_refused(kZip, 16, deflated(kRowBytes));  // of sixteen rows
  expect_read(kRle, 1, {127, 0, 15, 0});          // 128 bytes, and 16
  expect_refused(kRle, 1, {127, 0, 14, 0});
  expect_refused(kRle, 1, {0x90, 0, 0});
}

TEST_F(ExrPieces, DwaPiecesAreMeasuredAsStored) {
  const size_t whole = size_t(kRowBytes) * kHeight;
  expect_read(kDwaa, 32, dwa(whole, whole));
  expect_refused(kDwaa, 32, dwa(0, 0));
  expect_refused(kDwaa, 32, dwa(whole, whole - 2));
}

constexpr uint32_t kTileWidth = 16, kTileHeight = 12;

/// A level of `w` by `h` floats in tiles, and the places of its tiles. Pixel (i, j) of level 0 is i + 100 j, others -1.
void add_level(uint32_t level, uint32_t w, uint32_t h, Bytes& pieces, std::vector<size_t>& places) {
  for (uint32_t top = 0; top < h; top += kTileHeight)
    for (uint32_t left = 0; left < w; left += kTileWidth) {
      places.push_back(pieces.size());
      const uint32_t right = std::min(w, left + kTileWidth), bottom = std::min(h, top + kTileHeight);
      for (const uint32_t value : {left / kTileWidth, top / kTileHeight, level, level}) add(pieces, value, 4);
      add(pieces, 4 * uint64_t(right - left) * (bottom - top), 4);
      for (uint32_t j = top; j < bottom; ++j)
        for (uint32_t i = left; i < right; ++i)
          add(pieces, std::bit_cast<uint32_t>(level == 0 ? float(i + 100 * j) : -1.0f), 4);
    }
}

/// A tiled file without compression, with levels or without: `width` by `height` pixels from (x, y) on.
Bytes tiled(uint32_t width, uint32_t height, int32_t x, int32_t y, bool levels) {
  Bytes channels, window, tiles, file, pieces;
  add(channels, "Y");
  for (const uint32_t value : {2u, 0u, 1u, 1u}) add(channels, value, 4);
  channels.push_back(0);
  for (const uint32_t value : {uint32_t(x), uint32_t(y), uint32_t(x) + width - 1, uint32_t(y) + height - 1})
    add(window, value, 4);
  add(tiles, kTileWidth, 4), add(tiles, kTileHeight, 4), tiles.push_back(levels ? 1 : 0);
  add(file, 20000630, 4), add(file, 2 | 0x200, 4);
  add_required(file, channels, kNone, window);
  add_attribute(file, "tiles", "tiledesc", tiles);
  file.push_back(0);
  std::vector<size_t> places;
  add_level(0, width, height, pieces, places);
  for (uint32_t l = 1; levels && (std::max(width, height) >> l) > 0; ++l)
    add_level(l, std::max(1u, width >> l), std::max(1u, height >> l), pieces, places);
  const size_t first = file.size() + 8 * places.size();
  for (const size_t place : places) add(file, first + place, 8);
  file.insert(file.end(), pieces.begin(), pieces.end());
  return file;
}

// CVE-2026-63422: rows of tiles at the edge were written as whole tiles, beyond the reader's buffer.
TEST_F(ExrPieces, TilesThatTheEdgeCutsAreRead) {
  const std::pair<uint32_t, uint32_t> sizes[] = {{17, 13}, {31, 23}, {5, 3}, {1, 25}, {33, 12}, {16, 1}};
  for (const auto& [width, height] : sizes)
    for (const auto& [x, y] : {std::pair(0, 0), std::pair(-7, 5), std::pair(1000, -1000)})
      for (const bool levels : {false, true}) {
        const auto texture = load(spit("edge.exr", tiled(width, height, x, y, levels)));
        ASSERT_TRUE(texture) << width << "x" << height << reports_.text();
        for (const int j : {0, int(height) - 1})
          for (const int i : {0, int(width) - 1})
            EXPECT_EQ(texture->texel(i, j).r, float(i + 100 * j)) << width << "x" << height << " at " << x << "," << y;
      }
}

// As OpenEXR writes them: pieces that are not compressed because that would make them longer, the last rows, windows
// that begin anywhere, channels of several types, tiles.
TEST_F(ExrPieces, PiecesWrittenByOpenExrAreRead) {
  for (const char* compression : {"none", "rle", "zips", "zip", "piz", "pxr24", "b44", "b44a", "dwaa", "dwab"})
    for (const bool is_noise : {false, true})
      for (const int tile : {0, 16}) {
        OIIO::ImageSpec spec(67, 45, 6, OIIO::TypeHalf);
        spec.x = -5, spec.y = 7;
        spec.channelnames = {"R", "G", "B", "A", "Z", "layer.r"};
        spec.channelformats = {OIIO::TypeHalf, OIIO::TypeHalf,  OIIO::TypeHalf,
                               OIIO::TypeHalf, OIIO::TypeFloat, OIIO::TypeFloat};
        spec.tile_width = spec.tile_height = tile;
        if (tile > 0) spec.tile_depth = 1;
        spec.attribute("compression", compression);
        const std::vector<float> pixels = is_noise ? noise(67 * 45 * 6) : std::vector<float>(67 * 45 * 6, 0.25f);
        const auto out = OIIO::ImageOutput::create("x.exr");
        ASSERT_TRUE(out->open(path("x.exr"), spec) && out->write_image(OIIO::TypeFloat, pixels.data()) && out->close())
            << out->geterror();
        EXPECT_TRUE(load(path("x.exr"))) << compression << ", tiles of " << tile << ": " << reports_.text();
      }
}

TEST_F(ExrPieces, PiecesMissingFromTheOffsetTableAreRefused) {
  const Bytes good = file_of(kNone, 1, Bytes(kRowBytes, 0));
  const size_t table = header(kNone).size();
  for (const uint64_t place : {uint64_t(0), uint64_t(good.size()), uint64_t(good.size() - 4), ~uint64_t(0),
                               uint64_t(table + 8 * kHeight)}) {  // the first row's, for the second
    Bytes file = good;
    for (size_t i = 0; i < 8; ++i) file[table + 8 + i] = uint8_t(place >> (8 * i));
    EXPECT_FALSE(load(spit("table.exr", file))) << place;
    EXPECT_NE(reports_.text().find("piece 1 is missing"), std::string::npos) << reports_.text();
  }
}

}  // namespace
}  // namespace alabaster
