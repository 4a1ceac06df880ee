// Renders that go on from the state of another.
#include "core/session/render_state.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstring>
#include <random>
#include <span>

#include "core/session/render_session.h"
#include "core/session/running_render.h"
#include "testenv/support/scene_builder.h"

namespace alabaster {
namespace {

using Blocks = std::vector<std::vector<std::byte>>;

BlockSink into(Blocks* blocks) {
  return [blocks](std::span<const std::byte> block) {
    blocks->emplace_back(block.begin(), block.end());
    return true;
  };
}

BlockSource from(const Blocks& blocks) {
  return [&blocks, next = size_t(0)](size_t most, std::vector<std::byte>* block) mutable {
    if (next == blocks.size() || blocks[next].size() > most) return false;
    *block = blocks[next++];
    return true;
  };
}

std::shared_ptr<RenderState> read(const Blocks& blocks) {
  auto state = std::make_shared<RenderState>();
  try {
    return read_state(from(blocks), MemoryBudget(size_t(1) << 30), state.get()) ? state : nullptr;
  } catch (const MemoryRefused&) {
    return nullptr;
  }
}

RenderRequest request_of(uint32_t samples) {
  RenderRequest request = testing::mixed_request(samples);
  request.aovs = ~AovSet{0} & ~aov_bit(Aov::denoised);
  request.settings.threads = 2;
  return request;
}

// All that a film holds.
std::vector<std::byte> contents(const Film& film) {
  std::vector<std::byte> bytes;
  for (int t = 0; t < film.tile_count(); ++t) {
    FilmTile tile = film.load_tile(t);
    for (const auto& plane : tile.planes()) bytes.insert(bytes.end(), plane.begin(), plane.end());
  }
  return bytes;
}

// Renders until `seconds` have passed and returns the state then; empty if it was too early or too late for one.
Blocks state_after(const RenderRequest& request, double seconds) {
  RenderSession session;
  session.start(request);
  session.wait(seconds);
  Blocks blocks;
  if (!session.save(into(&blocks))) return {};
  return blocks;
}

// The render, interrupted again and again at random moments.
std::shared_ptr<const Film> in_pieces(RenderRequest request, unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> moment(0, 0.06);
  Blocks blocks;
  for (int i = 0; i < 8; ++i) {
    request.resumed = blocks.empty() ? nullptr : read(blocks);
    if (Blocks later = state_after(request, moment(random)); !later.empty()) blocks = std::move(later);
  }
  request.resumed = read(blocks);
  EXPECT_TRUE(request.resumed);
  RenderSession session;
  session.start(request);
  session.wait(1e9);
  EXPECT_EQ(session.progress().state, SessionState::finished);
  EXPECT_TRUE(session.progress().noise.known);
  const RenderSettings& settings = request.settings;
  if (!settings.adaptive && settings.target_error == 0) {
    EXPECT_EQ(session.progress().samples_done, session.progress().pixels * settings.samples);
  }
  return session.film();
}

std::shared_ptr<const Film> at_once(const RenderRequest& request) {
  RenderSession session;
  session.start(request);
  session.wait(1e9);
  return session.film();
}

// promise: farm.checkpoint.bits, farm.checkpoint.no_wait
TEST(RenderState, InterruptedRenderResumesToTheSameBytes) {
  const RenderRequest request = request_of(20);
  const auto whole = contents(*at_once(request));
  for (unsigned seed = 0; seed < 4; ++seed)
    ASSERT_TRUE(contents(*in_pieces(request, seed)) == whole) << "seed " << seed;
}

// promise: farm.checkpoint.bits
TEST(RenderState, AdaptiveRenderResumesToTheSameBytes) {
  RenderRequest request = request_of(40);
  request.settings.adaptive = true;
  const auto whole = contents(*at_once(request));
  for (unsigned seed = 0; seed < 4; ++seed)
    ASSERT_TRUE(contents(*in_pieces(request, seed)) == whole) << "seed " << seed;
}

// promise: farm.checkpoint.bits
TEST(RenderState, RenderWithTargetErrorResumesToTheSameBytes) {
  RenderRequest request = request_of(4096);
  request.settings.target_error = 0.15f;
  const auto whole = contents(*at_once(request));
  for (unsigned seed = 0; seed < 4; ++seed)
    ASSERT_TRUE(contents(*in_pieces(request, seed)) == whole) << "seed " << seed;
}

// Presets preview and draft set both. Pixels that ended before others are kept aside with all their planes.
RenderRequest decided_request() {
  RenderRequest request = request_of(4096);
  request.settings.adaptive = true;
  request.settings.target_error = 0.02f;
  return request;
}

// A render of `request` that the time limit ends `left` seconds after it began, first samples included.
RenderRequest with_little_time(RenderRequest request, double left) {
  constexpr double kBefore = 10;
  request.resumed = std::make_shared<RenderState>();
  request.resumed->film = std::make_shared<Film>(request.data_window, request.aovs, film_extras(request.settings));
  request.resumed->wall_seconds = kBefore;
  request.settings.time_limit = static_cast<float>(kBefore - kFirstSampleGrace + left);
  request.settings.threads = 1;
  return request;
}

// The first samples of the frame take longer than its limit. Where no sample is, nothing shows.
TEST(RenderState, AFirstPassThatTheTimeLimitCutsShortGoesOn) {
  for (const bool decided : {false, true}) {
    RenderRequest request = decided ? decided_request() : request_of(3);
    request.settings.target_error = decided ? 0.5f : 0.0f;
    request.width = request.height = 256;
    request.data_window = {3, 5, 270, 250};
    RenderProgress progress;
    Blocks after;
    std::shared_ptr<const Film> cut;
    for (double left = 0.02; left < 5; left *= 1.5) {  // machines differ
      RenderSession session;
      session.start(with_little_time(request, left));
      ASSERT_TRUE(session.wait(60));
      progress = session.progress();
      cut = session.film();
      after.clear();
      ASSERT_TRUE(session.save(into(&after)));
      if (progress.samples_done > 0) break;
    }
    EXPECT_EQ(progress.state, SessionState::finished);
    ASSERT_LT(progress.samples_done, progress.pixels);
    EXPECT_EQ(progress.pixels_without_sample, progress.pixels - progress.samples_done);
    EXPECT_FALSE(progress.noise.known);
    const auto counts = cut->resolve_int(Aov::sample_count);
    EXPECT_EQ(std::count(counts.begin(), counts.end(), 0), static_cast<int64_t>(progress.pixels_without_sample));
    const auto alpha = cut->resolve_float(Aov::alpha);
    for (int t = 0; t < cut->tile_count(); ++t) {
      if (cut->load_tile(t).most_samples() > 0) continue;
      const PixelRect r = cut->tile_rect(t);
      EXPECT_EQ(alpha[static_cast<size_t>((r.y0 - 5) * 267 + r.x0 - 3)], 0) << t;
    }
    request.resumed = read(after);
    ASSERT_TRUE(request.resumed);
    const auto on = contents(*at_once(request));
    request.resumed = nullptr;
    EXPECT_TRUE(on == contents(*at_once(request))) << decided;
  }
}

bool has_ended_groups(const Blocks& blocks) {
  const auto state = read(blocks);
  return state && state->stopping.ended() != 0;
}

// The first state that is saved while the render goes on, before a group of pixels ends or after. Empty: none came.
Blocks state_of_groups(RenderSession* session, bool ended) {
  while (!session->wait(0.001)) {
    Blocks blocks;
    if (session->save(into(&blocks)) && read(blocks) && has_ended_groups(blocks) == ended) return blocks;
  }
  return {};
}

// The same from a render that may be too quick for it.
Blocks state_of_groups(const RenderRequest& request, bool ended) {
  for (int attempt = 0; attempt < 20; ++attempt) {
    RenderSession session;
    session.start(request);
    if (Blocks blocks = state_of_groups(&session, ended); !blocks.empty()) return blocks;
  }
  return {};
}

// An adaptive render that ends at an error of two per cent.
class AdaptiveRender {
 public:
  AdaptiveRender() {
    request_.width = request_.height = 48;
    request_.data_window = {0, 0, 48, 48};
    RenderSession session;
    session.start(request_);
    session.wait(1e9);
    whole_ = contents(*session.film());
    samples_ = session.progress().samples_done;
  }
  const RenderRequest& request() const { return request_; }
  void expect_the_same_from(const Blocks& blocks) const {
    RenderRequest request = request_;
    request.resumed = read(blocks);
    ASSERT_TRUE(request.resumed);
    RenderSession session;
    session.start(request);
    session.wait(1e9);
    EXPECT_EQ(session.progress().state, SessionState::finished);
    EXPECT_TRUE(contents(*session.film()) == whole_);
    EXPECT_EQ(session.progress().samples_done, samples_);
  }

