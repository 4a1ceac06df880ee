// A scene of named fields that an index draws, for tests of scene_fields.h.
#pragma once

#include <gtest/gtest.h>

#include "delegate/host/scene_fields.h"
#include "testenv/unit/delegate/host/fake_delegate.h"

namespace alabaster::hd::host {

inline const Array<int32_t> kInts{0, 1, 2, 3};
inline const Array<float> kFloats{1, 2};
inline const Matrix4d kMoved(1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 1, 2, 3, 1);

inline Value samples(const Value& first, const Value& second) {
  return std::make_shared<const TimeSamples<Value>>(TimeSamples<Value>{{0, 1}, {first, second}});
}
inline Value words(std::initializer_list<Token> all) {
  return Array<Token>(std::vector<Token>(all));
}

/// A scene that an index draws by a delegate of no consequence.
struct DrawnScene {
  FakeDelegate delegate;
  RenderIndex index{&delegate};
  RetainedSceneDelegate scene;

  DrawnScene() { scene.Populate(&index); }
  void set(const Path& path, const Token& kind, const Fields& fields) {
    const SetResult result = SetPrim(&scene, path, kind, fields);
    EXPECT_EQ(result.fault, "") << path.str();
    index.SyncAll();
  }
  /// Returns the bits that the edit marks.
  DirtyBits edit(const Path& path, const Fields& fields) {
    const SetResult result = EditPrim(&scene, path, fields);
    EXPECT_TRUE(result.found);
    EXPECT_EQ(result.fault, "") << fields[0].first;
    const DirtyBits marked = index.GetChangeTracker().Get(path);
    index.SyncAll();
    return marked;
  }
};

}  // namespace alabaster::hd::host
