// Brings pixels of render buffers into memory that can be drawn, in a thread of its own: the thread of the window never
// waits for a picture or for the denoiser.
#pragma once

#include <chrono>
#include <condition_variable>
#include <mutex>
#include <thread>
#include <vector>

#include "delegate/view/data_view.h"

namespace alabaster::view {

/// Eight bits RGBA for a display, the uppermost row first.
struct Picture {
  hd::Vec2i size{0, 0};
  std::vector<uint8_t> rgba;
  uint64_t number = 0;  // rises when pixels change
};

/// Brings `pixels`, rows of `components` of T, up to date with the buffer. False: it shows nothing yet.
template <class T>
bool resolve(hd::RenderBuffer* buffer, size_t components, hd::PixelMemory* memory, std::vector<T>* pixels) {
  constexpr int kMostTries = 3;  // the buffer may get another size meanwhile
  for (int tries = 0; tries < kMostTries && !buffer->ResolveTo(memory); ++tries) {
    pixels->resize(components * size_t(memory->size.x) * size_t(memory->size.y));
    memory->pixels = pixels->data();
    memory->rowBytes = components * sizeof(T) * size_t(memory->size.x);
    memory->shown = 0;
  }
  return memory->shown != 0 && !pixels->empty();
}

/// The buffer to show, and how.
struct PictureRequest {
  hd::RenderBuffer* buffer = nullptr;  // null: none
  DataKind kind = DataKind::light;
  std::shared_ptr<const hd::PixelTransform> display;  // of kind light
  uint64_t version = 0;                               // another one writes all pixels again
  std::shared_ptr<const hd::RenderBuffer> kept;       // `buffer`, where it must outlive the request
  bool operator==(const PictureRequest&) const = default;
};

class PictureFetcher {
 public:
  PictureFetcher();
  ~PictureFetcher();  // waits for the picture that is being made
  PictureFetcher(const PictureFetcher&) = delete;
  PictureFetcher& operator=(const PictureFetcher&) = delete;

  /// Begins to bring the pictures of both requests up to date, unless that is going on. Buffers must outlive this.
  void fetch(const PictureRequest& left, const PictureRequest& right);
  /// Exchanges *picture for the newest one of the request; false if it is the newest already. Never waits long.
  bool take(bool right, Picture* picture);
  bool busy() const;
  /// Waits, and then uses no buffer until the next fetch.
  void forget();

 private:
  /// The range of the numbers that a buffer holds, and what it was found in.
  struct Range {
    std::array<float, 2> of(hd::RenderBuffer* now);
    const hd::RenderBuffer* buffer = nullptr;
    uint64_t found_in = 0;  // generation of the buffer
    std::chrono::steady_clock::time_point found_at;
    hd::PixelMemory memory;
    std::vector<float> values;
    std::array<float, 2> range{0, 1};
  };
  struct Side {
    PictureRequest request;
    hd::PixelMemory memory;
    std::unique_ptr<hd::PixelTransform> data;
    Range numbers;
    std::array<float, 2> range{0, 0};  // of `data`
    Picture made;                      // by the thread alone
    Picture ready;                     // under the lock
  };
  void run();
  void make(Side* side, const PictureRequest& request);

  mutable std::mutex mutex_;
  std::condition_variable wake_;
  std::condition_variable idle_;
  bool asked_ = false, busy_ = false, end_ = false;
  PictureRequest requests_[2];
  Side sides_[2];
  std::thread thread_;
};

}  // namespace alabaster::view