 private:
  RenderRequest request_ = decided_request();
  std::vector<std::byte> whole_;
  uint64_t samples_ = 0;
};

TEST(RenderState, AnAdaptiveRenderGoesOnFromBeforeAGroupOfPixelsEndsAndFromAfter) {
  const AdaptiveRender render;
  for (const bool ended : {false, true}) {
    const Blocks blocks = state_of_groups(render.request(), ended);
    ASSERT_FALSE(blocks.empty()) << ended;
    render.expect_the_same_from(blocks);
  }
}

TEST(RenderState, AnAdaptiveRenderGoesOnAfterAStop) {
  const AdaptiveRender render;
  for (const bool ended : {false, true}) {
    Blocks blocks;
    for (int attempt = 0; attempt < 20 && blocks.empty(); ++attempt) {
      RenderSession session;
      session.start(render.request());
      if (state_of_groups(&session, ended).empty()) continue;
      session.stop();
      if (!session.save(into(&blocks)) || has_ended_groups(blocks) != ended) blocks.clear();
    }
    ASSERT_FALSE(blocks.empty()) << ended;
    render.expect_the_same_from(blocks);
  }
}

TEST(RenderState, AnAdaptiveRenderGoesOnAfterATimeLimit) {
  const AdaptiveRender render;
  for (const bool ended : {false, true}) {
    Blocks blocks;
    RenderRequest request = render.request();
    for (int attempt = 0; attempt < 20 && blocks.empty(); ++attempt) {
      const auto before = read(state_of_groups(render.request(), ended));
      ASSERT_TRUE(before) << ended;
      request.resumed = before;
      request.settings.time_limit = static_cast<float>(before->wall_seconds + 0.02);
      RenderSession session;
      session.start(request);
      session.wait(1e9);
      if (!session.save(into(&blocks)) || has_ended_groups(blocks) != ended) blocks.clear();
    }
    ASSERT_FALSE(blocks.empty()) << ended;
    render.expect_the_same_from(blocks);
  }
}

// promise: farm.resume.samples
TEST(RenderState, AFinishedRenderGoesOnToMoreSamples) {
  RenderRequest request = request_of(3);
  const auto blocks = [&] {
    RenderSession session;
    session.start(request);
    session.wait(1e9);
    Blocks all;
    EXPECT_TRUE(session.save(into(&all)));
    return all;
  }();
  request.settings.samples = 7;
  const auto whole = contents(*at_once(request));
  request.resumed = read(blocks);
  EXPECT_TRUE(contents(*at_once(request)) == whole);
}

// promise: farm.checkpoint.parts
TEST(RenderState, PartsAddUpToTheWhole) {
  RenderRequest request = request_of(21);
  const auto whole = contents(*at_once(request));
  for (const std::vector<uint32_t>& cuts :
       std::vector<std::vector<uint32_t>>{{0, 8, 21}, {0, 1, 2, 17, 21}, {0, 20, 21}}) {
    std::vector<Blocks> parts;
    for (size_t i = 1; i < cuts.size(); ++i) {
      request.settings.first_sample = cuts[i - 1];
      request.settings.samples = cuts[i];
      RenderSession session;
      session.start(request);
      session.wait(1e9);
      ASSERT_TRUE(session.save(into(&parts.emplace_back())));
    }
    const auto sum = read(parts[0]);
    ASSERT_TRUE(sum);
    for (size_t i = 1; i < parts.size(); ++i) ASSERT_TRUE(append_state(from(parts[i]), sum.get()));
    EXPECT_TRUE(contents(*sum->film) == whole) << cuts.size() - 1 << " parts";
    EXPECT_FALSE(append_state(from(parts[1]), sum.get())) << "it is there already";
  }
}

TEST(RenderState, StoppedRenderHasAState) {
  RenderRequest request = request_of(100000);
  RenderSession session;
  Blocks blocks;
  EXPECT_FALSE(session.save(into(&blocks))) << "nothing was rendered";
  session.start(request);
  session.wait(0.02);
  session.stop();
  EXPECT_TRUE(session.save(into(&blocks)));
  EXPECT_TRUE(read(blocks));
  EXPECT_FALSE(session.save([](std::span<const std::byte>) { return false; }));
}

// The blocks of a state whose time is `from`, with another.
Blocks with_time(Blocks blocks, double from, double to) {
  std::vector<std::byte>& head = blocks[0];
  const auto bytes = std::as_bytes(std::span(&from, 1));
  const auto found = std::search(head.begin(), head.end(), bytes.begin(), bytes.end());
  EXPECT_NE(found, head.end());
  if (found != head.end()) std::memcpy(&*found, &to, sizeof to);
  return blocks;
}

// The render's clock continues from there, and holds nanoseconds.
TEST(RenderState, RenderTimeOfAStateFitsAClock) {
  RenderSession session;
  session.start(request_of(2));
  ASSERT_TRUE(session.wait(60));
  Blocks saved;
  ASSERT_TRUE(session.save(into(&saved)));
  RenderState state = *read(saved);
  state.wall_seconds = 1e9;
  Blocks blocks;
  ASSERT_TRUE(write_state(state, into(&blocks)));
  ASSERT_TRUE(read(blocks));
  EXPECT_EQ(read(blocks)->wall_seconds, 1e9);
  EXPECT_FALSE(read(with_time(blocks, 1e9, 2e29)));
}

// The checkpoint that it writes is read again.
TEST(RenderState, LongestRenderTimeSaturatesOnResume) {
  RenderRequest request = request_of(2);
  RenderSession first;
  first.start(request);
  ASSERT_TRUE(first.wait(60));
  Blocks saved, again;
  ASSERT_TRUE(first.save(into(&saved)));
  auto oldest = std::make_shared<RenderState>(*read(saved));
  oldest->wall_seconds = 1e9;
  request.resumed = oldest;
  request.settings.samples = 4;
  RenderSession next;
  next.start(request);
  ASSERT_TRUE(next.wait(60));
  EXPECT_GT(next.progress().wall_seconds, 1e9);
  ASSERT_TRUE(next.save(into(&again)));
  ASSERT_TRUE(read(again));
  EXPECT_EQ(read(again)->wall_seconds, 1e9);
}

// Whatever the bytes are, they are refused or give a state; sanitizers see the rest.
// promise: farm.checkpoint.damage, security.memory_safety
TEST(RenderState, DamagedBytesAreRefused) {
  RenderRequest request = request_of(24);
  request.data_window = {0, 0, 40, 8};
  request.settings.adaptive = true;
  RenderSession session;
  session.start(request);
  session.wait(1e9);
  Blocks good;
  ASSERT_TRUE(session.save(into(&good)));
  ASSERT_TRUE(read(good));
  std::mt19937 random(1);
  size_t refused = 0;
  for (int i = 0; i < 3000; ++i) {
    Blocks bad = good;
    std::vector<std::byte>& block = bad[i % 2 ? 0 : random() % bad.size()];
    for (unsigned flips = random() % 4 + 1; flips > 0; --flips)
      block[random() % block.size()] = static_cast<std::byte>(random());
    refused += !read(bad);
  }
  EXPECT_GT(refused, 500u);
  for (size_t i = 0; i < good.size(); ++i) {
    EXPECT_FALSE(read(Blocks(good.begin(), good.begin() + static_cast<std::ptrdiff_t>(i)))) << i << " blocks";
    Blocks bad = good;
    bad[i].pop_back();
    EXPECT_FALSE(read(bad));
    bad[i].resize(bad[i].size() + 2);
    EXPECT_FALSE(read(bad));
  }
  RenderState state;
  EXPECT_THROW(read_state(from(good), MemoryBudget(1000), &state), MemoryRefused);
}

}  // namespace
}  // namespace alabaster
