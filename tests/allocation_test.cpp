// SPDX-License-Identifier: MIT
// Its own program: it counts every allocation of the process.
#include <gtest/gtest.h>

#include <atomic>

#include "hand_film.hpp"

namespace {
std::atomic<int> allocations = 0;
std::atomic<std::size_t> allocated_bytes = 0;  // freed or not
}  // namespace

#if defined(__SANITIZE_ADDRESS__)  // GCC
#define HANDYAR_UNDER_ASAN
#elif defined(__has_feature)  // Clang
#if __has_feature(address_sanitizer)
#define HANDYAR_UNDER_ASAN
#endif
#endif

#if defined(HANDYAR_UNDER_ASAN)
// Declared in sanitizer/allocator_interface.h, which GCC's packages leave out.
extern "C" int __sanitizer_install_malloc_and_free_hooks(void (*on_malloc)(const volatile void*,
                                                                           std::size_t),
                                                         void (*on_free)(const volatile void*));
namespace {
const int kInstalled = __sanitizer_install_malloc_and_free_hooks(
    [](const volatile void*, std::size_t n) {
      ++allocations;
      allocated_bytes += n;
    },
    [](const volatile void*) {});
}
#elif defined(__GLIBC__)
extern "C" {
void* __libc_malloc(std::size_t);
void* __libc_calloc(std::size_t, std::size_t);
void* __libc_realloc(void*, std::size_t);
void* __libc_memalign(std::size_t, std::size_t);
void* malloc(std::size_t n) noexcept {
  ++allocations;
  allocated_bytes += n;
  return __libc_malloc(n);
}
void* calloc(std::size_t n, std::size_t size) noexcept {
  ++allocations;
  allocated_bytes += n * size;
  return __libc_calloc(n, size);
}
void* realloc(void* p, std::size_t n) noexcept {
  ++allocations;
  allocated_bytes += n;
  return __libc_realloc(p, n);
}
void* aligned_alloc(std::size_t alignment, std::size_t n) noexcept {
  ++allocations;
  allocated_bytes += n;
  return __libc_memalign(alignment, n);
}
}
#else
#define HANDYAR_CANNOT_COUNT
#endif

namespace handyar {
namespace {

using test::Film;
using test::Picture;

/// Allocations of `frames` further calls of process().
int count(Film& film, int frames) {
  int total = 0;
  for (int i = 0; i < frames; ++i) {
    film.time_s += 1 / film.fps;
    ++film.frame;
    film.T_camera_hand = film.pose_at(film.time_s);
    const Picture picture = film.picture();
    const ImageView view = picture.view();
    const int before = allocations;
    film.result = film.tracker.process(view, film.time_s);
    (void)film.tracker.predict(film.time_s + 0.02);
    (void)film.tracker.mask();
    total += allocations - before;
  }
  return total;
}

class Allocations : public testing::Test {
 protected:
  void SetUp() override {
#if defined(HANDYAR_CANNOT_COUNT)
    GTEST_SKIP() << "no way to count allocations here";
#endif
  }
};

TEST_F(Allocations, AreCounted) {
  const int before = allocations;
  const Picture picture(160, 120);
  EXPECT_GT(allocations, before);
}

TEST_F(Allocations, NoneAfterTheFirstFrame) {
  Film film;
  film.textured = true;
  EXPECT_GT(count(film, 1), 0);
  EXPECT_EQ(count(film, 30), 0) << "acquiring and tracking";
  EXPECT_EQ(film.result.state, State::tracking);
  film.present = false;
  EXPECT_EQ(count(film, 30), 0) << "lost, searching the whole frame";
  EXPECT_NE(film.result.state, State::tracking);
  film.present = true;
  EXPECT_EQ(count(film, 20), 0) << "finding it again";
  EXPECT_EQ(film.result.state, State::tracking);
  film.hand.state.posture = {{-0.7, 0, 0, 0, 0}, {0.7, 1.35, 1.35, 1.35, 1.35}};
  EXPECT_EQ(count(film, 20), 0) << "closed to a fist";
  EXPECT_EQ(film.result.gesture, Gesture::fist);
  film.tracker.reset();
  film.noise = 60;
  EXPECT_EQ(count(film, 10), 0) << "noise";
}

/// Bytes that a tracker takes in all for frames of this size.
std::size_t memory(int width, int height) {
  const Picture picture(width, height);
  const std::size_t before = allocated_bytes;
  HandTracker tracker(Camera::from_field_of_view(width, height), average_adult_hand());
  tracker.process(picture.view(), 0);
  return allocated_bytes - before;
}

TEST_F(Allocations, TakeAsMuchAsIsDocumented) {
  EXPECT_LT(memory(640, 480), 4'000'000u);
  EXPECT_LT(memory(1920, 1080), 4'800'000u);
}

}  // namespace
}  // namespace handyar
