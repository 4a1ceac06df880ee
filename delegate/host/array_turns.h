// An array that is edited element by element while threads still read it as it was.
// Internal to this room.
#pragma once

#include <algorithm>
#include <deque>
#include <future>
#include <mutex>
#include <system_error>
#include <tuple>
#include <type_traits>

#include "delegate/api/types.h"

namespace alabaster::hd::host {

/// Copies of one array that take turns: an edit is written into a copy that nobody reads any more, so it costs what
/// has changed since that copy was the latest. One thread at a time.
template <class T>
class ArrayTurns {
 public:
  /// `now` with the elements from `first` on replaced. `now` is what the last edit returned, or another array: then all
  /// of it is copied. The elements lie within it.
  Array<T> edit(const Array<T>& now, size_t first, const Array<T>& elements) {
    if (!is_latest(now)) begin(now);
    Copy copy = pool_->take();
    bring_up_to_date(&copy, now);
    std::copy(elements.begin(), elements.end(), copy.values.begin() + static_cast<std::ptrdiff_t>(first));
    changes_.push_back({first, elements.size()});
    if (changes_.size() > kMostChanges) changes_.pop_front();
    copy.edit = ++edits_;
    const auto lent = std::make_shared<const Lent>(std::move(copy), pool_);
    latest_ = lent->copy.values.data();
    return Array<T>(lent, latest_, size_);
  }
  bool is_latest(const Array<T>& array) const { return array.data() == latest_ && array.size() == size_; }

 private:
  static constexpr size_t kMostChanges = 64, kMostCopies = 3, kWorthAThread = size_t(1) << 20;
  struct Copy {
    std::vector<T> values;  // empty: none yet
    uint64_t edit = 0;      // the last that it has
  };
  /// The copies that nobody reads. Any thread.
  class Pool {
   public:
    Pool() { free_.reserve(kMostCopies); }
    Copy take() {
      const std::lock_guard lock(mutex_);
      if (free_.empty()) return {};
      Copy copy = std::move(free_.back());
      free_.pop_back();
      return copy;
    }
    void give(Copy* copy) {
      const std::lock_guard lock(mutex_);
      if (free_.size() < kMostCopies) free_.push_back(std::move(*copy));
    }

   private:
    std::mutex mutex_;
    std::vector<Copy> free_;
  };
  /// A copy that is read.
  struct Lent {
    Lent(Copy taken, std::shared_ptr<Pool> from) : copy(std::move(taken)), pool(std::move(from)) {}
    ~Lent() { pool->give(&copy); }
    Lent(const Lent&) = delete;
    Lent& operator=(const Lent&) = delete;
    Copy copy;
    std::shared_ptr<Pool> pool;
  };
  struct Change {
    size_t first = 0, count = 0;
  };

  void begin(const Array<T>& now) {
    pool_ = std::make_shared<Pool>();
    changes_.clear();
    size_ = now.size();
    if (size_ * sizeof(T) < kWorthAThread) return;
    try {
      spares_ = std::async(std::launch::async, &ArrayTurns::make_spares, pool_, now, edits_);
    } catch (const std::system_error&) {
      // Without a thread the next edits copy.
    }
  }
  // The first touch of memory waits for the system: the host's thread does so once.
  static void make_spares(const std::shared_ptr<Pool>& pool, const Array<T>& now, uint64_t edit) {
    for (size_t i = 1; i < kMostCopies; ++i) {
      Copy copy{std::vector<T>(now.begin(), now.end()), edit};
      pool->give(&copy);
    }
  }
  void bring_up_to_date(Copy* copy, const Array<T>& now) const {
    const uint64_t missed = edits_ - copy->edit;
    if (copy->values.empty() || missed > changes_.size()) {
      copy->values.assign(now.begin(), now.end());
      return;
    }
    for (auto change = changes_.end() - static_cast<std::ptrdiff_t>(missed); change != changes_.end(); ++change)
      std::copy_n(now.begin() + change->first, change->count,
                  copy->values.begin() + static_cast<std::ptrdiff_t>(change->first));
  }

  std::shared_ptr<Pool> pool_;
  std::future<void> spares_;    // ends before this does
  std::deque<Change> changes_;  // the latest edits
  uint64_t edits_ = 0;
  const T* latest_ = nullptr;
  size_t size_ = 0;
};

/// An array of one of the types that Sync takes as they are, and the copies of it.
class EditedArray {
 public:
  /// Empty: it is of another type, `elements` are, or they lie beyond its end.
  Value edit(const Value& now, size_t first, const Value& elements) {
    return of_their_type(now, first, elements, [&]<class T>(const Array<T>& array, const Array<T>& part) -> Value {
      return std::get<ArrayTurns<T>>(turns_).edit(array, first, part);
    });
  }
  /// The same of a copy that takes no turns.
  static Value copy(const Value& now, size_t first, const Value& elements) {
    return of_their_type(now, first, elements, [&]<class T>(const Array<T>& array, const Array<T>& part) -> Value {
      std::vector<T> values(array.begin(), array.end());
      std::copy(part.begin(), part.end(), values.begin() + static_cast<std::ptrdiff_t>(first));
      return Array<T>(std::move(values));
    });
  }
  /// `elements` are of the type of `now`, and lie within it.
  static bool fits(const Value& now, size_t first, const Value& elements) {
    return !of_their_type(now, first, elements, [](const auto&, const auto&) { return Value(true); }).empty();
  }
  /// True if `now` is what the last edit() returned.
  bool is_latest(const Value& now) const {
    return std::apply([&](const auto&... turns) { return (is_latest_of(turns, now) || ...); }, turns_);
  }

 private:
  template <class T>
  static bool is_latest_of(const ArrayTurns<T>& turns, const Value& now) {
    const auto* array = now.get<Array<T>>();
    return array && turns.is_latest(*array);
  }
  /// call(array, part) if `elements` fit; else an empty value.
  template <class Call>
  static Value of_their_type(const Value& now, size_t first, const Value& elements, const Call& call) {
    Value result;
    const auto try_type = [&](const auto& empty) {
      using Values = std::remove_cvref_t<decltype(empty)>;
      const auto *array = now.get<Values>(), *part = elements.get<Values>();
      if (array && part && first <= array->size() && part->size() <= array->size() - first)
        result = call(*array, *part);
    };
    try_type(Array<Vec3f>()), try_type(Array<Quatf>()), try_type(Array<Matrix4d>());
    return result;
  }

  std::tuple<ArrayTurns<Vec3f>, ArrayTurns<Quatf>, ArrayTurns<Matrix4d>> turns_;
};

}  // namespace alabaster::hd::host
