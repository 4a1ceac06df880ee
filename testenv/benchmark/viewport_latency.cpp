// How long a viewport waits: stop, restart, camera moves, Resolve. Loads a scene, drives the delegate as a host's user
// interface does, and prints Markdown. Only the public door is used.
//   viewport_latency SCENE [WIDTH HEIGHT THREADS REPEATS]
#include <algorithm>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <random>
#include <string>
#include <thread>
#include <vector>

#include "delegate/api/render_delegate.h"
#include "delegate/description/render_description.h"
#include "delegate/host/retained_scene_delegate.h"

using namespace alabaster::hd;

namespace {

using Clock = std::chrono::steady_clock;

double milliseconds_since(Clock::time_point start) {
  return std::chrono::duration<double, std::milli>(Clock::now() - start).count();
}

class Times {
 public:
  explicit Times(std::string name) : name_(std::move(name)) {}
  ~Times() {
    std::sort(all_.begin(), all_.end());
    const auto at = [&](double share) {
      return all_[static_cast<size_t>(share * static_cast<double>(all_.size() - 1))];
    };
    if (!all_.empty()) std::printf("| %s | %.2f | %.2f | %.2f |\n", name_.c_str(), at(0.5), at(0.99), all_.back());
  }
  template <class Call>
  void measure(const Call& call) {
    const auto start = Clock::now();
    call();
    all_.push_back(milliseconds_since(start));
  }

 private:
  std::string name_;
  std::vector<double> all_;
};

class Viewport {
 public:
  Viewport(const std::string& file, Vec2i size, int threads) : size_(size) {
    DelegateOptions options;
    options.diagnostics = [](const Diagnostic& d) {
      if (d.severity == Severity::error) std::fprintf(stderr, "%s: %s\n", d.where.c_str(), d.text.c_str());
    };
    options.settings = {{"samples", 1 << 20}, {"threads", threads}};
    delegate = CreateAlabasterRenderDelegate(kAbiVersion, &options);
    if (!delegate) std::exit(1);
    index_ = std::make_unique<host::RenderIndex>(delegate);
    const auto scene = description::LoadScene(file, &scene_, options.diagnostics);
    if (!scene.ok) std::exit(1);
    camera_ = scene_.GetAllRenderSettings().at(scene.settings).camera;
    const char* const aovs[] = {"color", "depth", "normal", "primId", "instanceId"};
    for (const char* aov : aovs)
      scene_.SetRenderBuffer(buffer_path(aov), {{size.x, size.y, 1}, delegate->GetDefaultAovDescriptor(aov).format});
    scene_.Populate(index_.get());
    index_->SyncAll();
    state.camera = camera_;
    state.framing = {{0, 0}, Vec2f(size), {0, 0, size.x, size.y}, 1};
    for (const char* aov : aovs) {
      buffers.push_back(static_cast<RenderBuffer*>(index_->GetBprim(buffer_path(aov))));
      state.aovBindings.push_back({aov, buffers.back(), {}});
    }
    pass = delegate->CreateRenderPass();
  }
  ~Viewport() {
    pass.reset();
    scene_.Depopulate();
    index_.reset();
    DestroyAlabasterRenderDelegate(delegate);
  }

  void move_camera() {
    host::CameraDescription camera = scene_.GetCameras().at(camera_);
    camera.transform[3][0] += 1e-4;
    scene_.SetCamera(camera_, camera);
    index_->SyncAll();
  }
  bool is_covered() const {
    const Dictionary stats = delegate->GetRenderStats();
    const auto found = stats.find("covered");
    return found != stats.end() && found->second.number_or(0) != 0;
  }
  void wait_until_covered() const {
    for (; !is_covered(); pass->Execute(state)) std::this_thread::sleep_for(std::chrono::microseconds(200));
  }
  // Pixels of the picture that show nothing at all.
  int empty_pixels() {
    buffers[0]->Resolve();
    const auto* pixels = static_cast<const float*>(buffers[0]->Map());
    int empty = 0;
    for (int i = 0; pixels && i < size_.x * size_.y; ++i) empty += pixels[4 * i + 3] == 0;
    buffers[0]->Unmap();
    return empty;
  }

  RenderDelegate* delegate;
  std::unique_ptr<RenderPass> pass;
  RenderPassState state;
  std::vector<RenderBuffer*> buffers;

 private:
  static Path buffer_path(const std::string& aov) { return "/buffers/" + aov; }
  Vec2i size_;
  std::unique_ptr<host::RenderIndex> index_;
  host::RetainedSceneDelegate scene_;
  Path camera_;
};

void run(Viewport* v, int repeats) {
  std::mt19937 random(7);
  const auto sleep = [&](int most) {
    std::this_thread::sleep_for(std::chrono::microseconds(std::uniform_int_distribution<int>(0, 1000 * most)(random)));
  };
  v->pass->Execute(v->state);
  v->wait_until_covered();
  const int background = v->empty_pixels();
  int most_empty = 0;

  std::printf("| | p50 ms | p99 ms | worst ms |\n| --- | --- | --- | --- |\n");
  {
    Times unchanged("Execute, nothing changed"), stop("Stop"), restart("Restart and Execute"),
        host("camera: Sync and Execute");
    Times first("camera: Execute to a covered frame"), all("five AOVs resolved, while rendering");
    Times again("five AOVs resolved again, 1 ms later");
    Times stopped("five AOVs resolved, stopped");
    const auto resolve = [&] {
      for (RenderBuffer* buffer : v->buffers) buffer->Resolve();
    };
    for (int i = 0; i < repeats; ++i) {
      sleep(30);
      unchanged.measure([&] { v->pass->Execute(v->state); });
      stop.measure([&] { v->delegate->Stop(); });
      stopped.measure(resolve);
      restart.measure([&] {
        v->delegate->Restart();
        v->pass->Execute(v->state);
      });
      sleep(30);
      host.measure([&] {
        v->move_camera();
        v->pass->Execute(v->state);
      });
      most_empty = std::max(most_empty, v->empty_pixels() - background);
      first.measure([&] { v->wait_until_covered(); });
      all.measure(resolve);
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
      again.measure(resolve);
    }
  }
  std::printf("\nMost pixels that were empty after a restart and had not been before: %d\n", most_empty);
}

}  // namespace

int main(int argc, char** argv) {
  if (argc < 2) {
    std::fprintf(stderr, "usage: viewport_latency SCENE [WIDTH HEIGHT THREADS REPEATS]\n");
    return 2;
  }
  const auto number = [&](int i, int otherwise) { return argc > i ? std::atoi(argv[i]) : otherwise; };
  const Vec2i size(number(2, 1280), number(3, 720));
  const int threads = number(4, 2), repeats = number(5, 100);
  std::printf("%s, %d x %d, %d threads, %d repeats\n\n", argv[1], size.x, size.y, threads, repeats);
  Viewport viewport(argv[1], size, threads);
  run(&viewport, repeats);
  return 0;
}
